#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "apps/cli/command.hpp"
#include "apps/output/finished_run.hpp"
#include "apps/output/run_json.hpp"

namespace apps {

Command report_command() {
  return {"report",
          "Prints the first screen of a finished run again; its page is RUN/report.html",
          {{"--output"}, {"--seed"}, {"--dry-run"}, {"--set"}, {"--force"}, {"--threads"}},
          [](CLI::App& command) -> CommandBody {
            auto run = std::make_shared<std::filesystem::path>();
            auto details = std::make_shared<bool>(false);
            command.add_option("RUN", *run, "Run folder.")->required();
            command.add_flag("--details", *details, "Every equation with its coefficients, errors and remarks.");
            return [=](const GlobalOptions& global, Console& console) {
              check_finished_run(*run, global.strict, console);
              const char* file = console.json() ? "equation.json" : *details ? "details.txt" : "equation.txt";
              console.result(read_run_file(*run / file));
              return 0;
            };
          },
          use_group,
          {"ardent report drive-run", "ardent report drive-run --json"}};
}

}  // namespace apps
