#pragma once
#include <filesystem>
#include <functional>
#include <string>

#include "dsp/io/sound_file.hpp"
#include "sim/rig/rig_test.hpp"

namespace sim {

struct RigRecordingOptions {
  dsp::SoundContainer container = dsp::SoundContainer::rf64;
  std::filesystem::path shown = {};           ///< what messages call the file; empty: its path
  std::function<void(double)> progress = {};  ///< called with the fraction made; may throw to stop
};

/// The test's recording as a sound file of 24 bits: at raw_rate_hz as RawRecorder gives it, at a lower rate decimated,
/// flat up to 30 / 256 of it. Throws as dsp::SoundFileWriter; Diverged;
/// std::invalid_argument for a recording shorter than the filter to its rate.
void write_rig_recording(const RigTest& test, const std::filesystem::path& file, const RigRecordingOptions& options);

/// What a person at the rig would write into the recording's sidecar: nominal sensitivities, and that hands were at the
/// payload.
[[nodiscard]] std::string rig_sidecar(const RigTest& test);

}  // namespace sim
