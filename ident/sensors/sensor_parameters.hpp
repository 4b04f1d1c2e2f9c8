#pragma once
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "dsp/sensors/motion.hpp"

namespace ident {

struct Record;

/// Samples [first, first + count) of a change of signals.
using SignalChange = std::function<std::vector<dsp::Signal>(Eigen::Index first, Eigen::Index count)>;

/// What a sensor's error does to the signals of a motion.
struct SensorShape {
  /// The signals it changes and their change for a value of one, on the clock of the motion it is given, which must
  /// outlive what is returned.
  std::function<SignalChange(const dsp::Motion&)> change;
  bool of_accelerations = false;  ///< it changes these only, by what linear filters make of these
};

/// Where the equation's x and f are in what was recorded: no error of a sensor, but a part of what the equation states.
enum class Coordinate { none, zero_of_x, lead_of_f };

/// Something about a recording's sensors that is known to a standard deviation only. A value of it is a change of the
/// signals: what the body did is what was recorded + value * change.
struct SensorParameter {
  std::string name;    ///< "relative gain of base_laser"
  std::string source;  ///< of a budget; drifts of one signal at several times are one
  std::string unit;    ///< SI, "1"
  double std = 0.0;    ///< of the prior, a normal distribution about zero
  double from_s = -std::numeric_limits<double>::infinity(), to_s = -from_s;  ///< it changes nothing elsewhere
  std::shared_ptr<const SensorShape> shape;                                  ///< shared by those that differ in course
  /// By which the shape is multiplied at a time; so slow that it may as well be multiplied behind the column filter.
  /// None: 1.
  std::function<double(double t_s)> course;
  Coordinate coordinate = Coordinate::none;

  [[nodiscard]] double course_at(double t_s) const {
    return t_s < from_s || t_s > to_s ? 0.0 : course ? course(t_s) : 1.0;
  }
};

/// Those that a record's channels have, in the units of its displacement sensors. None in recipe "paper", where the
/// accelerometers set the scale, or where a displacement and the accelerometer beside it could not be brought to agree:
/// how wrong they are is not known then.
/// Displacements of base and payload: their relative gain (standard deviation as their channels say, 1 % each, or what
/// intervals of common motion leave), the zero of x (1 % of its channels' range, or of what they read) and its drift,
/// piecewise linear every 300 s (as the channels say, or as x is seen to wander). A displacement without a base keeps
/// its own zero, about which even powers of x are terms of the equation: its zero (1 % of the range) and its drift are
/// uncertain only where the channel states a range or a drift. A zero that a person stated is known. A force: its lag
/// (1 / sqrt(12) of the recording's sample interval: channels scanned in turn). No gain of a lone displacement or of a
/// force: its column is a candidate's own (c f); it is one of absolute_gains.hpp. Where the acceleration was measured,
/// each displacement beside an accelerometer: a lag; the accelerometer: the sum of the cut-offs of its coupling and its
/// gain; all to the standard deviation of their relation. Where base and payload were seen to move as one, the base's
/// lag is that to the payload's sensor. (An acceleration computed from the displacements is late as they are.)
[[nodiscard]] std::vector<SensorParameter> sensor_parameters(const Record& record);

/// The signals of a recording in the coordinates of an equation: x less `zero`, and f as it was recorded `lead_s`
/// later, to first order.
[[nodiscard]] dsp::Motion in_coordinates(dsp::Motion motion, double zero, double lead_s);

}  // namespace ident
