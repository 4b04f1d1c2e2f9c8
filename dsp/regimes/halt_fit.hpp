#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "dsp/filter/short_low_pass.hpp"

namespace dsp {

/// Fits, by least squares, what an acceleration does where friction changes its sign, behind a low-pass: a parabola
/// that leaps there, and is zero during a halt. Linear but for the times of reversal and halt, which are searched on
/// grids of bases made once.
class HaltFit {
 public:
  HaltFit(const ShortLowPass& low_pass, double cutoff_cycles_per_sample);
  [[nodiscard]] Eigen::Index reach() const { return reach_; }  ///< samples it needs to either side of a reversal
  struct Result {
    double halt_samples = 0.0;  ///< the best from 0 to a wave of the cut-off
    double gain = 0.0;          ///< root of the sum of squares that the halt explains, beyond the best without one
    double rms = 0.0;           ///< of what is left
  };
  /// `a`: low-passed and towards the new sign, [reach | the reversal within two samples | reach].
  [[nodiscard]] Result operator()(const Eigen::VectorXd& a) const;

 private:
  using Bases = std::vector<Eigen::Matrix<double, Eigen::Dynamic, 4>>;  // orthonormal, by step of the grid
  struct Least {
    std::ptrdiff_t step = 0;
    double misfit = 0.0;
  };
  [[nodiscard]] static Least least_about(const Bases& bases, const Eigen::VectorXd& a, double power,
                                         std::ptrdiff_t step);
  double wave_;  // in samples
  Eigen::Index reach_;
  std::vector<Bases> by_halt_;
};

}  // namespace dsp
