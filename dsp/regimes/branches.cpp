#include "dsp/regimes/branches.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <utility>

#include "dsp/regimes/harmonics.hpp"
#include "dsp/regimes/switching_model.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr std::size_t transient_cycles = 10;  // in which a response has settled

/// Half cycles that tell a branch.
struct Observations {
  std::vector<const HalfCycle*> halves;
  std::vector<bool> begins_anew;  ///< between it and the one before the motion rested
  bool begins_at_rest = false;    ///< so it did before the first
  [[nodiscard]] std::size_t size() const { return halves.size(); }
};

Observations observations_of(std::span<const HalfCycle> half_cycles, const std::vector<bool>& held,
                             const std::vector<unsigned char>& excluded) {
  const auto count = [](const auto& samples, const HalfCycle& half) {
    return std::count_if(samples.begin() + half.first, samples.begin() + half.last, [](auto one) { return one != 0; });
  };
  Observations seen;
  bool anew = true;
  for (const HalfCycle& half : half_cycles) {
    const Index num_held = count(held, half);
    const bool shows_none = !std::isfinite(half.phase_variance) || half.amplitude <= 0.0;
    if (shows_none && count(excluded, half) > 0) continue;
    if (shows_none || 2 * num_held >= half.last - half.first) {
      anew = true;
      seen.begins_at_rest |= seen.halves.empty();
    } else if (num_held == 0) {
      seen.halves.push_back(&half);
      seen.begins_anew.push_back(std::exchange(anew, false));
    }
  }
  return seen;
}

/// Concentration of a von Mises density with this mean cosine of so many, [MJ00] Eq. (5.3.9) after its rational
/// approximation; none and all are known to one of them.
double concentration_of(double mean_cosine, double count) {
  const double r = std::clamp(mean_cosine, 1.0 / (2.0 * count), 1.0 - 1.0 / (2.0 * count));
  return r * (2.0 - r * r) / (1.0 - r * r);
}

/// Half the logarithm of how much more probable each half cycle is on the upper branch.
VectorXd evidence(const Observations& seen, double concentration) {
  VectorXd weights(static_cast<Index>(seen.size()));
  for (Index k = 0; k < weights.size(); ++k) {
    const HalfCycle& half = *seen.halves[static_cast<std::size_t>(k)];
    weights(k) = half.cosine / (1.0 / concentration + half.phase_variance);
  }
  return weights;
}

StateSequence states_of(const Observations& seen, const VectorXd& weights, double switch_probability) {
  Eigen::MatrixX2d log_likelihoods(weights.size(), 2);
  log_likelihoods << -weights, weights;
  return most_probable_states(log_likelihoods, seen.begins_anew, switch_probability);
}

/// Expectation maximisation of concentration and switch probability.
StateSequence fitted_states(const Observations& seen) {
  const auto count = static_cast<double>(seen.size());
  double concentration = 1.0;
  return fit_hmm(seen.size(), [&](double switch_probability) {
    const StateSequence states = states_of(seen, evidence(seen, concentration), switch_probability);
    double mean = 0.0;
    for (std::size_t k = 0; k < seen.size(); ++k)
      mean += (2.0 * states.probability(static_cast<Index>(k)) - 1.0) * seen.halves[k]->cosine / count;
    concentration = concentration_of(mean, count);
    return states;
  });
}

/// Whether the drive is the same in two half cycles: its cycle to a sample, its level to what that and noise do to it.
bool same_drive(const HalfCycle& a, const HalfCycle& b) {
  const auto of_a = static_cast<double>(a.last - a.first), of_b = static_cast<double>(b.last - b.first);
  return std::abs(of_a - of_b) <= 1.0 && std::abs(a.drive_level - b.drive_level) <=
                                             1.0 / of_a + noise_stds * std::sqrt(a.drive_variance + b.drive_variance);
}

/// Out of a rest a response is on no branch, on its way to one: from the start it is on that which it is on when it has
/// settled: when the drive is no longer what it is after transient_cycles.
void settle_after_rests(const Observations& seen, StateSequence& states) {
  const std::size_t count = states.states.size(), settling = 2 * transient_cycles;
  for (std::size_t k = seen.begins_at_rest ? 0 : 1; k < count; ++k) {
    if (k > 0 && !seen.begins_anew[k]) continue;
    std::size_t last = k;
    while (last + 1 < count && !seen.begins_anew[last + 1] &&
           (last + 1 < k + settling || same_drive(*seen.halves[last + 1], *seen.halves[k + settling - 1])))
      ++last;
    if (last + 1 < k + settling) continue;  // it rests again before it has settled
    for (std::size_t i = k; i < last; ++i) {
      if (states.states[i] == states.states[last]) continue;
      states.states[i] = states.states[last];
      states.probability(static_cast<Index>(i)) = states.probability(static_cast<Index>(last));
    }
  }
}

