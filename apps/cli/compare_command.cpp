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
          "The equations of several runs side by side",
          {{"--output"}, {"--seed"}, {"--dry-run"}, {"--set"}},
          [](CLI::App& command) -> CommandBody {
            auto arguments = std::make_shared<Arguments>();
            command.add_option("RUN", arguments->runs, "Run folders")->required();
            command.add_option("--truth", arguments->truth, "truth.json of the simulation the recording came from");
            command.add_option("--method", arguments->method, "Method to show");
            return [=](const GlobalOptions& global, Console& console) {
              for (const auto& run : arguments->runs) check_finished_run(run, global.strict, console);
              console.result(comparison_of(arguments->runs, arguments->truth, arguments->method, console.json()));
              return 0;
            };
          }};
}

}  // namespace apps
