#include "apps/cli/report_command.hpp"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/output/run_json.hpp"
#include "dsp/fault.hpp"

namespace apps {
namespace {

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in)
    throw dsp::Fault(dsp::FaultKind::input, "run.incomplete",
                     fmt::format("{}: not there; want the folder of a finished `ardent run`", file.string()));
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

void run_report(const std::filesystem::path& run, Console& console) {
  static_cast<void>(read_run_json(run / "manifest.json"));  // written last: without it the rest may be half a run
  console.result(text_of(run / (console.json() ? "equation.json" : "equation.txt")));
}

}  // namespace apps