/// By how much the mean logarithm of the amplitude changes at each half cycle, from transient_cycles before to as many
/// behind, or as many as there are in a row; none where a row begins.
std::vector<std::optional<double>> amplitude_changes(const Observations& seen) {
  constexpr std::size_t width = 2 * transient_cycles;
  const std::size_t count = seen.size();
  std::vector<double> sums{0.0};
  std::vector<std::size_t> begin(count), end(count, count);  // of the row that each is in
  for (std::size_t k = 0; k < count; ++k) {
    sums.push_back(sums.back() + std::log(seen.halves[k]->amplitude));
    begin[k] = k == 0 || seen.begins_anew[k] ? k : begin[k - 1];
  }
  for (std::size_t k = count; k-- > 0;) end[k] = k + 1 == count || seen.begins_anew[k + 1] ? k + 1 : end[k + 1];
  std::vector<std::optional<double>> result(count);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t before = std::min(width, k - begin[k]), behind = std::min(width, end[k] - k);
    if (before > 0)
      result[k] = (sums[k + behind] - sums[k]) / static_cast<double>(behind) -
                  (sums[k] - sums[k - before]) / static_cast<double>(before);
  }
  return result;
}

/// What it gains to give the changes at switches, Laplace distributed as steps of a programme are, a scale of their
/// own: twice the log-likelihood less Akaike's price of a parameter.
double gain_of_jumps(const std::vector<std::optional<double>>& all, const std::vector<int>& states) {
  constexpr std::size_t width = 2 * transient_cycles;
  std::vector<std::size_t> switches;
  for (std::size_t k = 1; k < states.size(); ++k)
    if (states[k] != states[k - 1] && all[k]) switches.push_back(k);
  double elsewhere = 0.0, at_switches = 0.0, num_elsewhere = 0.0;
  auto next = switches.begin();
  for (std::size_t k = 0; k < states.size(); ++k) {
    while (next != switches.end() && *next + width <= k) ++next;
    if (all[k] && (next == switches.end() || k + width <= *next)) elsewhere += std::abs(*all[k]), num_elsewhere += 1.0;
  }
  for (const std::size_t k : switches) at_switches += std::abs(*all[k]);
  if (switches.empty() || num_elsewhere == 0.0) return 0.0;
  const auto num_switches = static_cast<double>(switches.size());
  const double ratio = (at_switches / num_switches) / (elsewhere / num_elsewhere);
  if (ratio <= 1.0) return 0.0;
  return 2.0 * num_switches * (ratio - 1.0 - std::log(ratio)) - 2.0;
}

/// Whether the larger amplitude is the one in phase with the drive: of a spring that hardens. Of one that softens, or a
/// force that counts against x, it is the other.
bool grows_in_phase(const std::vector<std::optional<double>>& changes, const std::vector<int>& states) {
  double growth = 0.0;
  for (std::size_t k = 1; k < states.size(); ++k)
    if (states[k] != states[k - 1]) growth += (states[k] == 1 ? 1.0 : -1.0) * changes[k].value_or(0.0);
  return growth >= 0.0;
}

/// Where the level passes zero between the middles of two half cycles (samples); halfway where it does not.
double crossing(const Observations& seen, const VectorXd& level, Index k) {
  const double from = static_cast<double>(seen.halves[static_cast<std::size_t>(k - 1)]->middle),
               to = static_cast<double>(seen.halves[static_cast<std::size_t>(k)]->middle);
  const bool passes = (level(k) > 0.0) != (level(k - 1) > 0.0);
  return from + (passes ? level(k - 1) / (level(k - 1) - level(k)) : 0.5) * (to - from);
}

/// Standard deviation (samples) of a switch before half cycle k: that of the crossings it may be instead, as far as
/// half the way to the switches beside it, and of the crossing itself by noise, sampling and a lag of less than a
/// sample.
double switch_std(const Observations& seen, const VectorXd& level, const StateSequence& states, Index k, Index from,
                  Index to) {
  const double here = crossing(seen, level, k);
  double sum = 0.0, square = 0.0;
  for (Index j = from; j < to; ++j) {
    if (seen.begins_anew[static_cast<std::size_t>(j)] || (level(j) > 0.0) == (level(j - 1) > 0.0)) continue;
    const double away = crossing(seen, level, j) - here;
    sum += states.switch_probability(j), square += states.switch_probability(j) * away * away;
  }
  const HalfCycle &before = *seen.halves[static_cast<std::size_t>(k - 1)],
                  &after = *seen.halves[static_cast<std::size_t>(k)];
  const double slope = (after.cosine - before.cosine) / static_cast<double>(after.middle - before.middle);
  const double turn = 2.0 * std::numbers::pi / static_cast<double>(after.last - after.first);
  const double phase_variance = after.phase_variance + rounding * turn * turn;
  return std::sqrt((sum > 0.0 ? square / sum : 0.0) + (slope != 0.0 ? phase_variance / (slope * slope) : 0.0) +
                   rounding);
}

