#include "apps/config/other_recording.hpp"

#include <utility>

#include "apps/config/recording_name.hpp"

namespace apps {

Input other_recording(Config config, RecordingConfig recording, std::size_t max_memory_bytes, int num_threads,
                      Console& console) {
  if (recording.name.empty()) recording.name = name_beside(recording.file, config);
  config.recordings = {completed(std::move(recording), config.recordings.front())};
  if (config.prepare.cutoff_hz > 0.0) {  // the band is the equation's; rates are those of the recording
    config.prepare.rate_hz = config.prepare.intermediate_rate_hz = 0.0;
    config.prepare.state_cutoff_hz = config.prepare.state_rolloff_hz = 0.0;
  }
  config.ranges.clear();  // they are times of other recordings
  config.segment_file.clear();
  std::vector<Input> inputs = prepare_inputs(config, max_memory_bytes, num_threads, console);
  settle(config, inputs, console);
  return std::move(inputs.front());
}

}  // namespace apps
