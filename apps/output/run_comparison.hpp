#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace apps {

/// What differs between several finished runs (inputs by their bytes, settings, program), then their verdicts,
/// equations and NMSE range by range, as text of at most 120 columns or as JSON. Coefficients come with their
/// difference from the first run in standard deviations of that difference; more than four runs are rows. `truth_file`:
/// truth.json of a simulation, or empty: with it, whether the true values (in the units of the sensors that recorded
/// them) are inside the 95 % intervals. The first method of a run that does not have `method`. Throws dsp::Fault
/// (input, "run.incomplete", "run.damaged") for a run without fits.
[[nodiscard]] std::string comparison_of(const std::vector<std::filesystem::path>& run_folders,
                                        const std::filesystem::path& truth_file, const std::string& method,
                                        bool as_json);

}  // namespace apps
