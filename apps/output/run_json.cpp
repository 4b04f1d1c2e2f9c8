#include "apps/output/run_json.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "apps/text/json_parts.hpp"
#include "dsp/io/small_file.hpp"
#include "dsp/values/fault.hpp"
#include "dsp/values/names.hpp"

namespace apps {

using Json = nlohmann::ordered_json;

std::string read_run_file(const std::filesystem::path& file) {
  // The largest are the covariances of equation.json: 100 MB where some 500 terms are kept.
  return dsp::read_small_file(file, {.kind = dsp::FaultKind::input,
                                     .fault = "run.incomplete",
                                     .wanted = "the folder of a finished run",
                                     .most_bytes = 1ull << 30});
}

Json read_run_json(const std::filesystem::path& file) {
  const std::string bytes = read_run_file(file), name = dsp::clean_name(file.string());
  const auto damaged = [&](const char* what) {
    return dsp::Fault(dsp::FaultKind::input, "run.damaged", fmt::format("{}: {}", name, what));
  };
  try {
    return parsed_json(bytes);
  } catch (const Json::exception&) {
    throw damaged("no JSON document");
  } catch (const std::invalid_argument& error) {
    throw damaged(error.what());
  }
}

}  // namespace apps
