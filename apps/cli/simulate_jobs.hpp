#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "apps/cli/simulate_command.hpp"
#include "apps/output/output_folder.hpp"
#include "dsp/values/fault.hpp"
#include "sim/chain.hpp"

// What `ardent sim` does for one kind of system each: files into `folder`, what is true of them into `truth`. They
// return the names of the files and throw as run_simulate.

namespace apps {

inline constexpr double system_rate_hz = 100.0;  ///< of the systems of Section 4 of [QZS23], as there

/// The systems of Section 4: response.csv.
std::vector<std::string> simulate_system(const SimulateArguments& arguments, const OutputFolder& folder,
                                         Console& console, nlohmann::ordered_json& truth);

/// Several masses: response.csv with time_s, x1, x2 ... and f or r, at 200 Hz.
std::vector<std::string> simulate_chain(const SimulateArguments& arguments, const OutputFolder& folder,
                                        Console& console, nlohmann::ordered_json& truth);

/// The rig: response.csv at 25.6 Hz; with `raw` also the recording with its sidecar and truth.csv.
std::vector<std::string> simulate_rig(const SimulateArguments& arguments, const OutputFolder& folder, Console& console,
                                      nlohmann::ordered_json& truth);

/// The rig's frequency response, up and down: frc.csv, frc.json, frc.svg.
std::vector<std::string> sweep_rig(const SimulateArguments& arguments, const OutputFolder& folder, Console& console,
                                   nlohmann::ordered_json& truth);

/// Throws dsp::Fault (usage, "sim.option") where an option is set that the rig alone has.
void refuse_options_of_rig(const SimulateArguments& arguments);

/// The force or base motion of a recording: its channel of that role, else the only one. A duration of zero becomes
/// the recording's. Throws dsp::Fault (input, "sim.drive") where there is none.
[[nodiscard]] sim::Drive recorded_drive(const std::filesystem::path& file, bool is_base, double& duration_s);

/// White noise of this fraction of the standard deviation of a signal, by the seed and a number of its own.
void add_noise(Eigen::Ref<Eigen::VectorXd> signal, double fraction, std::uint64_t seed, std::uint64_t number);

/// A table as CSV, every digit of it.
[[nodiscard]] std::string csv_of(const std::vector<std::string>& names, const Eigen::MatrixXd& values);

/// What the rig refuses, as a fault: sim.option (usage).
[[nodiscard]] dsp::Fault refused_by_rig(const std::invalid_argument& error);

}  // namespace apps
