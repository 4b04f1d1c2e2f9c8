#pragma once
#include <Eigen/Core>
#include <complex>
#include <functional>
#include <limits>

namespace sim {

/// Lowest and highest value of a motion.
struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  /// By a piece of h seconds, a cubic between values and slopes at its ends.
  void extend(double z0, double dz0, double z1, double dz1, double h);
  [[nodiscard]] double half() const { return 0.5 * (high - low); }
};

/// What a period of the drive makes of the motion that is looked at: x relative to what moves, y absolute.
struct DrivenMotion {
  Range x, y;
  std::complex<double> x_fundamental;  ///< times the drive's phase: its argument is x's phase against u
  double stuck_fraction = 0.0;         ///< of the period, in which friction holds
  bool locked = false;                 ///< all of it, and nothing moves
};

/// One period of the drive from a state at its crest.
struct DrivenPeriod {
  DrivenMotion motion;
  Eigen::VectorXd end;    ///< the state
  Eigen::VectorXd scale;  ///< by what changes of each state are measured: positive
  bool finite = true;     ///< the motion has not run away
};

/// What a sine drives, from any number of states: told of its frequency, its amplitude and the state at its crest.
struct DrivenSystem {
  Eigen::VectorXd rest;  ///< the state at a crest that leaves x at rest at zero, over the amplitude
  double step = 1e-6;    ///< of the states' scales: moved by as little the end of a period moves in proportion
  std::function<DrivenPeriod(double frequency_hz, double amplitude, const Eigen::VectorXd& start)> period;
};

}  // namespace sim
