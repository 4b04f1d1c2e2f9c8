#pragma once
#include <optional>
#include <string>
#include <vector>

#include "dsp/column_filter.hpp"
#include "dsp/decimate.hpp"
#include "dsp/motion.hpp"
#include "dsp/recording.hpp"

namespace dsp {

enum class Recipe {
  matched,  ///< columns are formed first, on wide-band signals, and filtered after, each by the filter of the target
  paper,    ///< signals are filtered first and columns formed from them, as in [QZS23]
};

struct PrepareOptions {
  Recipe recipe = Recipe::matched;
  double rate_hz = 0.0;           ///< regression rate; 0: the record's own
  double cutoff_hz = 0.0;         ///< columns go to zero here; 0: 0.4 x regression rate
  double rolloff_hz = 0.0;        ///< where the taper begins; 0: 0.78125 x cutoff (8 of 10.24)
  double state_cutoff_hz = 0.0;   ///< band in which states are formed before their columns are filtered; 0: 20/10.24 x
  double state_rolloff_hz = 0.0;  ///< cutoff, as far as the bus rate allows (0.49 x); roll-off 0.64 x state cut-off
  double bus_rate_hz = 0.0;       ///< rate at which columns are formed when decimating; 0: 10 x regression rate
  AccelerationSource acceleration = AccelerationSource::automatic;
};

/// A recording ready for regression.
struct Prepared {
  std::string name;
  PrepareOptions options;  ///< with every default filled in
  Motion bus;              ///< wide-band signals at the bus rate: columns are formed from these ("matched")
  Motion signals;          ///< the same signals after the column filter, at the regression rate: prepared.csv,
                           ///< conditions, predictions, free run; columns of recipe "paper"
  ColumnFilter filter;     ///< from bus to regression rate
  std::optional<FilterSheet> decimation;
  std::vector<Interval> excluded;  ///< with margins and reasons; marked in both motions
  std::vector<Check> checks;
};

/// The options with nothing left to choose for a recording at this rate. Throws Fault (usage) for rates and frequencies
/// that do not fit each other.
[[nodiscard]] PrepareOptions resolved(const PrepareOptions& options, double sample_rate_hz);

/// From a recording in memory to signals ready for regression. Derivatives are taken over the whole record before
/// anything is cut. "matched": bus signals are formed in the wide state band, then each passes the column filter.
/// "paper": displacements are filtered first and differentiated after, in the band [rolloff_hz, cutoff_hz].
/// The recording's bad stretches are excluded with the reach of the filters as margin. Edge samples are counted (check
/// "prepare.edges"), not excluded: the ends are continued by linear prediction, which leaves them nearly as good as the
/// rest. Throws Fault for a recording that cannot be used so.
[[nodiscard]] Prepared prepare(const Recording& recording, const PrepareOptions& options);

/// Subtracts `zero_m` from x, before and after the column filter alike (a laser's zero means nothing).
void set_displacement_zero(Prepared& prepared, double zero_m);

}  // namespace dsp
