#include "dsp/filter/spectral.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace dsp {
namespace {
using Eigen::Index;
using Eigen::VectorXd;

// Steps from 0 to 1 with two continuous derivatives.
double smooth_step(double u) {
  return u * u * u * (10.0 + u * (6.0 * u - 15.0));
}

// What comes after the record, passing over into what comes before it.
VectorXd bridge(const VectorXd& record, Index length, ExtensionOptions options) {
  options.num_samples = length;
  const VectorXd after = extend_after(record, options), before = extend_before(record, options);
  VectorXd gap(length);
  for (Index i = 0; i < length; ++i) {
    const double s = smooth_step(static_cast<double>(i + 1) / static_cast<double>(length + 1));
    gap(i) = (1.0 - s) * after(i) + s * before(i);
  }
  return gap;
}

Index extended_size(const Eigen::Ref<const VectorXd>& signal, double sample_rate_hz, const ExtensionOptions& options) {
  if (!(sample_rate_hz > 0.0)) throw std::invalid_argument("ExtendedSpectrum: the sample rate must be positive");
  if (signal.size() < 8) throw std::invalid_argument("ExtendedSpectrum: at least 8 samples are needed");
  if (!signal.allFinite()) throw std::invalid_argument("ExtendedSpectrum: a sample is not finite");
  return good_fft_size(signal.size() + 2 * resolved(options, signal.size(), sample_rate_hz).num_samples);
}
}  // namespace

double SpectralBand::gain(double frequency_hz) const {
  if (frequency_hz <= rolloff_hz) return 1.0;
  if (frequency_hz >= cutoff_hz) return 0.0;
  return 0.5 + 0.5 * std::cos(std::numbers::pi * (frequency_hz - rolloff_hz) / (cutoff_hz - rolloff_hz));
}

ExtendedSpectrum::ExtendedSpectrum(const Eigen::Ref<const VectorXd>& signal, double sample_rate_hz,
                                   const ExtensionOptions& options)
    : sample_rate_hz_(sample_rate_hz),
      mean_(signal.mean()),
      num_samples_(signal.size()),
      fft_(extended_size(signal, sample_rate_hz, options)) {
  VectorXd periodic(fft_.size());
  periodic.head(num_samples_) = signal.array() - mean_;
  // What a constant record leaves behind is the rounding_error of its mean, not a signal to be continued.
  const double rounding_error = 1e-13 * std::abs(mean_);
  if (periodic.head(num_samples_).cwiseAbs().maxCoeff() <= rounding_error) periodic.head(num_samples_).setZero();
  const Index gap = fft_.size() - num_samples_;
  periodic.tail(gap) = bridge(periodic.head(num_samples_), gap, resolved(options, num_samples_, sample_rate_hz));
  spectrum_ = fft_.forward(periodic);
}

double ExtendedSpectrum::frequency_hz(Index bin) const {
  return static_cast<double>(bin) * sample_rate_hz_ / static_cast<double>(fft_.size());
}

VectorXd ExtendedSpectrum::back(Eigen::VectorXcd spectrum, double mean) const {
  VectorXd signal = fft_.inverse(std::move(spectrum));
  signal.conservativeResize(num_samples_);  // in place: a record may be long
  signal.array() += mean;
  return signal;
}

VectorXd ExtendedSpectrum::signal() const& {
  return back(spectrum_, mean_);
}

VectorXd ExtendedSpectrum::signal() && {
  return back(std::move(spectrum_), mean_);
}

void ExtendedSpectrum::require_as_long(const ExtendedSpectrum& other) const {
  if (other.num_samples_ != num_samples_ || other.spectrum_.size() != spectrum_.size())
    throw std::invalid_argument("ExtendedSpectrum::add: another length");
}

VectorXd ExtendedSpectrum::derivative(int order, const SpectralBand& band) const {
  if (order < 0) throw std::invalid_argument("ExtendedSpectrum::derivative: order must not be negative");
  Eigen::VectorXcd product = Eigen::VectorXcd::Zero(spectrum_.size());
  constexpr std::complex<double> turns[] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
  const std::complex<double> turn = turns[order % 4];
  for (Index k = 0; k < product.size(); ++k) {
    const double f = frequency_hz(k), gain = band.gain(f);
    if (f > band.rolloff_hz && gain == 0.0) break;
    double factor = gain;
    for (int i = 0; i < order; ++i) factor *= 2.0 * std::numbers::pi * f;
    product(k) = spectrum_(k) * (factor * turn);
  }
  return back(std::move(product), order == 0 ? mean_ : 0.0);
}

std::complex<double> highpass_response(const std::vector<double>& cutoffs_hz, double frequency_hz) {
  std::complex<double> value = 1.0;
  // i f / (c + i f) without a complex division, which guards against overflow at several times the price.
  for (const double cutoff : cutoffs_hz)
    value *=
        frequency_hz / (cutoff * cutoff + frequency_hz * frequency_hz) * std::complex<double>(frequency_hz, cutoff);
  return value;
}

double ExtendedSpectrum::power_fraction_above(double limit_hz) const {
  double above = 0.0, total = 0.0;
  for (Index k = 0; k < spectrum_.size(); ++k) {
    const bool is_nyquist = 2 * k == fft_.size();
    const double power = (k == 0 || is_nyquist ? 1.0 : 2.0) * std::norm(spectrum_(k));
    total += power;
    if (frequency_hz(k) > limit_hz) above += power;
  }
  return total > 0.0 ? above / total : 0.0;
}

}  // namespace dsp
