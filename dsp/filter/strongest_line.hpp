#pragma once
#include <Eigen/Core>

namespace dsp {

struct SpectralLine {
  double frequency_hz = 0.0;
  double fraction = 0.0;  ///< fraction of the power within two bins of it
};

/// The strongest line of a signal's periodogram about its mean: its dominant frequency, to one bin. At least 2 samples.
[[nodiscard]] SpectralLine strongest_line(const Eigen::Ref<const Eigen::VectorXd>& signal, double sample_rate_hz);

}  // namespace dsp
