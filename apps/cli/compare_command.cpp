#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "apps/cli/command.hpp"
#include "apps/output/finished_run.hpp"
#include "apps/output/run_comparison.hpp"

namespace apps {

Command compare_command() {
  struct Arguments {
    std::vector<std::filesystem::path> runs;
    std::filesystem::path truth;
    std::string method = "fast_rvm";
  };
  return {"compare",
          "What changed between runs, and their equations side by side",
          {{"--output"}, {"--seed"}, {"--dry-run"}, {"--set"}, {"--force"}, {"--threads"}},
          [](CLI::App& command) -> CommandBody {
            auto arguments = std::make_shared<Arguments>();
            command.add_option("RUN", arguments->runs, "Run folders.")->required();
            command
                .add_option("--truth", arguments->truth, "truth.json of the simulation that the recording came from.")
                ->type_name("FILE");
            command.add_option("--method", arguments->method, "Method whose equation is shown.")->capture_default_str();
            return [=](const GlobalOptions& global, Console& console) {
              for (const auto& run : arguments->runs) check_finished_run(run, global.strict, console);
              console.result(comparison_of(arguments->runs, arguments->truth, arguments->method, console.json()));
              return 0;
            };
          },
          use_group,
          {"ardent compare monday-run tuesday-run", "ardent compare out/* --method sindy"}};
}

}  // namespace apps
