#pragma once
#include <Eigen/Core>
#include <complex>
#include <functional>

#include "dsp/filter/burg.hpp"
#include "dsp/filter/fft.hpp"

namespace dsp {

/// A low-pass by its two edges: gain 1 up to rolloff_hz, raised cosine down to 0 at cutoff_hz.
struct SpectralBand {
  double rolloff_hz = 0.0, cutoff_hz = 0.0;
  [[nodiscard]] double gain(double frequency_hz) const;
};

/// The spectrum of a whole record, its mean removed and its ends extended by linear prediction so that it closes on
/// itself, ready for any linear time-invariant operator. Costs one FFT to make and one inverse FFT per signal had from
/// it.
class ExtendedSpectrum {
 public:
  /// Throws std::invalid_argument for a rate that is not positive, fewer than 8 samples or a non-finite sample.
  ExtendedSpectrum(const Eigen::Ref<const Eigen::VectorXd>& signal, double sample_rate_hz,
                   const ExtensionOptions& options = {});
  /// A function of frequency in Hz, f >= 0. A record's mean passes with response(0), whose real part counts.
  using Response = std::function<std::complex<double>(double)>;
  /// The signal, as it is or passed through `response`, as long as the signal.
  [[nodiscard]] Eigen::VectorXd signal() const&;
  [[nodiscard]] Eigen::VectorXd signal() &&;
  [[nodiscard]] Eigen::VectorXd filtered(const Response& response) const;
  /// The same without the way back: the signal becomes the filtered one.
  void multiply(const Response& response);
  /// Adds another signal passed through `response`. Throws std::invalid_argument unless it is as long.
  void add(const ExtendedSpectrum& other, const Response& response);
  /// d^order(signal)/dt^order within the band: the spectrum times (i 2 pi f)^order gain(f). order 0 is the low-pass
  /// alone.
  [[nodiscard]] Eigen::VectorXd derivative(int order, const SpectralBand& band) const;
  /// Fraction of the (mean-free) signal's power above frequency_hz; 0 for a constant.
  [[nodiscard]] double power_fraction_above(double frequency_hz) const;

 private:
  [[nodiscard]] double frequency_hz(Eigen::Index bin) const;
  [[nodiscard]] Eigen::VectorXd back(Eigen::VectorXcd spectrum, double mean) const;

  double sample_rate_hz_ = 0.0, mean_ = 0.0;
  Eigen::Index num_samples_ = 0;
  RealFft fft_;
  Eigen::VectorXcd spectrum_;
};

}  // namespace dsp
