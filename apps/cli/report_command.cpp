#include <filesystem>
#include <memory>

#include "apps/cli/command.hpp"
#include "apps/output/finished_run.hpp"
#include "apps/output/run_json.hpp"

namespace apps {

namespace {

struct ReportArguments {
  std::filesystem::path run;
  bool details = false;
};

int report(const ReportArguments& arguments, const GlobalOptions& global, Console& console) {
  check_finished_run(arguments.run, global.strict, console);
  const char* file = console.json() ? "equation.json" : arguments.details ? "details.txt" : "equation.txt";
  console.result(read_run_file(arguments.run / file));
  return 0;
}

}  // namespace

Command report_command() {
  const auto typed = std::make_shared<ReportArguments>();
  return {.name = "report",
          .help = "Prints the first screen of a finished run again; its page is RUN/report.html",
          .group = use_group,
          .unused = {{"--output"}, {"--seed"}, {"--dry-run"}, {"--set"}, {"--force"}, {"--threads"}},
          .options = {{"RUN", &typed->run, "Run folder.", {.required = true}},
                      {"--details", &typed->details, "Every equation with its coefficients, errors and remarks."}},
          .run = [typed](const GlobalOptions& global, Console& console) { return report(*typed, global, console); },
          .examples = {"ardent report drive-run", "ardent report drive-run --json"}};
}

}  // namespace apps