std::vector<BranchInterval> intervals_of(const Observations& seen, const VectorXd& level, const StateSequence& states,
                                         double sample_rate_hz) {
  std::vector<Index> begins;
  for (Index k = 0; k < level.size(); ++k)
    if (k == 0 || states.states[static_cast<std::size_t>(k)] != states.states[static_cast<std::size_t>(k - 1)])
      begins.push_back(k);
  begins.push_back(level.size());
  std::vector<BranchInterval> intervals;
  for (std::size_t i = 0; i + 1 < begins.size(); ++i) {
    const Index k = begins[i], end = begins[i + 1];
    const auto at = static_cast<std::size_t>(k);
    BranchInterval interval{.upper = states.states[at] == 1};
    const double upper = states.probability.segment(k, end - k).mean();
    interval.probability = interval.upper ? upper : 1.0 - upper;
    if (i > 0 && seen.begins_anew[at]) {  // somewhere in what was held
      interval.first = seen.halves[at - 1]->last;
    } else if (i > 0) {
      interval.first = static_cast<Index>(std::ceil(crossing(seen, level, k)));
      const Index from = (begins[i - 1] + k) / 2 + 1, to = (k + end) / 2 + 1;
      interval.first_std_s = switch_std(seen, level, states, k, from, std::min(to, level.size())) / sample_rate_hz;
    }
    intervals.push_back(interval);
  }
  return intervals;
}

VectorXd correlations(const Observations& seen) {
  VectorXd level(static_cast<Index>(seen.size()));
  for (Index k = 0; k < level.size(); ++k) level(k) = seen.halves[static_cast<std::size_t>(k)]->correlation;
  return level;
}

}  // namespace

Branches find_branches(std::span<const HalfCycle> half_cycles, const std::vector<bool>& held,
                       const std::vector<unsigned char>& excluded, double sample_rate_hz) {
  const Observations seen = observations_of(half_cycles, held, excluded);
  if (seen.size() == 0) return {{{}}, "no phase against what drives the motion: one branch"};
  StateSequence states = fitted_states(seen);
  const bool switches =
      std::adjacent_find(states.states.begin(), states.states.end(), std::not_equal_to<>()) != states.states.end();
  const auto one = [&](std::string remark) {
    return Branches{{{.upper = evidence(seen, 1.0).sum() > 0.0}}, std::move(remark)};
  };
  if (!switches)
    return one(states.states.front() == 1 ? "x always moves in phase with what drives it: one branch"
                                          : "x always moves against what drives it: one branch");
  const auto changes = amplitude_changes(seen);
  if (gain_of_jumps(changes, states.states) <= 0.0)
    return one("the amplitude does not jump where the phase turns: one branch");
  const bool hardens = grows_in_phase(changes, states.states);
  settle_after_rests(seen, states);
  Branches found{intervals_of(seen, correlations(seen), states, sample_rate_hz), {}};
  const auto count = found.intervals.size() - 1;
  if (!hardens)
    for (BranchInterval& interval : found.intervals) interval.upper = !interval.upper;
  if (count == 0) {
    found.remark = "x changes its branch on its way out of a rest only: one branch";
    return found;
  }
  found.remark =
      fmt::format("{} change{} between a lower branch (x {}) and an upper one ({})", count, count == 1 ? "" : "s",
                  hardens ? "against its drive" : "in phase with its drive", hardens ? "in phase" : "against it");
  return found;
}

Branches branches_by_amplitude(std::span<const HalfCycle> half_cycles, double high_amplitude, double sample_rate_hz) {
  Observations seen;
  VectorXd level(static_cast<Index>(half_cycles.size()));
  for (const HalfCycle& half : half_cycles) {
    if (!(half.amplitude > 0.0)) continue;
    level(static_cast<Index>(seen.size())) = std::log(half.amplitude / high_amplitude);
    seen.halves.push_back(&half);
    seen.begins_anew.push_back(seen.size() == 1);
  }
  if (seen.size() == 0) return {{{}}, "no motion"};
  level.conservativeResize(static_cast<Index>(seen.size()));
  const Index steps = std::max<Index>(1, level.size() - 1);
  const double spread = (level.tail(level.size() - 1) - level.head(level.size() - 1)).norm() / std::sqrt(steps);
  const VectorXd weights = level / std::max(spread, 1e-9);
  const StateSequence states =
      fit_hmm(seen.size(), [&](double switch_probability) { return states_of(seen, weights, switch_probability); });
  return {intervals_of(seen, level, states, sample_rate_hz), fmt::format("high is above {:.3g}", high_amplitude)};
}

}  // namespace dsp
