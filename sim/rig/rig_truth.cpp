#include "sim/rig/rig_truth.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sim {
namespace {

/// Exact x and modes at truth_rate_hz.
struct Motion {
  std::vector<double> x;
  std::vector<int> modes;

  void keep(const QzsState& state) {
    x.push_back(state.x);
    modes.push_back(state.mode);
  }
  [[nodiscard]] Eigen::Map<const Eigen::VectorXd> signal() const { return {x.data(), std::ssize(x)}; }
};

std::vector<RegimeInterval> recorded_regimes(const RigTest& test, const Motion& motion) {
  std::vector<RegimeInterval> intervals;
  for (RegimeInterval& interval : true_regimes(test.rig, motion.signal(), motion.modes, truth_rate_hz))
    if (interval.to_s > test.from_s)
      intervals.push_back({std::move(interval.label), std::max(interval.from_s - test.from_s, 0.0),
                           std::min(interval.to_s - test.from_s, test.duration_s)});
  return intervals;
}

std::vector<HandTruth> recorded_hands(const RigTest& test, const Motion& motion) {
  const double to_s = test.from_s + test.duration_s;
  const Programme& programme = test.rig->programme();
  std::vector<HandTruth> hands;
  for (double start_s = 0.0; start_s < to_s; start_s += programme.duration_s)
    for (const ManualForce& hand : programme.manual) {
      if (!(start_s + hand.to_s > test.from_s && start_s + hand.from_s < to_s)) continue;
      const double shift_s = start_s - test.from_s;
      hands.push_back({hand.from_s + shift_s, hand.to_s + shift_s, hand.why});
      if (hand.grip_s <= 0.0) continue;
      const auto n = static_cast<std::size_t>(std::llround((start_s + hand.to_s) * truth_rate_hz));
      hands.back().released_at_m = n < motion.x.size() ? motion.x[n] : std::numeric_limits<double>::quiet_NaN();
    }
  return hands;
}

}  // namespace

RigTruth rig_truth(const RigTest& test, const RigTruthOptions& options) {
  const double to_s = test.from_s + test.duration_s;
  const auto num_rows = static_cast<std::int64_t>(std::floor(to_s * truth_rate_hz)) + 1;
  const auto first_row = static_cast<std::int64_t>(std::ceil(test.from_s * truth_rate_hz));
  Motion motion;
  QzsTrajectory trajectory(test.rig, to_s, [&] {
    const auto done = static_cast<double>(motion.x.size()) / static_cast<double>(num_rows);
    if (options.progress) options.progress(std::min(done, 1.0));
  });
  for (std::int64_t n = 0; n < num_rows; ++n) {
    const QzsState& state = trajectory.at(static_cast<double>(n) / truth_rate_hz);
    motion.keep(state);
    if (n >= first_row && options.take) options.take(state);
  }
  RigTruth truth;
  truth.num_events = std::count_if(trajectory.events().begin(), trajectory.events().end(),
                                   [&](const Event& event) { return event.t_s >= test.from_s && event.t_s <= to_s; });
  truth.hands = recorded_hands(test, motion);
  truth.regimes = recorded_regimes(test, motion);
  return truth;
}

double rig_truth_bytes(const RigTest& test) {
  constexpr double bytes_per_row = 2.0 * (sizeof(double) + sizeof(int));  // of Motion, whose vectors grow by doubling
  return (test.from_s + test.duration_s) * truth_rate_hz * bytes_per_row;
}

}  // namespace sim
