#include "apps/cli/report_command.hpp"

#include "apps/finished_run.hpp"
#include "apps/output/run_json.hpp"

namespace apps {

void run_report(const std::filesystem::path& run, bool strict, Console& console) {
  check_finished_run(run, strict, console);
  console.result(read_run_file(run / (console.json() ? "equation.json" : "equation.txt")));
}

}  // namespace apps
