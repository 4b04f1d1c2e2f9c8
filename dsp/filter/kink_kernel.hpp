#pragma once
#include <Eigen/Core>

#include "dsp/filter/spectral.hpp"

namespace dsp {

/// What a zero-phase low-pass takes away where the slope of a signal jumps: of a jump by one at 0,
/// K(tau) = -2 int_0^inf (1 - G(f)) cos(2 pi f tau) / (2 pi f)^2 df in seconds, G the gain of the band. A velocity with
/// jumps d_k of the acceleration at t_k is its low-passed self plus the sum of d_k K(t - t_k), below the band exactly.
class KinkKernel {
 public:
  /// Throws std::invalid_argument unless 0 < rolloff_hz < cutoff_hz.
  explicit KinkKernel(const SpectralBand& band);
  [[nodiscard]] double operator()(double tau_s) const;
  /// Adds weight K(tau_s + i spacing_s) to values(i), all of them within reach_s() of 0.
  void add(double weight, double tau_s, double spacing_s, Eigen::Ref<Eigen::VectorXd> values) const;
  /// dK/dtau; at 0, where it jumps, the mean of both sides: 0.
  [[nodiscard]] double slope(double tau_s) const;
  [[nodiscard]] double reach_s() const { return reach_s_; }  ///< beyond, less than 1e-3 of K(0) is left

 private:
  double reach_s_ = 0.0, step_s_ = 0.0;
  Eigen::VectorXd value_, slope_;  ///< at multiples of step_s_ from 0
  Eigen::Matrix2Xd both_;          ///< the same, slopes times step_s_
};

}  // namespace dsp
