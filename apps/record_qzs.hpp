#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "apps/cli/simulate_command.hpp"
#include "apps/process/console.hpp"
#include "apps/process/output_folder.hpp"

namespace apps {

/// The rig's part of `ardent sim`: response.csv at 25.6 Hz; with `raw` also the recording with its sidecar and
/// truth.csv. What is true of it goes into `truth`. Returns the names of the files. Throws as run_simulate.
std::vector<std::string> record_qzs(const SimulateArguments& arguments, const OutputFolder& folder, Console& console,
                                    nlohmann::ordered_json& truth);

/// Only the recording at 25.6 kHz and its sidecar, into the folder `inside` of `folder`, which is there. Returns the
/// recording's name.
[[nodiscard]] std::string write_rig_recording(const SimulateArguments& arguments, const OutputFolder& folder,
                                              const std::string& inside, Console& console);

/// `ardent sim qzs --frc`: the rig's frequency response, up and down; frc.csv, frc.json, frc.svg. As record_qzs.
std::vector<std::string> sweep_qzs(const SimulateArguments& arguments, const OutputFolder& folder, Console& console,
                                   nlohmann::ordered_json& truth);

}  // namespace apps
