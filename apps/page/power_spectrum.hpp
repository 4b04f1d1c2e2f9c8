#pragma once
#include <Eigen/Core>

namespace apps {

/// One-sided power density of a record above 0 Hz, in dB re 1 unit^2/Hz.
struct PowerSpectrum {
  Eigen::VectorXd frequency_hz, power_db;  ///< empty: the record is too short or too full of gaps
};

/// Welch's: Hann segments, half overlapping, of at most 2048 samples. Samples that are not finite count as zero;
/// segments of which more than a tenth is missing are left out.
[[nodiscard]] PowerSpectrum power_spectrum_db(const Eigen::Ref<const Eigen::VectorXd>& values, double sample_rate_hz);

}  // namespace apps
