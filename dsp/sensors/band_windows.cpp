#include "dsp/sensors/band_windows.hpp"

#include <algorithm>
#include <cmath>

#include "dsp/filter/fft.hpp"

namespace dsp {

using Eigen::Index;

BandWindows::BandWindows(Index num_samples, double sample_rate_hz, const std::vector<unsigned char>& excluded,
                         double window_s, double from_hz, double to_hz)
    : length_(static_cast<Index>(std::lround(window_s * sample_rate_hz))) {
  if (length_ < 16) return;
  const auto frequency_hz = [&](Index bin) {
    return static_cast<double>(bin) * sample_rate_hz / static_cast<double>(length_);
  };
  while (first_bin_ <= length_ / 2 && frequency_hz(first_bin_) < from_hz) ++first_bin_;
  Index end = first_bin_;
  while (end <= length_ / 2 && frequency_hz(end) <= to_hz) ++end;
  frequencies_hz_ =
      Eigen::VectorXd::NullaryExpr(end - first_bin_, [&](Index k) { return frequency_hz(first_bin_ + k); });
  for (Index first = 0; first + length_ <= num_samples; first += length_ / 2) {
    const auto begin = excluded.begin() + std::min<std::ptrdiff_t>(first, std::ssize(excluded));
    const auto last = excluded.begin() + std::min<std::ptrdiff_t>(first + length_, std::ssize(excluded));
    if (std::none_of(begin, last, [](unsigned char bad) { return bad != 0; })) firsts_.push_back(first);
  }
}

Eigen::MatrixXcd BandWindows::spectra(const Eigen::Ref<const Eigen::VectorXd>& signal) const {
  Eigen::MatrixXcd spectra(frequencies_hz_.size(), num_windows());
  if (firsts_.empty()) return spectra;
  const RealFft fft(length_);
  const Eigen::VectorXd window = hann_window(length_);
  Eigen::VectorXd part(length_);
  Eigen::VectorXcd whole;
  for (Index i = 0; i < spectra.cols(); ++i) {
    const auto samples = signal.segment(firsts_[static_cast<std::size_t>(i)], length_);
    part = (samples.array() - samples.mean()) * window.array();
    fft.forward(part, whole);
    spectra.col(i) = whole.segment(first_bin_, frequencies_hz_.size());
  }
  return spectra;
}

}  // namespace dsp
