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

/// The levels of the whole programme, however little of it is recorded; `motion` is continued for that.
RegimeOptions programme_levels(QzsTrajectory& trajectory, Motion motion) {
  const Programme& programme = trajectory.rig().programme();
  try {
    for (std::size_t n = motion.x.size(); static_cast<double>(n) <= programme.duration_s * truth_rate_hz; ++n)
      motion.keep(trajectory.at(static_cast<double>(n) / truth_rate_hz));
  } catch (const Diverged&) {  // only beyond the recording: what comes before it counts
  }
  return true_levels(motion.signal(), motion.modes, truth_rate_hz, programme);
}

std::vector<RegimeSpan> recorded_regimes(const RigTest& test, const Motion& motion, RegimeOptions options) {
  if (test.programme == "decay") {  // over within two seconds: margins and runs of a sweep would leave nothing
    options.stick_margin_s = 0.1;
    options.min_duration_s = 0.5;
  }
  std::vector<RegimeSpan> spans;
  for (RegimeSpan& span : true_regimes(motion.signal(), motion.modes, truth_rate_hz, options))
    if (span.to_s > test.from_s)
      spans.push_back({std::move(span.label), std::max(span.from_s - test.from_s, 0.0),
                       std::min(span.to_s - test.from_s, test.duration_s)});
  return spans;
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
  QzsTrajectory trajectory(test.rig, std::max(to_s, test.rig->programme().duration_s), [&] {
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
  truth.regimes = recorded_regimes(test, motion, programme_levels(trajectory, motion));
  return truth;
}

double rig_truth_bytes(const RigTest& test) {
  constexpr double bytes_per_row = 2.0 * (sizeof(double) + sizeof(int));  // of Motion, whose vectors grow by doubling
  return (test.from_s + test.duration_s) * truth_rate_hz * bytes_per_row;
}

}  // namespace sim
