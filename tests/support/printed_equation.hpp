#pragma once
#include <filesystem>
#include <string>

namespace support {

/// The free run that a run folder claims, and the one that its printed equation makes of the record.
struct PrintedRun {
  std::string why_not;                  ///< not empty: there is none to compare
  double claimed = 0.0, reached = 0.0;  ///< NMSE of x over the test rows
};

/// Runs the chosen equation of a run folder, as equation.json prints it, over the recordings as prepared.csv has them,
/// from each measured state that metrics.json names: fixed steps, inputs interpolated by a windowed sinc, switches
/// found by halving. None of the program's own integrators takes part.
[[nodiscard]] PrintedRun printed_run(const std::filesystem::path& run);

/// The rms of x predicted less measured over the last share of a run's only recording, begun at its measured state
/// there.
[[nodiscard]] double printed_rms(const std::filesystem::path& run, double share);

/// Checks that both agree, where there is a free run: the rms of their errors within 1 % and 0.3 % of x, which is what
/// interpolation of the drive leaves.
void check_printed_equation(const std::filesystem::path& run);

/// The same of every run folder within a folder that was not checked yet: support::run does so after each command.
void check_printed_equations(const std::filesystem::path& folder);

}  // namespace support
