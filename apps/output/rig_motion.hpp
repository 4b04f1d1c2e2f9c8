#pragma once
#include <functional>

#include "apps/output/output_folder.hpp"
#include "sim/rig/rig_truth.hpp"

namespace apps {

/// response.csv of a rig's test, exact motion at 25.6 Hz (t, x, v, a, r, dr, ddr), and `with_truth` truth.csv at 256 Hz
/// (t, x, v, r, ddr, mode); t counts from the recording's beginning on. Throws as sim::rig_truth and OutputFolder;
/// `progress` as there.
sim::RigTruth write_motion(const sim::RigTest& test, bool with_truth, const OutputFolder& folder,
                           const std::function<void(double)>& progress);

/// What these files take for each second, about.
[[nodiscard]] double motion_bytes_per_s(bool with_truth);

}  // namespace apps
