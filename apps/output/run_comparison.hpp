#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace apps {

/// The equations of several finished runs side by side, range by range, with coefficients of variation and NMSE, as
/// text or as JSON. `truth_file`: truth.json of a simulation, or empty: with it, standard deviations instead, and
/// whether the true values (in the units of the sensors that recorded them) are inside the 95 % intervals. The first
/// method of a run that does not have `method`. Throws dsp::Fault (input, "run.incomplete", "run.damaged") for a run
/// without fits.
[[nodiscard]] std::string comparison_of(const std::vector<std::filesystem::path>& run_folders,
                                        const std::filesystem::path& truth_file, const std::string& method,
                                        bool as_json);

}  // namespace apps
