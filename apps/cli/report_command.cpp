#include "apps/cli/report_command.hpp"

#include <nlohmann/json.hpp>

#include "apps/output/run_json.hpp"

namespace apps {

void run_report(const std::filesystem::path& run, Console& console) {
  static_cast<void>(read_run_json(run / "manifest.json"));  // written last: without it the rest may be half a run
  console.result(read_run_file(run / (console.json() ? "equation.json" : "equation.txt")));
}

}  // namespace apps
