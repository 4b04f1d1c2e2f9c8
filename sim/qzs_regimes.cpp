#include "sim/qzs_regimes.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <stdexcept>

#include "sim/qzs_rig.hpp"

namespace sim {
namespace {

using Eigen::Index;

enum class Label { low, high, stick };
const char* name(Label label) {
  return label == Label::stick ? "stick" : label == Label::high ? "high" : "low";
}

/// Mean over the centred window of `half` samples to either side, cut at the ends.
Eigen::VectorXd moving_mean(const Eigen::VectorXd& x, Index half) {
  Eigen::VectorXd sums(x.size() + 1), mean(x.size());
  sums[0] = 0.0;
  for (Index n = 0; n < x.size(); ++n) sums[n + 1] = sums[n] + x[n];
  for (Index n = 0; n < x.size(); ++n) {
    const Index first = std::max<Index>(n - half, 0), last = std::min(n + half + 1, x.size());
    mean[n] = (sums[last] - sums[first]) / static_cast<double>(last - first);
  }
  return mean;
}

/// Largest value over the centred window; the queue holds candidates in falling order.
Eigen::VectorXd moving_max(const Eigen::VectorXd& x, Index half) {
  Eigen::VectorXd result(x.size());
  std::deque<Index> falling;
  for (Index n = 0, next = 0; n < x.size(); ++n) {
    for (; next < std::min(n + half + 1, x.size()); ++next) {
      while (!falling.empty() && x[falling.back()] <= x[next]) falling.pop_back();
      falling.push_back(next);
    }
    while (falling.front() < n - half) falling.pop_front();
    result[n] = x[falling.front()];
  }
  return result;
}

struct Run {
  Label label;
  Index first, last;  ///< [first, last)
};

std::vector<Run> runs_of(const std::vector<Label>& labels) {
  std::vector<Run> runs;
  for (Index n = 0; n < static_cast<Index>(labels.size()); ++n) {
    const Label label = labels[static_cast<std::size_t>(n)];
    if (runs.empty() || runs.back().label != label) runs.push_back({label, n, n});
    runs.back().last = n + 1;
  }
  return runs;
}

std::vector<Run> join_short(const std::vector<Run>& runs, double min_samples) {
  std::vector<Run> joined;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    Run run = runs[i];
    const bool is_short = run.label != Label::stick && static_cast<double>(run.last - run.first) < min_samples;
    // The run before a short one is the stick it lies between, or the amplitude it briefly left.
    if (is_short && !joined.empty()) run.label = joined.back().label;
    if (!joined.empty() && joined.back().label == run.label)
      joined.back().last = run.last;
    else
      joined.push_back(run);
  }
  return joined;
}

}  // namespace

std::vector<RegimeSpan> true_regimes(const Eigen::Ref<const Eigen::VectorXd>& x, const std::vector<int>& modes,
                                     double sample_rate_hz, const RegimeOptions& options) {
  if (x.size() != static_cast<Index>(modes.size()) || !(sample_rate_hz > 0.0))
    throw std::invalid_argument("true_regimes: needs a rate and one mode for each x");
  const auto half = [&](double window_s) { return std::max<Index>(std::llround(0.5 * window_s * sample_rate_hz), 1); };
  const Eigen::VectorXd swing = x - moving_mean(x, half(options.mean_s));
  const Eigen::VectorXd envelope =
      0.5 * (moving_max(swing, half(options.envelope_s)) + moving_max(-swing, half(options.envelope_s)));
  Eigen::VectorXd stuck(x.size());
  for (Index n = 0; n < x.size(); ++n) stuck[n] = modes[static_cast<std::size_t>(n)] == qzs_stick ? 1.0 : 0.0;
  stuck = moving_max(stuck, std::llround(options.stick_margin_s * sample_rate_hz));

  std::vector<Label> labels;
  Label amplitude = Label::low;
  for (Index n = 0; n < x.size(); ++n) {
    if (envelope[n] > options.high_enter_m) amplitude = Label::high;
    if (envelope[n] < options.high_leave_m) amplitude = Label::low;
    labels.push_back(stuck[n] > 0.0 ? Label::stick : amplitude);
  }
  std::vector<RegimeSpan> spans;
  for (const Run& run : join_short(runs_of(labels), options.min_duration_s * sample_rate_hz))
    spans.push_back({name(run.label), static_cast<double>(run.first) / sample_rate_hz,
                     static_cast<double>(run.last) / sample_rate_hz});
  return spans;
}

}  // namespace sim
