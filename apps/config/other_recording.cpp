#include "apps/config/other_recording.hpp"

#include <fmt/format.h>

#include <utility>

#include "apps/config/recording_name.hpp"
#include "dsp/io/read_recording.hpp"

namespace apps {
namespace {

/// The equation's band, as far as a recording at a lower rate holds it.
void fit_band(const RecordingConfig& recording, std::size_t max_memory_bytes, dsp::PrepareOptions& prepare,
              Console& console) {
  const dsp::RecordingReader reader(recording.file, read_options(recording, max_memory_bytes));
  const double rate_hz = reader.description().sample_rate_hz;
  if (prepare.cutoff_hz < 0.5 * rate_hz) return;
  constexpr double usual = 0.4;  // of the rate, as where no band is stated
  console.warning("predict.band", fmt::format("{}: is recorded at {:.6g} Hz: the equation's band of {:.4g} Hz ends at "
                                              "{:.4g} Hz here",
                                              recording.name, rate_hz, prepare.cutoff_hz, usual * rate_hz));
  prepare.cutoff_hz = usual * rate_hz;
  prepare.rolloff_hz = 0.0;
}

}  // namespace

Input other_recording(Config config, RecordingConfig recording, std::size_t max_memory_bytes, int num_threads,
                      Console& console) {
  if (recording.name.empty()) recording.name = name_beside(recording.file, config);
  config.recordings = {completed(std::move(recording), config.recordings.front())};
  if (config.prepare.cutoff_hz > 0.0) {  // the band is the equation's; rates are those of the recording
    config.prepare.rate_hz = config.prepare.intermediate_rate_hz = 0.0;
    config.prepare.state_cutoff_hz = config.prepare.state_rolloff_hz = 0.0;
    fit_band(config.recordings.front(), max_memory_bytes, config.prepare, console);
  }
  config.ranges.clear();  // they are times of other recordings
  config.segment_file.clear();
  std::vector<Input> inputs = prepare_inputs(config, max_memory_bytes, num_threads, console);
  settle(config, inputs, console);
  return std::move(inputs.front());
}

}  // namespace apps
