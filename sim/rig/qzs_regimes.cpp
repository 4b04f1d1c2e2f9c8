#include "sim/rig/qzs_regimes.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>

namespace sim {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr int longest_transient = 60;  // cycles; at c = 0.8 1/s and 2 Hz a deviation has died out to e^-12

enum Branch : signed char { lower = -1, none = 0, upper = 1 };

const char* name(Branch branch) {
  return branch == none ? "free" : branch == upper ? "high" : "low";
}

/// A cycle of the base, about the zero of r at its middle.
struct Cycle {
  double from_s, middle_s, to_s;
  double correlation;  ///< sum of x r over it, x about its mean
  Branch branch;       ///< none: the payload is held in it
};

/// From where to where nobody touches the drive.
struct Hold {
  double from_s, to_s;
  bool is_driven, has_hand;
};

/// From here on.
struct Change {
  double from_s;
  Branch branch;
};

/// The passes of a programme up to to_s as a single one.
Programme unrolled(const Programme& programme, double to_s) {
  Programme whole{.name = programme.name, .nodes = {}, .manual = {}, .duration_s = 0.0};
  for (; whole.duration_s == 0.0 || whole.duration_s < to_s; whole.duration_s += programme.duration_s) {
    for (ProgrammeNode node : programme.nodes) {
      node.t_s += whole.duration_s;
      whole.nodes.push_back(node);
    }
    for (ManualForce hand : programme.manual) {
      hand.from_s += whole.duration_s;
      hand.to_s += whole.duration_s;
      whole.manual.push_back(hand);
    }
  }
  return whole;
}

std::vector<Hold> holds_of(const Programme& whole) {
  std::vector<double> begins;
  for (const ProgrammeNode& node : whole.nodes) begins.push_back(node.t_s);
  for (const ManualForce& hand : whole.manual) begins.insert(begins.end(), {hand.from_s, hand.to_s});
  std::sort(begins.begin(), begins.end());
  std::vector<Hold> holds;
  for (std::size_t i = 0; i < begins.size(); ++i) {
    Hold hold{begins[i], i + 1 < begins.size() ? begins[i + 1] : whole.duration_s, false, false};
    if (!(hold.from_s < hold.to_s)) continue;
    for (const ProgrammeNode& node : whole.nodes)
      if (node.t_s <= hold.from_s) hold.is_driven = node.harmonics_m[0] != 0.0;
    for (const ManualForce& hand : whole.manual) hold.has_hand |= hand.from_s <= hold.from_s && hand.to_s >= hold.to_s;
    holds.push_back(hold);
  }
  return holds;
}

/// Every half cycle of r; none while it is at rest.
std::vector<Cycle> cycles_of(const VectorXd& r, const Eigen::Ref<const VectorXd>& x, const std::vector<int>& modes,
                             double rate_hz) {
  std::vector<Cycle> cycles;
  std::vector<Index> zeros;  // first sample behind each, since r was last at rest
  for (Index i = 1; i < r.size(); ++i) {
    if (r[i] == 0.0 && r[i - 1] == 0.0) zeros.clear();
    if ((r[i] > 0.0) == (r[i - 1] > 0.0) || (r[i] == 0.0 && r[i - 1] <= 0.0)) continue;
    zeros.push_back(i);
    if (zeros.size() < 3) continue;
    const Index first = zeros[zeros.size() - 3], middle = zeros[zeros.size() - 2], count = i - first;
    const auto swing = x.segment(first, count);
    const double correlation = swing.dot(r.segment(first, count)) - swing.mean() * r.segment(first, count).sum();
    const bool held = std::any_of(modes.begin() + first, modes.begin() + i, [](int mode) { return mode == qzs_stick; });
    cycles.push_back({static_cast<double>(first) / rate_hz, static_cast<double>(middle) / rate_hz,
                      static_cast<double>(i) / rate_hz, correlation,
                      held                ? none
                      : correlation > 0.0 ? upper
                                          : lower});
  }
  return cycles;
}

/// The branch of the orbit on which the motion settles if the drive stays as in this hold.
Branch settled(const QzsRig& rig, Programme whole, const Hold& hold, double rate_hz) {
  std::erase_if(whole.nodes, [&](const ProgrammeNode& node) { return node.t_s > hold.from_s; });
  std::erase_if(whole.manual, [&](const ManualForce& hand) { return hand.from_s >= hold.to_s; });
  const double cycle_s = 1.0 / whole.nodes.back().frequency_hz;
  const double end_s = hold.to_s + longest_transient * cycle_s;
  whole.duration_s = end_s + cycle_s;
  QzsTrajectory trajectory(std::make_shared<const QzsRig>(rig.parameters(), whole), whole.duration_s);
  const auto count = static_cast<Index>(std::lround(cycle_s * rate_hz));
  VectorXd x(count), r(count);
  bool held = true;
  try {
    for (Index i = 0; i < count; ++i) {
      const QzsState& state = trajectory.at(end_s + cycle_s * static_cast<double>(i) / static_cast<double>(count));
      x[i] = state.x, r[i] = state.base.r_m;
      held &= state.mode == qzs_stick;
    }
  } catch (const Diverged&) {  // beyond any orbit
    return upper;
  }
  return !held && x.dot(r) - x.mean() * r.sum() > 0.0 ? upper : lower;
}

/// Where it passes from one cycle's branch to the next one's.
double passage_s(const Cycle& before, const Cycle& after) {
  const double from = before.correlation, to = after.correlation;
  const double fraction = (from > 0.0) != (to > 0.0) ? from / (from - to) : 0.5;
  return before.middle_s + fraction * (after.middle_s - before.middle_s);
}

/// Of a payload that has just come loose: the one on which it settles, if one of these cycles is on it; or the first.
Branch first_branch(std::span<const Cycle> cycles, Branch settles) {
  const auto has_settled = [&](const Cycle& cycle) { return cycle.branch == settles; };
  if (settles != none && std::any_of(cycles.begin(), cycles.end(), has_settled)) return settles;
  const auto moves = [](const Cycle& cycle) { return cycle.branch != none; };
  const auto first = std::find_if(cycles.begin(), cycles.end(), moves);
  return first != cycles.end() ? first->branch : none;
}

std::vector<Change> branches(const QzsRig& rig, const Programme& whole, const std::vector<Cycle>& cycles,
                             double rate_hz) {
  std::vector<Change> changes{{0.0, none}};
  const auto pass = [&](double from_s, Branch branch) {
    if (changes.back().branch != branch) changes.push_back({from_s, branch});
  };
  Branch now = none;
  std::size_t k = 0;
  for (const Hold& hold : holds_of(whole)) {
    const std::size_t first = k;
    while (k < cycles.size() && cycles[k].middle_s < hold.to_s) ++k;
    const std::span<const Cycle> here = std::span(cycles).subspan(first, k - first);
    const auto differs = [&](const Cycle& cycle) { return cycle.branch != none && cycle.branch != now; };
    const bool moves = std::any_of(here.begin(), here.end(), differs);
    const Branch settles = hold.has_hand             ? none
                           : moves && hold.is_driven ? settled(rig, whole, hold, rate_hz)
                                                     : now;  // there is no orbit about a base at rest
    if (hold.is_driven && changes.back().branch == none) {
      const Branch known = first_branch(here, settles);
      pass(hold.from_s, known != none ? known : lower);
    }
    for (std::size_t i = 0; i < here.size(); ++i) {
      const bool was_held = now == none;
      if (here[i].branch == none) {
        now = none;
        continue;
      }
      if (hold.has_hand)
        now = here[i].branch;
      else if (was_held)
        now = first_branch(here.subspan(i), settles);
      else if (here[i].branch == settles)
        now = settles;
      pass(i == 0     ? hold.from_s
           : was_held ? std::max(hold.from_s, here[i - 1].from_s)
                      : passage_s(here[i - 1], here[i]),
           now);
    }
    if (hold.has_hand) now = none;
    if (!hold.is_driven) {  // the last of the cycles ends as r comes to rest
      now = none;
      pass(k > first ? cycles[k - 1].to_s : hold.from_s, now);
    }
  }
  return changes;
}

/// Marks as held what slips for less than a cycle between two sticks.
void join_sticks(std::vector<bool>& held, const Programme& whole, double rate_hz) {
  auto node = whole.nodes.begin();
  std::size_t end_of_last = held.size();
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (!held[i]) continue;
    while (node + 1 != whole.nodes.end() && (node + 1)->t_s * rate_hz <= static_cast<double>(i)) ++node;
    if (end_of_last < i && static_cast<double>(i - end_of_last) * node->frequency_hz < rate_hz)
      std::fill(held.begin() + static_cast<std::ptrdiff_t>(end_of_last), held.begin() + static_cast<std::ptrdiff_t>(i),
                true);
    end_of_last = i + 1;
  }
}

}  // namespace

