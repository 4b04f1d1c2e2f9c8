#include "sim/rig/qzs_regimes.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <stdexcept>

#include "sim/rig/qzs_rig.hpp"

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

/// A frequency of the moving base, from when to when.
struct Dwell {
  double frequency_hz, from_s, to_s;
};

std::vector<Dwell> dwells_of(const Programme& programme) {
  std::vector<Dwell> dwells;
  for (std::size_t i = 0; i < programme.nodes.size(); ++i) {
    const ProgrammeNode& node = programme.nodes[i];
    const double to_s = i + 1 < programme.nodes.size() ? programme.nodes[i + 1].t_s : programme.duration_s;
    if (node.harmonics_m[0] == 0.0) continue;
    if (!dwells.empty() && dwells.back().to_s == node.t_s && dwells.back().frequency_hz == node.frequency_hz)
      dwells.back().to_s = to_s;
    else
      dwells.push_back({node.frequency_hz, node.t_s, to_s});
  }
  return dwells;
}

/// What x has settled to at the end of a dwell; no amplitude if it does not count.
struct Swing {
  double amplitude_m = 0.0;
  bool upper = false;
};

/// From exact x, r and modes at a rate.
Swing settled_swing(const Dwell& dwell, const std::vector<ManualForce>& hands,
                    const Eigen::Ref<const Eigen::VectorXd>& x, const Eigen::VectorXd& r, const std::vector<int>& modes,
                    double sample_rate_hz) {
  double from_s = dwell.to_s - (dwell.to_s - dwell.from_s) / 3.0;
  for (const ManualForce& hand : hands)
    if (hand.from_s < dwell.to_s) from_s = std::max(from_s, hand.to_s);
  const auto first = static_cast<Index>(std::ceil(from_s * sample_rate_hz)),
             last = static_cast<Index>(std::floor(dwell.to_s * sample_rate_hz)),
             cycle = static_cast<Index>(std::ceil(sample_rate_hz / dwell.frequency_hz));
  if (last > x.size() || last - first < cycle ||
      std::find(modes.begin() + first, modes.begin() + last, static_cast<int>(qzs_stick)) != modes.begin() + last)
    return {};
  const auto end = x.segment(last - cycle, cycle);
  return {0.5 * (end.maxCoeff() - end.minCoeff()),
          x.segment(first, last - first).dot(r.segment(first, last - first)) > 0.0};
}

Eigen::VectorXd base_motion(const Programme& programme, Index num_samples, double sample_rate_hz) {
  const BaseMotion base(programme);
  std::size_t near = 0;
  Eigen::VectorXd r(num_samples);
  for (Index n = 0; n < num_samples; ++n) r[n] = base.at(static_cast<double>(n) / sample_rate_hz, near).r_m;
  return r;
}

}  // namespace

RegimeOptions true_levels(const Eigen::Ref<const Eigen::VectorXd>& x, const std::vector<int>& modes,
                          double sample_rate_hz, const Programme& programme) {
  if (x.size() != static_cast<Index>(modes.size()) || !(sample_rate_hz > 0.0))
    throw std::invalid_argument("true_levels: needs a rate and one mode for each x");
  const Eigen::VectorXd r = base_motion(programme, x.size(), sample_rate_hz);
  double smallest_upper = INFINITY, before_to_s = -1.0, largest_before = 0.0, log_after = 0.0;
  int num_jumps = 0;
  Swing before;
  for (const Dwell& dwell : dwells_of(programme)) {
    const Swing swing = settled_swing(dwell, programme.manual, x, r, modes, sample_rate_hz);
    if (swing.upper) {
      smallest_upper = std::min(smallest_upper, swing.amplitude_m);
      if (before_to_s == dwell.from_s && before.amplitude_m > 0.0 && !before.upper) {
        largest_before = std::max(largest_before, before.amplitude_m);
        log_after += std::log(swing.amplitude_m);
        ++num_jumps;
      }
    }
    before = swing;
    before_to_s = dwell.to_s;
  }
  RegimeOptions options;
  options.high_leave_m = 0.8 * smallest_upper;
  options.high_enter_m = options.high_leave_m;
  if (num_jumps > 0) options.high_enter_m = std::max(0.625 * std::exp(log_after / num_jumps), 1.1 * largest_before);
  options.high_leave_m = std::min(options.high_leave_m, options.high_enter_m);
  return options;
}

std::vector<RegimeInterval> true_regimes(const Eigen::Ref<const Eigen::VectorXd>& x, const std::vector<int>& modes,
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
  std::vector<RegimeInterval> spans;
  for (const Run& run : join_short(runs_of(labels), options.min_duration_s * sample_rate_hz))
    spans.push_back({name(run.label), static_cast<double>(run.first) / sample_rate_hz,
                     static_cast<double>(run.last) / sample_rate_hz});
  return spans;
}

}  // namespace sim
