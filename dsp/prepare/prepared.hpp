#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dsp/filter/column_filter.hpp"
#include "dsp/filter/decimate.hpp"
#include "dsp/sensors/motion.hpp"
#include "dsp/sensors/sensor_consistency.hpp"
#include "dsp/values/recording.hpp"

namespace dsp {

enum class Recipe {
  matched,  ///< columns are formed first, on wide-band signals, and filtered after, each by the filter of the target
  paper,    ///< signals are filtered first and columns formed from them, as in [QZS23]
};

struct PrepareOptions {
  Recipe recipe = Recipe::matched;
  double rate_hz = 0.0;     ///< regression rate; 0: the record's own
  double cutoff_hz = 0.0;   ///< 0: 0.4 x regression rate. Derivatives go to zero here; so do columns at the record's
                            ///< own rate; decimated columns are flat up to here and gone at 1.25 x cutoff
  double rolloff_hz = 0.0;  ///< where the taper begins; 0: 0.78125 x cutoff (8 of 10.24)
  double state_cutoff_hz = 0.0;  ///< band in which states are formed before their columns are filtered; 0: at the
                                 ///< record's own rate 0.49 x that, rolling off from 0.75 of it; when decimating
  double state_rolloff_hz =
      0.0;  ///< 20/10.24 x cutoff as far as the intermediate rate allows (0.4 x), rolling off from 0.64 of it
  double intermediate_rate_hz =
      0.0;  ///< rate at which columns are formed when decimating; 0: about 10 x regression rate
  AccelerationSource acceleration = AccelerationSource::automatic;
  double integrate_from_hz = 0.0;  ///< of a record without a displacement; 0: where its drift ends
  bool equalise = true;            ///< "matched": displacements and accelerometers of one body are equalised
  ScaleReference scale = ScaleReference::displacement;
  bool operator==(const PrepareOptions&) const = default;
};

/// A recording ready for regression.
struct Prepared {
  std::string name;
  PrepareOptions options;  ///< with every default filled in
  Motion intermediate;     ///< wide-band signals at the intermediate rate: columns are formed from these ("matched")
  Motion signals;          ///< the same signals low-passed, at the regression rate: prepared.csv, conditions, free run;
                           ///< columns of recipe "paper"
  ColumnFilter filter;     ///< from intermediate to regression rate, with the high-pass that all accelerometers share
  std::vector<double> highpass_hz;          ///< its cut-offs; none: columns keep their means
  std::vector<Channel> channels;            ///< of the recording
  std::optional<FilterSheet> decimation;    ///< from the recording to the regression rate
  std::vector<SensorRelation> relations;    ///< between displacement and accelerometer of base and payload
  std::vector<SensorRelation> derivatives;  ///< between other channels one of which is the other's derivative
  Eigen::VectorXd raw_v, raw_a;             ///< at the regression rate, before the sensors were equalised; for the
                                            ///< power check; empty where they were not
  bool x_is_difference = false;             ///< x = y - r of two displacements, whose zeros mean nothing
  /// The channels of x or its derivatives at the intermediate rate, nothing but decimated and brought to one clock,
  /// with the intervals that must not be used, without margins; null where x is a difference, or all was filtered
  /// first.
  std::shared_ptr<const Recording> recorded;
  /// The other channels in the same way, where x is integrated, which takes what is slow from the signals of all; else
  /// null.
  std::shared_ptr<const Recording> recorded_beside;
  std::vector<Interval> excluded;  ///< with margins and reasons; marked in both motions
  std::vector<Interval> clipped;   ///< of these, the clipped ones without margins; why: the channel's name
  std::vector<Check> checks;
  /// nullptr where the recording has none.
  [[nodiscard]] const Channel* channel(Role role) const&;
  void channel(Role) const&& = delete;
  /// Whether x was integrated, from options.integrate_from_hz on, as no displacement was recorded.
  [[nodiscard]] bool integrated() const;
  /// Whether the relations were used: only "matched" does, unless asked not to.
  [[nodiscard]] bool equalised() const { return options.recipe == Recipe::matched && options.equalise; }
};

/// The options with nothing left to choose for a recording at this rate. The intermediate rate divides the recording's
/// rate and is a multiple of the regression rate where there is such a rate between 5 and 20 times the latter. Throws
/// Fault (usage) for rates and frequencies that do not fit each other.
[[nodiscard]] PrepareOptions resolved(const PrepareOptions& options, double sample_rate_hz);

}  // namespace dsp
