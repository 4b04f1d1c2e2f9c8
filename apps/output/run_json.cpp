#include "apps/output/run_json.hpp"

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "dsp/fault.hpp"

namespace apps {

using Json = nlohmann::ordered_json;

Json read_run_json(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in)
    throw dsp::Fault(dsp::FaultKind::input, "run.incomplete",
                     fmt::format("{}: not there; want the folder of a finished run", file.string()));
  constexpr int deepest = 64;  // ours reach 8; taking a document apart recurses
  const auto shallow = [&](int depth, Json::parse_event_t, const Json&) {
    if (depth <= deepest) return true;
    throw dsp::Fault(dsp::FaultKind::input, "run.damaged",
                     fmt::format("{}: nested more than {} levels deep", file.string(), deepest));
  };
  try {
    return Json::parse(in, shallow);
  } catch (const Json::exception&) {
    throw dsp::Fault(dsp::FaultKind::input, "run.damaged", fmt::format("{}: no JSON document", file.string()));
  }
}

}  // namespace apps
