#include "dsp/samples/raw_spectrum.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Index segment_size(double sample_rate_hz, Index num_frames, double segment_s) {
  const double wanted = std::min(segment_s * sample_rate_hz, static_cast<double>(RawSpectrum::longest_segment));
  const Index size = good_fft_size(std::max<Index>(16, static_cast<Index>(wanted)));
  return size <= num_frames ? size : std::max<Index>(2, num_frames / 2 * 2);
}

// Where a tone lies once only every so many samples are kept.
double folded(double frequency_hz, double rate_hz) {
  return std::abs(frequency_hz - rate_hz * std::round(frequency_hz / rate_hz));
}

}  // namespace

RawSpectrum::RawSpectrum(double sample_rate_hz, Index num_channels, Index num_frames, Index num_segments,
                         double segment_s)
    : sample_rate_hz_(sample_rate_hz), fft_(segment_size(sample_rate_hz, num_frames, segment_s)) {
  if (!(sample_rate_hz > 0.0) || num_channels < 1 || num_segments < 2)
    throw std::invalid_argument("RawSpectrum: want a positive rate, a channel and two segments at least");
  const Index size = fft_.size();
  window_ = hann_window(size);
  window_ *=
      std::sqrt(2.0) / (static_cast<double>(size) * std::sqrt(window_.squaredNorm() / static_cast<double>(size)));
  stride_ = std::max(size, (num_frames - size) / (num_segments - 1));
  held_.resize(size, num_channels);
  sum_.setZero(size / 2 + 1, num_channels);
}

double RawSpectrum::bytes_per_channel(double sample_rate_hz, Index num_frames) {
  return 1.5 * sizeof(double) *
         static_cast<double>(segment_size(sample_rate_hz, num_frames, usual_segment_s));  // held_ and sum_
}

void RawSpectrum::push(const Eigen::Ref<const FrameBlock>& frames) {
  for (Index row = 0; row < frames.rows();) {
    const Index offset = (num_taken_ + row) % stride_;  // in the segment, or behind it
    const Index count = std::min(frames.rows() - row, (offset < held_.rows() ? held_.rows() : stride_) - offset);
    if (offset < held_.rows()) {
      held_.middleRows(offset, count) = frames.middleRows(row, count);
      if (offset + count == held_.rows()) transform();
    }
    row += count;
  }
  num_taken_ += frames.rows();
}

Index RawSpectrum::num_idle() const {
  const Index offset = num_taken_ % stride_;
  return offset < held_.rows() ? 0 : stride_ - offset;
}

void RawSpectrum::transform() {
  Eigen::RowVectorXd mean = held_.row(0);
  for (Index i = 1; i < held_.rows(); ++i) mean += held_.row(i);  // all channels at once
  mean /= static_cast<double>(held_.rows());
  VectorXd segment(held_.rows());
  Eigen::VectorXcd spectrum;
  for (Index c = 0; c < held_.cols(); ++c) {
    segment = (held_.col(c).array() - mean(c)) * window_.array();
    fft_.forward(segment, spectrum);
    sum_.col(c) += spectrum.cwiseAbs2();
  }
  ++num_segments_;
}

MatrixXd RawSpectrum::power() const {
  if (num_segments_ == 0) return {};
  return sum_ / static_cast<double>(num_segments_);
}

std::vector<Check> RawSpectrum::checks(const std::vector<Channel>& channels, double output_rate_hz,
                                       const std::optional<FilterSheet>& filter) const {
  constexpr double largest_fraction = 0.01;
  std::vector<Check> checks;
  const MatrixXd power = this->power();
  const auto from = [&](double frequency_hz) {
    return std::min<Index>(power.rows(), static_cast<Index>(std::ceil(frequency_hz / bin_hz())));
  };
  for (Index c = 0; c < power.cols(); ++c) {
    const auto& channel = channels[static_cast<std::size_t>(c)];
    const double whole = power.col(c).sum();
    if (!(whole > 0.0) || !std::isfinite(whole)) continue;
    const auto above = [&](Index bin) { return power.col(c).tail(power.rows() - bin); };
    const double near = above(from(0.45 * sample_rate_hz_)).sum() / whole;
    checks.push_back(
        {"sample.near_nyquist", channel.name, near > largest_fraction ? CheckStatus::warning : CheckStatus::ok, near,
         largest_fraction,
         fmt::format("{:.2g} of the power lies above {:.6g} Hz, {}", near, 0.45 * sample_rate_hz_,
                     near > largest_fraction ? "close to half the rate: there may have been more above it, "
                                               "folded by the recorder"
                                             : "close to half the rate")});
    const Index stop = from(0.5 * output_rate_hz);
    if (!filter || stop >= power.rows()) continue;
    const double fraction = above(stop).sum() / whole;
    Index strongest = 0;
    const double line = above(stop).maxCoeff(&strongest);
    const double line_hz = static_cast<double>(stop + strongest) * bin_hz();
    const double alias = std::sqrt(fraction) * std::pow(10.0, -filter->alias_rejection_db / 20.0);
    checks.push_back(
        {"sample.alias", channel.name, alias > largest_fraction ? CheckStatus::warning : CheckStatus::ok, alias,
         largest_fraction,
         fmt::format("{:.2g} of the rms lies above {:.6g} Hz, most of it ({:.2g} of the rms a bin) at {:.6g} Hz, which "
                     "would fold to {:.3g} Hz; after the filter ({:.0f} dB) {:.2g} of the rms folds",
                     std::sqrt(fraction), 0.5 * output_rate_hz, std::sqrt(line / whole), line_hz,
                     folded(line_hz, output_rate_hz), filter->alias_rejection_db, alias)});
  }
  return checks;
}

}  // namespace dsp
