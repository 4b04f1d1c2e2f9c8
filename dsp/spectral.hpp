#pragma once
#include <Eigen/Core>
#include <complex>
#include <functional>

namespace dsp {

/// A low-pass by its two edges: gain 1 up to rolloff_hz, raised cosine down to 0 at cutoff_hz.
struct SpectralBand {
  double rolloff_hz = 0.0, cutoff_hz = 0.0;
  [[nodiscard]] double gain(double frequency_hz) const;
};

/// How a record is continued beyond its ends so that it closes on itself: linear prediction (Burg) fitted at each end.
struct ExtensionOptions {
  Eigen::Index num_samples = 0;   ///< either side; 0: chosen from rate and length (10 s where there is that much)
  Eigen::Index order = 0;         ///< of the predictor; 0: chosen (64 at most at low rates, 128 beyond 100 Hz)
  Eigen::Index fit_samples = 0;   ///< the predictor is fitted to this many; 0: 8 x order (40 x above 100 Hz)
};

/// The spectrum of a whole record, its mean removed and its ends extended, ready for any linear time-invariant operator.
/// Costs one FFT to make and one inverse FFT per operator.
class ExtendedSpectrum {
 public:
  /// Throws std::invalid_argument for a rate that is not positive, fewer than 8 samples or a non-finite sample.
  ExtendedSpectrum(const Eigen::Ref<const Eigen::VectorXd>& signal, double sample_rate_hz,
                   const ExtensionOptions& options = {});
  /// The signal passed through `response` (a function of frequency in Hz, f >= 0), as long as the signal. The record's
  /// mean passes with response(0).
  [[nodiscard]] Eigen::VectorXd filtered(const std::function<std::complex<double>(double)>& response) const;
  /// d^order(signal)/dt^order within the band: the spectrum times (i 2 pi f)^order gain(f). order 0 is the low-pass alone.
  [[nodiscard]] Eigen::VectorXd derivative(int order, const SpectralBand& band) const;
  /// Share of the (mean-free) signal's power above frequency_hz.
  [[nodiscard]] double power_fraction_above(double frequency_hz) const;

 private:
  double sample_rate_hz_ = 0.0, mean_ = 0.0;
  Eigen::Index num_samples_ = 0, num_extended_ = 0, num_before_ = 0;
  Eigen::VectorXcd spectrum_;
};

}  // namespace dsp
