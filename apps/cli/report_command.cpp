#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "apps/cli/command.hpp"
#include "apps/output/finished_run.hpp"
#include "apps/output/run_json.hpp"

namespace apps {

Command report_command() {
  return {"report",
          "The page of a finished run again",
          {{"--output"}, {"--seed"}, {"--dry-run"}, {"--set"}, {"--force"}, {"--threads"}},
          [](CLI::App& command) -> CommandBody {
            auto run = std::make_shared<std::filesystem::path>();
            command.add_option("RUN", *run, "Run folder.")->required();
            return [=](const GlobalOptions& global, Console& console) {
              check_finished_run(*run, global.strict, console);
              console.result(read_run_file(*run / (console.json() ? "equation.json" : "equation.txt")));
              return 0;
            };
          },
          use_group,
          {"ardent report drive-run", "ardent report drive-run --json"}};
}

}  // namespace apps
