#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "apps/config/inputs.hpp"
#include "dsp/prepare.hpp"
#include "dsp/values/fault.hpp"
#include "ident/identify.hpp"

namespace apps {

// What is said of recordings, and what commands print that fit nothing, with the keys that scripts rely on. Numbers
// that do not exist are null with KEY_reason beside them; text is made valid UTF-8.

[[nodiscard]] std::string quality_json(const std::vector<Input>& inputs);
[[nodiscard]] std::string_view to_string(dsp::CheckStatus status);  ///< "ok", "note", "warning", "failed"
/// What `ardent check --json` prints.
[[nodiscard]] std::string checks_json(const std::vector<Input>& inputs);
/// `lines`: what the fault wants added to a file; `further`: what else is wrong. Both are left out where empty.
[[nodiscard]] std::string fault_json(std::string_view name, std::string_view kind, int exit_code,
                                     std::string_view message, std::string_view lines,
                                     const std::vector<dsp::Fault>& further);

/// One recording as `ardent info` shows it.
struct RecordingInfo {
  std::string file, container, sidecar;  ///< sidecar empty: none found
  double sample_rate_hz = 0.0;
  long long num_samples = 0;
  std::vector<dsp::Channel> channels;
  std::vector<dsp::Interval> bad;
  std::vector<dsp::Check> checks;
  std::vector<dsp::RangeSpec> ranges;
};
[[nodiscard]] std::string info_json(const std::vector<RecordingInfo>& recordings);

/// What `ardent init --json` prints: the files it wrote.
[[nodiscard]] std::string files_json(const std::vector<std::string>& files);

/// What `ardent terms --json` prints.
[[nodiscard]] std::string terms_json(const std::vector<ident::FunctionHelp>& signals,
                                     const std::vector<ident::FunctionHelp>& functions);

}  // namespace apps
