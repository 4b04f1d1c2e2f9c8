#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "apps/cli/simulate_command.hpp"
#include "apps/process/console.hpp"

namespace apps {

/// The rig's part of `ardent sim`: response.csv at 25.6 Hz; with `raw` also the recording with its sidecar and
/// truth.csv. What is true of it goes into `truth`. Returns the files written. Throws as run_simulate.
std::vector<std::filesystem::path> record_qzs(const SimulateArguments& arguments, Console& console,
                                              nlohmann::ordered_json& truth);

/// Only the recording at 25.6 kHz and its sidecar, into arguments.folder, which is there. Returns the recording's path.
[[nodiscard]] std::filesystem::path write_rig_recording(const SimulateArguments& arguments, Console& console);

/// `ardent sim qzs --frc`: the rig's frequency response, up and down; frc.csv, frc.json, frc.svg. As record_qzs.
std::vector<std::filesystem::path> sweep_qzs(const SimulateArguments& arguments, Console& console,
                                             nlohmann::ordered_json& truth);

}  // namespace apps
