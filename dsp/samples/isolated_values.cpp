#include "dsp/samples/isolated_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "dsp/values/order_statistics.hpp"

namespace dsp {
namespace {

using Eigen::Index;

constexpr Index frames_to_learn = 4096;  ///< that tell how large steps are
constexpr std::size_t around = 16;       ///< values on either side that tell it of their place
constexpr Index context = 64;            ///< frames: most of which are values
constexpr std::size_t most_in_a_row = 3;
constexpr double beyond = 10.0;           ///< of steps: noise of any usual kind stays below a third of it
constexpr double return_fraction = 0.05;  ///< of the way out that may be missing on the way back: a code stands far off
constexpr std::ptrdiff_t least_alike = 3;  ///< of one number, where a shock may be as high

/// The values of a channel that are not missing, and where they are.
struct Values {
  std::vector<double> values;
  std::vector<Index> rows;
};

Values present(const Eigen::Ref<const FrameBlock>& frames, Index channel) {
  Values found;
  for (Index i = 0; i < frames.rows(); ++i)
    if (const double value = frames(i, channel); std::isfinite(value)) {
      found.values.push_back(value);
      found.rows.push_back(i);
    }
  return found;
}

/// What three steps in four from value to value stay below; at least the smallest that is not zero.
double usual_step(const std::vector<double>& values) {
  std::vector<double> steps;
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < values.size(); ++i) {
    steps.push_back(std::abs(values[i] - values[i - 1]));
    if (steps.back() > 0.0) smallest = std::min(smallest, steps.back());
  }
  return std::isinf(smallest) ? 0.0 : std::max(smallest, quantile_in_place(steps, 0.75));
}

/// No step is missing, and more than one in four is a tenth of the largest or more: none is then `beyond` what is
/// usual. Tells most records in a fraction of the time of usual_step.
bool has_no_large_step(const Eigen::Ref<const FrameBlock>& frames, Index channel) {
  const Index count = frames.rows() - 1;
  if (count < 1) return true;
  const Eigen::ArrayXd values = frames.col(channel), steps = (values.tail(count) - values.head(count)).abs();
  return steps.allFinite() && (beyond * steps >= steps.maxCoeff()).count() > steps.size() / 4 + 1;
}

/// How many values from `at` on stand alone, farther than `least` from those before and behind; 0: none.
std::size_t num_alone(const std::vector<double>& values, std::size_t at, double least) {
  if (values.size() < 2 || (at > 0 && std::abs(values[at] - values[at - 1]) <= least)) return 0;
  for (std::size_t count = 1; count <= most_in_a_row && at + count <= values.size(); ++count) {
    const bool is_last = at + count == values.size();
    if (at == 0 && is_last) return 0;
    const double behind = is_last ? values[at - 1] : values[at + count], before = at == 0 ? behind : values[at - 1];
    double distance = std::numeric_limits<double>::infinity();
    for (std::size_t i = at; i < at + count; ++i)
      distance = std::min({distance, std::abs(values[i] - before), std::abs(values[i] - behind)});
    if (distance > least && std::abs(before - behind) <= std::max(0.5 * least, return_fraction * distance))
      return count;
  }
  return 0;
}

/// The values around [first, last), which is left out.
std::vector<double> neighbours(const std::vector<double>& values, std::size_t first, std::size_t last) {
  std::vector<double> near(values.begin() + static_cast<std::ptrdiff_t>(first - std::min(first, around)),
                           values.begin() + static_cast<std::ptrdiff_t>(first));
  near.insert(near.end(), values.begin() + static_cast<std::ptrdiff_t>(last),
              values.begin() + static_cast<std::ptrdiff_t>(std::min(last + around, values.size())));
  return near;
}

/// Which of them stand alone.
std::vector<std::size_t> alone(const std::vector<double>& values) {
  std::vector<std::size_t> found;
  const double least = beyond * usual_step(values);
  for (std::size_t at = 0; least > 0.0 && at < values.size(); ++at) {
    const std::size_t count = num_alone(values, at, least);
    if (count == 0 || num_alone(values, at, beyond * usual_step(neighbours(values, at, at + count))) == 0) continue;
    for (std::size_t i = at; i < at + count; ++i) found.push_back(i);
    at += count;
  }
  return found;
}

}  // namespace

IsolatedValues::IsolatedValues(const std::vector<Channel>& channels, double sample_rate_hz)
    : channels_(channels), sample_rate_hz_(sample_rate_hz), found_(channels.size()) {}

// Of the first rows that are held, seen by themselves, those that are still to leave, before `last`.
void IsolatedValues::decide(Index channel, Index last, Index num_seen) {
  if (has_no_large_step(held_.topRows(num_seen), channel)) return;
  const Values seen = present(held_.topRows(num_seen), channel);
  const int order = info_of(channels_[static_cast<std::size_t>(channel)].role).order;
  const bool may_jump = order != 0 && order != 1;
  const std::vector<std::size_t> found = alone(seen.values);
  Found& noted = found_[static_cast<std::size_t>(channel)];
  for (const std::size_t i : found) {
    const double value = seen.values[i];
    const auto alike =
        std::count_if(found.begin(), found.end(), [&](std::size_t other) { return seen.values[other] == value; });
    if (seen.rows[i] < decided_ || seen.rows[i] >= last || (may_jump && alike < least_alike)) continue;
    if (noted.count++ == 0) {
      noted.first = first_ + seen.rows[i];
      noted.level = value;
    }
    held_(seen.rows[i], channel) = std::numeric_limits<double>::quiet_NaN();
  }
}

void IsolatedValues::decide(Index last, Index num_seen, FrameBlock& leaving) {
  for (Index channel = 0; channel < held_.cols(); ++channel) decide(channel, last, num_seen);
  const Index before = leaving.rows(), kept_from = std::max<Index>(0, last - context);
  leaving.conservativeResize(before + last - decided_, held_.cols());
  leaving.bottomRows(last - decided_) = held_.middleRows(decided_, last - decided_);
  held_ = FrameBlock(held_.bottomRows(held_.rows() - kept_from));
  first_ += kept_from;
  decided_ = last - kept_from;
}

FrameBlock IsolatedValues::push(const FrameBlock& frames) {
  held_.conservativeResize(held_.rows() + frames.rows(), frames.cols());
  held_.bottomRows(frames.rows()) = frames;
  FrameBlock leaving(0, frames.cols());
  while (held_.rows() >= decided_ + frames_to_learn + context)
    decide(decided_ + frames_to_learn, decided_ + frames_to_learn + context, leaving);
  return leaving;
}

FrameBlock IsolatedValues::finish() {
  FrameBlock leaving(0, held_.cols());
  decide(held_.rows(), held_.rows(), leaving);
  return leaving;
}

std::vector<Check> IsolatedValues::checks() const {
  std::vector<Check> checks;
  for (std::size_t c = 0; c < channels_.size(); ++c)
    if (const Found& found = found_[c]; found.count > 0)
      checks.push_back({"sample.isolated", channels_[c].name, CheckStatus::warning, static_cast<double>(found.count),
                        0.0,
                        fmt::format("{} value{} far from all around, the first {:.6g} {} at {:.6g} s: taken as missing",
                                    found.count, found.count > 1 ? "s" : "", found.level, channels_[c].unit,
                                    static_cast<double>(found.first) / sample_rate_hz_)});
  return checks;
}

}  // namespace dsp
