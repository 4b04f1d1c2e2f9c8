#include "apps/config/other_recording.hpp"

#include <system_error>
#include <utility>

#include "dsp/io/sidecar.hpp"

namespace apps {

Input other_recording(Config config, RecordingConfig recording, std::size_t max_memory_bytes, Console& console) {
  const RecordingConfig& first = config.recordings.front();
  std::error_code ignored;
  if (recording.sidecar.empty() && !std::filesystem::exists(dsp::sidecar_path(recording.file), ignored)) {
    const auto own = first.sidecar.empty() ? dsp::sidecar_path(first.file) : first.sidecar;
    if (std::filesystem::exists(own, ignored)) recording.sidecar = own;
  }
  if (recording.use.empty()) recording.use = first.use;
  recording.uncalibrated = recording.uncalibrated || first.uncalibrated;
  config.recordings = {std::move(recording)};
  if (config.prepare.cutoff_hz > 0.0) {  // the band is the equation's; rates are those of the recording
    config.prepare.rate_hz = config.prepare.intermediate_rate_hz = 0.0;
    config.prepare.state_cutoff_hz = config.prepare.state_rolloff_hz = 0.0;
  }
  config.ranges.clear();  // they are times of other recordings
  config.segment_file.clear();
  std::vector<Input> inputs = prepare_inputs(config, max_memory_bytes, console);
  settle(config, inputs, console);
  return std::move(inputs.front());
}

}  // namespace apps
