#include "dsp/samples/bridge_gaps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "dsp/samples/short_gap.hpp"
#include "dsp/values/memory_limit.hpp"
#include "dsp/values/set_shape.hpp"

namespace dsp {

namespace {
constexpr double largest_value = 1e100;
}

GapBridge::GapBridge(BridgeOptions options) : options_(std::move(options)), open_(options_.channels.size()) {}

void GapBridge::push(FrameBlock frames) {
  if (frames.rows() == 0) return;
  held_.push_back({end_, std::move(frames)});
  end_ += held_.back().frames.rows();
  const FrameBlock& last = held_.back().frames;
  bool are_values = true;
  for (Eigen::Index i = 0; i < last.size(); ++i) are_values &= std::abs(last.data()[i]) <= largest_value;
  for (Eigen::Index channel = 0; channel < std::ssize(open_); ++channel) check_channel(channel, are_values);
}

// Of the block that came last. are_values: no sample of any channel in it is missing or huge.
void GapBridge::check_channel(Eigen::Index channel, bool are_values) {
  auto& open = open_[static_cast<std::size_t>(channel)];
  const auto& name = options_.channels[static_cast<std::size_t>(channel)];
  const Held& last = held_.back();
  const Eigen::Index count = last.frames.rows();
  if (open.first < 0 && count > 1 && are_values) {
    open.earlier = last.frames(count - 2, channel);
    open.before = last.frames(count - 1, channel);
    open.has_earlier = open.has_before = true;
    return;
  }
  for (Eigen::Index i = 0; i < count; ++i) {
    const double value = last.frames(i, channel);
    const auto frame = last.first + i;
    if (std::abs(value) <= largest_value) {
      const bool closes = open.first >= 0;
      if (closes) close(channel, frame, value, true);
      open.has_earlier = open.has_before && !closes;
      open.earlier = open.before;
      open.before = value;
      open.has_before = true;
      continue;
    }
    if (std::isfinite(value))
      throw Fault(FaultKind::input, "sample.huge",
                  fmt::format("{}: channel '{}' is {} at {:.6g} s: no measurement", options_.name, name, value,
                              static_cast<double>(frame) / options_.sample_rate_hz));
    if (open.first < 0) open.first = frame;
    if (!open.has_before) {
      require_begin(channel, frame + 1 - first_);
      continue;
    }
    ++open.num_missing;
    if (are_many_held(frame + 1 - first_)) close(channel, frame + 1, open.before, true);
  }
}

bool GapBridge::are_many_held(std::int64_t num_held) const {
  constexpr double most_values = 1 << 24;  // 128 MB
  return static_cast<double>(num_held) * static_cast<double>(open_.size()) > most_values;
}

// Frames are held until every channel has begun.
void GapBridge::require_begin(Eigen::Index channel, std::int64_t num_held) const {
  const double bytes = sizeof(double) * static_cast<double>(num_held) * static_cast<double>(open_.size());
  require_memory(options_.name, bytes_beside_ + bytes, options_.max_memory_bytes);
  if (are_many_held(num_held))
    throw Fault(
        FaultKind::input, "sample.missing",
        fmt::format("{}: channel '{}' has no value in the first {:.6g} s. Leave the channel out or cut the recording",
                    options_.name, options_.channels[static_cast<std::size_t>(channel)],
                    static_cast<double>(num_held) / options_.sample_rate_hz));
}

void GapBridge::close(Eigen::Index channel, std::int64_t end, double behind, bool has_behind) {
  auto& open = open_[static_cast<std::size_t>(channel)];
  if (!open.has_before && !has_behind)
    throw Fault(FaultKind::input, "sample.missing",
                fmt::format("{}: channel '{}' has no value at all. Leave the channel out", options_.name,
                            options_.channels[static_cast<std::size_t>(channel)]));
  const double before = open.has_before ? open.before : behind;
  if (!has_behind) behind = before;
  const auto steps = static_cast<double>(end - open.first + 1);
  auto block = std::prev(std::upper_bound(held_.begin(), held_.end(), open.first,
                                          [](std::int64_t frame, const Held& held) { return frame < held.first; }));
  for (auto frame = open.first; frame < end; ++frame) {
    if (frame == block->first + block->frames.rows()) ++block;
    const double fraction = static_cast<double>(frame - open.first + 1) / steps;
    double& value = block->frames(static_cast<Eigen::Index>(frame - block->first), channel);
    value = (1 - fraction) * before + fraction * behind;
    if (open.has_earlier && has_behind && is_curved_gap(steps))
      value += parabola(-1.0, steps, fraction * steps) * (open.earlier - before - (before - behind) / steps);
  }
  const double from_s = static_cast<double>(open.first) / options_.sample_rate_hz;
  const double to_s = static_cast<double>(end) / options_.sample_rate_hz;
  bridged_.push_back({from_s, to_s,
                      fmt::format("no values in {}", options_.channels[static_cast<std::size_t>(channel)]),
                      open.has_before && has_behind});
  if (!open.has_before)
    open.num_before = end - open.first;
  else if (open.num_gaps++ == 0)
    open.first_place_s = from_s;
  open.first = -1;
}

void GapBridge::finish() {
  for (std::size_t channel = 0; channel < open_.size(); ++channel)
    if (open_[channel].first >= 0) close(static_cast<Eigen::Index>(channel), end_, 0.0, false);
}

Eigen::Index GapBridge::num_ready() const {
  auto ready = end_;
  for (const auto& open : open_)
    if (open.first >= 0) ready = std::min(ready, open.first);
  return static_cast<Eigen::Index>(ready - first_);
}

Eigen::Index GapBridge::take(FrameBlock& block, Eigen::Index max_frames) {
  const auto count = std::min(num_ready(), max_frames);
  if (count > 0 && first_ == held_.front().first && count == held_.front().frames.rows()) {
    block.swap(held_.front().frames);
    held_.pop_front();
    first_ += count;
    return count;
  }
  set_shape(block, count, std::ssize(open_));
  for (Eigen::Index done = 0; done < count;) {
    const Held& front = held_.front();
    const auto from = static_cast<Eigen::Index>(first_ - front.first);
    const auto some = std::min(count - done, front.frames.rows() - from);
    block.middleRows(done, some) = front.frames.middleRows(from, some);
    done += some;
    first_ += some;
    if (from + some == front.frames.rows()) held_.pop_front();
  }
  return count;
}

std::vector<Check> GapBridge::checks() const {
  std::vector<Check> checks;
  for (std::size_t channel = 0; channel < open_.size(); ++channel) {
    const auto& open = open_[channel];
    if (open.num_gaps == 0 && open.num_before == 0) continue;
    std::string message;
    if (open.num_before > 0)
      message = fmt::format("no values before {:.6g} s, which is marked bad",
                            static_cast<double>(open.num_before) / options_.sample_rate_hz);
    if (open.num_gaps > 0)
      message += fmt::format("{}{} values missing in {} gaps, the first at {:.6g} s; bridged",
                             message.empty() ? "" : "; ", open.num_missing, open.num_gaps, open.first_place_s);
    checks.push_back({"sample.missing", options_.channels[channel], CheckStatus::warning,
                      static_cast<double>(open.num_before + open.num_missing), 0.0, std::move(message)});
  }
  return checks;
}

}  // namespace dsp
