#include "apps/run_json.hpp"

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "dsp/fault.hpp"

namespace apps {

nlohmann::ordered_json read_run_json(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in)
    throw dsp::Fault(dsp::FaultKind::input, "run.incomplete",
                     fmt::format("{}: not there; want the folder of a finished run", file.string()));
  try {
    return nlohmann::ordered_json::parse(in);
  } catch (const nlohmann::ordered_json::exception&) {
    throw dsp::Fault(dsp::FaultKind::input, "run.damaged", fmt::format("{}: no JSON document", file.string()));
  }
}

}  // namespace apps