std::vector<RegimeInterval> true_regimes(const std::shared_ptr<const QzsRig>& rig, const Eigen::Ref<const VectorXd>& x,
                                         const std::vector<int>& modes, double sample_rate_hz) {
  if (x.size() != static_cast<Index>(modes.size()) || !(sample_rate_hz > 0.0))
    throw std::invalid_argument("true_regimes: needs a rate and one mode for each x");
  std::size_t near = 0;
  VectorXd r(x.size());
  for (Index i = 0; i < x.size(); ++i) r[i] = rig->base().at(static_cast<double>(i) / sample_rate_hz, near).r_m;
  const Programme whole = unrolled(rig->programme(), static_cast<double>(x.size()) / sample_rate_hz);
  const std::vector<Cycle> cycles = cycles_of(r, x, modes, sample_rate_hz);
  const std::vector<Change> changes = branches(*rig, whole, cycles, sample_rate_hz);
  std::vector<bool> held;
  for (const int mode : modes) held.push_back(mode == qzs_stick);
  join_sticks(held, whole, sample_rate_hz);

  std::vector<RegimeInterval> intervals;
  auto change = changes.begin();
  for (std::size_t i = 0; i < held.size(); ++i) {
    const double t = static_cast<double>(i) / sample_rate_hz;
    while (change + 1 != changes.end() && (change + 1)->from_s <= t) ++change;
    const char* label = held[i] ? "stick" : name(change->branch);
    if (intervals.empty() || intervals.back().label != label) intervals.push_back({label, t, t});
    intervals.back().to_s = static_cast<double>(i + 1) / sample_rate_hz;
  }
  return intervals;
}

}  // namespace sim
