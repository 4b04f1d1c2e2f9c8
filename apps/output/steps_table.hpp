#pragma once
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "apps/config/inputs.hpp"
#include "dsp/regimes/steady_steps.hpp"

namespace apps {

/// Steps of a recording, by its name.
using RecordingSteps = std::pair<std::string, std::vector<dsp::SteadyStep>>;

/// Of the recordings that are stepped sines.
[[nodiscard]] std::vector<RecordingSteps> steady_steps(const std::vector<Input>& inputs);

/// steps.csv: recording, from_s, to_s, f_hz, drive_amplitude, amplitude_m, payload_amplitude_m, phase_deg, direction
/// (up, down), mode (locked, stick-slip, slip), drive_distortion, tag; cells that do not exist are empty.
[[nodiscard]] std::string steps_csv(const std::vector<RecordingSteps>& recordings);

/// One end result of a steps.csv.
struct StepPoint {
  double frequency_hz = 0.0, drive = 0.0, x_m = 0.0, y_m = 0.0;
  bool up = false, locked = false;
};
/// The rows tagged final of RUN/steps.csv; none if there is no such file. Throws dsp::Fault (input, "run.damaged").
[[nodiscard]] std::vector<StepPoint> read_final_steps(const std::filesystem::path& run);

}  // namespace apps
