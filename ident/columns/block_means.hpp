#pragma once
#include <Eigen/Core>

#include "dsp/prepare.hpp"

namespace ident {

/// Means over blocks of about a second, the k-th over samples [k size, (k + 1) size).
struct BlockMeans {
  Eigen::Index size = 0;   ///< samples of a block; 0: none are kept
  Eigen::MatrixXd values;  ///< whole blocks x signals

  BlockMeans() = default;
  BlockMeans(Eigen::Index num_samples, Eigen::Index num_signals, double sample_rate_hz);
  /// Samples from `first` on, of the signals from `signal` on; each sample once.
  void add(Eigen::Index first, Eigen::Index signal, const Eigen::Ref<const Eigen::MatrixXd>& samples);
};

/// Whether the column filter takes away means that the recording knows all the same: accelerometers that pass no
/// constant beside displacements that do. Where a force is recorded its own zero is not known.
[[nodiscard]] bool loses_known_means(const dsp::Prepared& prepared);

}  // namespace ident
