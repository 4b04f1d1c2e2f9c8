#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "kinds/law.hpp"

namespace kinds {

/// Noise-free signals as the sensors and the clock give them, SI.
struct Signals {
  std::vector<double> x, v, a;  ///< Relative to the base.
  std::vector<double> input;    ///< f or ddr; empty in a decay.
  std::vector<double> base;     ///< r, where displacements of base and payload are recorded.
};

/// A column of the file, with noise, in the unit of its header.
struct Column {
  std::string header;
  std::vector<double> values;
};

/// A labelled record.
struct Record {
  std::string name;  ///< k017_gap
  bool right = false;
  Law law;
  std::string drive;       ///< noise, multisine, sweep, steps or decay.
  std::string excitation;  ///< force, base or none.
  double mass_kg = 1.0, noise = 0.0, rate_hz = 0.0, natural_hz = 0.0;
  double lag_s = 0.0;
  Motion motion;
  Signals signals;
  double share_term = 0.0;  ///< rms of what no candidate holds over that of a; 0 where it is in a sensor or the clock.
  double share_left = 0.0;  ///< rms of what the best combination of all candidates leaves over that of a.
  std::vector<Column> columns;
};

/// Even indices: a law of the default library; odd ones: another. The same for the same seed and index.
Record draw_record(std::uint64_t seed, std::uint64_t index);

/// rms of the part of the target that is orthogonal to all columns, over that of the target.
double left_over_share(std::vector<std::vector<double>> columns, std::vector<double> target);

/// Columns of the default library (polynomials to third order, sgn(v), the input).
std::vector<std::vector<double>> library_columns(const Signals& signals);

/// NAME.csv and its label NAME.json.
void write_record(const Record& record, const std::filesystem::path& folder);

}  // namespace kinds
