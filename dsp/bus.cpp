#include "dsp/bus.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace dsp {

using Eigen::Index;

BusRecorder::BusRecorder(const Recording& description, Index num_frames, const std::optional<DecimateOptions>& options)
    : recording_{.name = description.name,
                 .sample_rate_hz = options ? options->output_rate_hz : description.sample_rate_hz,
                 .clock_start_s = description.clock_start_s,
                 .channels = description.channels} {
  const auto num_channels = static_cast<Index>(description.channels.size());
  Index num_rows = num_frames;
  if (options) {
    decimator_.emplace(description.sample_rate_hz, num_channels, *options);
    num_rows = static_cast<Index>(
                   static_cast<double>(num_frames - 1) * options->output_rate_hz / description.sample_rate_hz + 1e-6) +
               1;
  }
  recording_.samples.resize(num_rows, num_channels);
}

BusRecorder::~BusRecorder() = default;

void BusRecorder::push(const Eigen::Ref<const FrameBlock>& frames) {
  if (decimator_)
    keep(decimator_->push(frames));
  else
    keep(frames);
}

void BusRecorder::keep(const FrameBlock& frames) {
  if (num_kept_ + frames.rows() > recording_.samples.rows())
    recording_.samples.conservativeResize(num_kept_ + frames.rows(), Eigen::NoChange);
  // One bad sample shows in every bus sample within the filter's reach, so it is enough to look at these.
  if (!frames.allFinite()) refuse(frames);
  recording_.samples.middleRows(num_kept_, frames.rows()) = frames;
  num_kept_ += frames.rows();
}

void BusRecorder::refuse(const FrameBlock& frames) const {
  for (Index i = 0; i < frames.rows(); ++i)
    for (Index c = 0; c < frames.cols(); ++c)
      if (!std::isfinite(frames(i, c)))
        throw Fault(FaultKind::input, "sample.missing",
                    fmt::format("{}: {} is not a number at about {:.6g} s; bridge the gap or cut it out",
                                recording_.name, recording_.channels[static_cast<std::size_t>(c)].name,
                                static_cast<double>(num_kept_ + i) / recording_.sample_rate_hz));
}

Recording BusRecorder::finish() {
  if (decimator_) keep(decimator_->finish());
  if (num_kept_ != recording_.samples.rows())
    recording_.samples.conservativeResize(num_kept_, recording_.samples.cols());
  return std::move(recording_);
}

std::optional<FilterSheet> BusRecorder::sheet() const {
  if (!decimator_) return std::nullopt;
  return decimator_->sheet();
}

}  // namespace dsp
