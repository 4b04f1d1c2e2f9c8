#pragma once
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "dsp/sensors/motion.hpp"

namespace ident {

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

}  // namespace ident
