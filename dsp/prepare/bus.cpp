#include "dsp/prepare/bus.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "dsp/samples/fill_gaps.hpp"

namespace dsp {

using Eigen::Index;

BusRecorder::BusRecorder(const Recording& description, Index num_frames, const std::optional<DecimateOptions>& options)
    : recording_{.name = description.name,
                 .sample_rate_hz = options ? options->output_rate_hz : description.sample_rate_hz,
                 .clock_start_s = description.clock_start_s,
                 .channels = description.channels},
      input_rate_hz_(description.sample_rate_hz),
      faulty_(description.sample_rate_hz, description.channels),
      spectrum_(description.sample_rate_hz, static_cast<Index>(description.channels.size()), num_frames) {
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
  try {
    faulty_.push(frames);
  } catch (const std::invalid_argument&) {
    refuse(frames);
    throw;
  }
  spectrum_.push(frames);
  num_taken_ += frames.rows();
  if (decimator_)
    keep(decimator_->push(frames));
  else
    keep(frames);
}

void BusRecorder::keep(const FrameBlock& frames) {
  if (num_kept_ + frames.rows() > recording_.samples.rows())
    recording_.samples.conservativeResize(num_kept_ + frames.rows(), Eigen::NoChange);
  recording_.samples.middleRows(num_kept_, frames.rows()) = frames;
  num_kept_ += frames.rows();
}

void BusRecorder::refuse(const Eigen::Ref<const FrameBlock>& frames) const {
  for (Index i = 0; i < frames.rows(); ++i)
    for (Index c = 0; c < frames.cols(); ++c)
      if (!std::isfinite(frames(i, c)))
        throw Fault(FaultKind::input, "sample.missing",
                    fmt::format("{}: {} is {} at {:.6g} s, not a number; bridge the gap or cut it out", recording_.name,
                                recording_.channels[static_cast<std::size_t>(c)].name, frames(i, c),
                                static_cast<double>(num_taken_ + i) / input_rate_hz_));
}

Recording BusRecorder::finish() {
  if (decimator_) keep(decimator_->finish());
  if (num_kept_ != recording_.samples.rows())
    recording_.samples.conservativeResize(num_kept_, recording_.samples.cols());
  SampleFaults faults = faulty_.finish();
  faults_ = std::move(faults.stretches);
  fill();
  recording_.bad = std::move(faults.bad);
  recording_.checks = std::move(faults.checks);
  return std::move(recording_);
}

// On the bus a predictor reaches over a cycle; what the filter before it smears belongs to the gap.
void BusRecorder::fill() {
  const double smear_s = decimator_ ? decimator_->sheet().edge_s : 0.0;
  for (Index c = 0; c < recording_.samples.cols(); ++c) {
    std::vector<Interval> gaps;
    for (const auto& stretch : faults_)
      if (stretch.channel == c)
        gaps.push_back({static_cast<double>(stretch.first) / input_rate_hz_ - smear_s,
                        static_cast<double>(stretch.last) / input_rate_hz_ + smear_s, ""});
    if (!gaps.empty()) fill_gaps(recording_.samples.col(c), recording_.sample_rate_hz, gaps);
  }
}

std::optional<FilterSheet> BusRecorder::sheet() const {
  if (!decimator_) return std::nullopt;
  return decimator_->sheet();
}

}  // namespace dsp
