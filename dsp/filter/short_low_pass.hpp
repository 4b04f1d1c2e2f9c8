#pragma once
#include <Eigen/Core>

namespace dsp {

/// A low-pass by a windowed sinc of some dozen samples, for looks at short pieces of a signal: evaluated where it is
/// asked for, and known between samples as well, so that what a leap becomes behind it can be said. Without delay.
class ShortLowPass {
 public:
  /// Half gain at cutoff_hz; a fifth of that to either side it passes and stops within 40 dB. Throws
  /// std::invalid_argument unless 0 < cutoff_hz < sample_rate_hz / 2.
  ShortLowPass(double cutoff_hz, double sample_rate_hz);
  /// Half gain at cutoff_hz; half of transition_hz to either side it passes and stops within attenuation_db. The
  /// cut-off may be half the sample rate: what is sampled behind it then keeps its time, and nothing folds below the
  /// transition. Throws std::invalid_argument for other cut-offs and a transition that is not positive.
  ShortLowPass(double cutoff_hz, double transition_hz, double attenuation_db, double sample_rate_hz);
  /// Where that with this cut-off stops.
  [[nodiscard]] static double stops_from_hz(double cutoff_hz);
  [[nodiscard]] Eigen::Index reach() const { return reach_; }  ///< samples to either side that it needs
  /// Samples [first, first + count) of the signal behind it; the signal must have reach() more at both ends.
  [[nodiscard]] Eigen::VectorXd operator()(const Eigen::VectorXd& signal, Eigen::Index first, Eigen::Index count) const;
  /// What t^power (power 0 to 2, t in samples from the leap), switched on at 0, is behind it at `t`.
  [[nodiscard]] double switched_on(int power, double t) const;
  /// And what t^power itself is: only the square changes, by a constant.
  [[nodiscard]] double passed(int power, double t) const;

 private:
  Eigen::Index reach_ = 0;
  Eigen::VectorXd taps_;
  Eigen::Matrix<double, Eigen::Dynamic, 3> switched_;  // on a fine grid over +-reach
  double second_moment_ = 0.0;
};

}  // namespace dsp
