#pragma once
#include <Eigen/Core>
#include <complex>
#include <utility>
#include <vector>

#include "dsp/filter/burg.hpp"
#include "dsp/filter/fft.hpp"

namespace dsp {

/// A low-pass by its two edges: gain 1 up to rolloff_hz, raised cosine down to 0 at cutoff_hz.
struct SpectralBand {
  double rolloff_hz = 0.0, cutoff_hz = 0.0;
  [[nodiscard]] double gain(double frequency_hz) const;
};

/// prod_k i f / (f_k + i f); zero at f = 0 where there is a cut-off.
[[nodiscard]] std::complex<double> highpass_response(const std::vector<double>& cutoffs_hz, double frequency_hz);

/// The spectrum of a whole record, its mean removed and its ends extended by linear prediction so that it closes on
/// itself, ready for any linear time-invariant operator. Costs one FFT to make and one inverse FFT per signal had from
/// it.
class ExtendedSpectrum {
 public:
  /// Throws std::invalid_argument for a rate that is not positive, fewer than 8 samples or a non-finite sample.
  ExtendedSpectrum(const Eigen::Ref<const Eigen::VectorXd>& signal, double sample_rate_hz,
                   const ExtensionOptions& options = {});
  /// The signal, as it is or passed through `response`, as long as the signal. A response is a function of frequency in
  /// Hz, f >= 0, real or complex; a record's mean passes with response(0), whose real part counts.
  [[nodiscard]] Eigen::VectorXd signal() const&;
  [[nodiscard]] Eigen::VectorXd signal() &&;
  template <class Response>
  [[nodiscard]] Eigen::VectorXd filtered(const Response& response) const {
    Eigen::VectorXcd product(spectrum_.size());
    at_each_bin(response, [&](Eigen::Index k, std::complex<double> value) { product(k) = spectrum_(k) * value; });
    return back(std::move(product), mean_ * at_zero(response));
  }
  /// The same without the way back: the signal becomes the filtered one.
  template <class Response>
  void multiply(const Response& response) {
    at_each_bin(response, [&](Eigen::Index k, std::complex<double> value) { spectrum_(k) *= value; });
    mean_ *= at_zero(response);
  }
  /// Adds another signal passed through `response`. Throws std::invalid_argument unless it is as long.
  template <class Response>
  void add(const ExtendedSpectrum& other, const Response& response) {
    require_as_long(other);
    at_each_bin(response,
                [&](Eigen::Index k, std::complex<double> value) { spectrum_(k) += other.spectrum_(k) * value; });
    mean_ += other.mean_ * at_zero(response);
  }
  /// d^order(signal)/dt^order within the band: the spectrum times (i 2 pi f)^order gain(f). order 0 is the low-pass
  /// alone.
  [[nodiscard]] Eigen::VectorXd derivative(int order, const SpectralBand& band) const;
  /// Fraction of the (mean-free) signal's power above frequency_hz; 0 for a constant.
  [[nodiscard]] double power_fraction_above(double frequency_hz) const;

 private:
  template <class Response, class Act>
  void at_each_bin(const Response& response, const Act& act) const {
    const auto size = static_cast<double>(fft_.size());
    for (Eigen::Index k = 0; k < spectrum_.size(); ++k)
      act(k, std::complex<double>(response(static_cast<double>(k) * sample_rate_hz_ / size)));
  }
  template <class Response>
  [[nodiscard]] static double at_zero(const Response& response) {
    return std::complex<double>(response(0.0)).real();
  }
  void require_as_long(const ExtendedSpectrum& other) const;
  [[nodiscard]] double frequency_hz(Eigen::Index bin) const;
  [[nodiscard]] Eigen::VectorXd back(Eigen::VectorXcd spectrum, double mean) const;

  double sample_rate_hz_ = 0.0, mean_ = 0.0;
  Eigen::Index num_samples_ = 0;
  RealFft fft_;
  Eigen::VectorXcd spectrum_;
};

}  // namespace dsp
