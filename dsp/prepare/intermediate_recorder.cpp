#include "dsp/prepare/intermediate_recorder.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>
#include <utility>

#include "dsp/prepare/motion_band.hpp"
#include "dsp/samples/fill_gaps.hpp"

namespace dsp {

using Eigen::Index;

IntermediateRecorder::IntermediateRecorder(const Recording& description, Index num_frames,
                                           const std::optional<DecimateOptions>& options)
    : recording_{.name = description.name,
                 .sample_rate_hz = options ? options->output_rate_hz : description.sample_rate_hz,
                 .clock_start_s = description.clock_start_s,
                 .channels = description.channels},
      input_rate_hz_(description.sample_rate_hz),
      faulty_(description.sample_rate_hz, description.channels),
      spectrum_(description.sample_rate_hz, static_cast<Index>(description.channels.size()), num_frames, 8,
                usual_segment_s(num_frames, description.sample_rate_hz)) {
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

IntermediateRecorder::~IntermediateRecorder() = default;

void IntermediateRecorder::push(const Eigen::Ref<const FrameBlock>& frames) {
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

void IntermediateRecorder::keep(const FrameBlock& frames) {
  if (num_kept_ + frames.rows() > recording_.samples.rows())
    recording_.samples.conservativeResize(num_kept_ + frames.rows(), Eigen::NoChange);
  recording_.samples.middleRows(num_kept_, frames.rows()) = frames;
  num_kept_ += frames.rows();
}

void IntermediateRecorder::refuse(const Eigen::Ref<const FrameBlock>& frames) const {
  for (Index i = 0; i < frames.rows(); ++i)
    for (Index c = 0; c < frames.cols(); ++c)
      if (!std::isfinite(frames(i, c)))
        throw Fault(FaultKind::input, "sample.missing",
                    fmt::format("{}: {} is {} at {:.6g} s, not a number; bridge the gap or cut it out", recording_.name,
                                recording_.channels[static_cast<std::size_t>(c)].name, frames(i, c),
                                static_cast<double>(num_taken_ + i) / input_rate_hz_));
}

Recording IntermediateRecorder::finish() {
  if (decimator_) keep(decimator_->finish());
  if (num_kept_ != recording_.samples.rows())
    recording_.samples.conservativeResize(num_kept_, recording_.samples.cols());
  SampleFaults found = faulty_.finish();
  faulty_ranges_ = std::move(found.ranges);
  fill();
  recording_.bad = std::move(found.bad);
  recording_.checks = std::move(found.checks);
  for (std::size_t c = 0; c < found.hold_samples.size(); ++c)
    if (const int samples = found.hold_samples[c]; samples > 1) take_held(recording_.channels[c], samples);
  return std::move(recording_);
}

// A value is that of its first sample. Held for all of them its sines come half of the others late. What acts from
// outside may well act in steps.
void IntermediateRecorder::take_held(Channel& channel, int samples) {
  const double late_s = 0.5 * (samples - 1) / input_rate_hz_, rate_hz = input_rate_hz_ / samples;
  std::string what = fmt::format("each value stands for {} samples: its own rate is {:.6g} Hz", samples, rate_hz);
  if (info_of(channel.role).body == Body::none) {
    what += fmt::format(
        ", and it is taken to act in such steps. If only its sensor is as slow, say so: delay = \"{:.3g} ms\"",
        1e3 * late_s);
  } else {
    channel.hold_samples = samples;
    channel.hold_s = samples / input_rate_hz_;
    channel.delay_s += late_s;
    what += fmt::format(", and it is taken {:.3g} s earlier, the middle of them, beside a stated delay", late_s);
  }
  recording_.checks.push_back({"sample.slow", channel.name, CheckStatus::note, rate_hz, input_rate_hz_, what});
}

// At the intermediate rate a predictor reaches over a cycle; what the filter before it smears belongs to the gap.
void IntermediateRecorder::fill() {
  const double smear_s = decimator_ ? decimator_->sheet().edge_s : 0.0;
  for (Index c = 0; c < recording_.samples.cols(); ++c) {
    std::vector<Interval> gaps;
    for (const auto& range : faulty_ranges_)
      if (range.channel == c)
        gaps.push_back({static_cast<double>(range.first) / input_rate_hz_ - smear_s,
                        static_cast<double>(range.last) / input_rate_hz_ + smear_s, ""});
    if (!gaps.empty()) fill_gaps(recording_.samples.col(c), recording_.sample_rate_hz, gaps);
  }
}

std::optional<FilterSheet> IntermediateRecorder::sheet() const {
  if (!decimator_) return std::nullopt;
  return decimator_->sheet();
}

}  // namespace dsp
