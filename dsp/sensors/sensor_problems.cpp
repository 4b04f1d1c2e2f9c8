#include "dsp/sensors/sensor_problems.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include "dsp/values/constants.hpp"

namespace dsp {
namespace {

constexpr double significant_stds = 4.0;
constexpr double least_gain = 3e-3, least_lag_s = 50e-6, least_cutoff_hz = 0.02, least_cutoff_fraction = 0.05;

// Of a displacement, a velocity, an acceleration.
constexpr std::array si_units{"m", "m/s", "m/s^2"};

/// A ratio of the second of a pair to the derivative of the first that two units explain.
struct UnitRatio {
  double ratio;
  bool first;        ///< whether the first of the two is in the wrong unit
  int order;         ///< of that one: displacement, velocity, acceleration
  const char* unit;  ///< what it is in
  const char* what;
};
// The first that fits counts: millimetres are read as metres more often than the other way round.
constexpr std::array unit_ratios{UnitRatio{1e3, false, 1, "mm/s", "mm/s read as m/s"},
                                 UnitRatio{1e-3, true, 0, "mm", "millimetres read as metres"},
                                 UnitRatio{1e3, true, 0, "m", "metres read as millimetres"},
                                 UnitRatio{1e-2, true, 0, "cm", "centimetres read as metres"},
                                 UnitRatio{1e-6, true, 0, "um", "micrometres read as metres"},
                                 UnitRatio{1e6, true, 0, "m", "metres read as micrometres"},
                                 UnitRatio{0.0254, true, 0, "in", "inches read as metres"},
                                 UnitRatio{1e-3, true, 1, "mm/s", "mm/s read as m/s"},
                                 UnitRatio{1e3, true, 1, "m/s", "m/s read as mm/s"},
                                 UnitRatio{0.0254, true, 1, "in/s", "in/s read as m/s"},
                                 UnitRatio{1.0 / gravity, false, 2, "g", "g read as m/s^2"},
                                 UnitRatio{gravity, false, 2, "m/s^2", "m/s^2 read as g"}};

std::optional<UnitRatio> unit_ratio(const SensorRelation& r) {
  constexpr double sensors_differ = 0.12;  // by less than this, of one unit
  for (const UnitRatio& known : unit_ratios)
    if (known.order == r.from_order + (known.first ? 0 : r.order) &&
        std::abs(std::log(r.gain / known.ratio)) < sensors_differ)
      return known;
  return std::nullopt;
}

/// gain = acceleration / displacement: an accelerometer that reads too much has more volts a unit than it is said to.
double sensitivity_factor(const SensorRelation& relation, bool of_displacement) {
  return of_displacement ? 1.0 / relation.gain : relation.gain;
}

SensorProblem polarity(const SensorRelation& r) {
  SensorProblem problem{.kind = SensorProblemKind::polarity, .channel = r.acceleration, .value = -1.0, .either = true};
  problem.sentence = fmt::format("{} and {} have opposite signs", r.displacement, r.acceleration);
  return problem;
}

SensorProblem unit(const SensorRelation& r, const UnitRatio& known) {
  SensorProblem problem{.kind = SensorProblemKind::unit, .value = r.gain, .std = r.gain_std, .limit = known.ratio};
  problem.channel = known.first ? r.displacement : r.acceleration;
  problem.unit = known.unit;
  problem.sensitivity_factor = sensitivity_factor(r, known.first);
  problem.sentence =
      fmt::format("{}: {}: {} reads {:.5g} +- {:.2g} times the {}derivative of {}", problem.channel, known.what,
                  r.acceleration, r.gain, r.gain_std, r.order == 2 ? "second " : "", r.displacement);
  return problem;
}

SensorProblem gain(const SensorRelation& r, ScaleReference scale) {
  const bool of_displacement = scale == ScaleReference::accelerometer;
  SensorProblem problem{.kind = SensorProblemKind::gain, .value = r.gain, .std = r.gain_std, .limit = least_gain};
  problem.channel = of_displacement ? r.displacement : r.acceleration;
  problem.unit = si_units[of_displacement ? 0 : 2];
  problem.sensitivity_factor = sensitivity_factor(r, of_displacement);
  const double excess = of_displacement ? 1.0 / r.gain - 1.0 : r.gain - 1.0;
  problem.sentence = fmt::format("{} reads {:.2f} +- {:.2f} % {} than {} says", problem.channel,
                                 100.0 * std::abs(excess), 100.0 * r.gain_std, excess > 0.0 ? "more" : "less",
                                 of_displacement ? r.acceleration : r.displacement);
  return problem;
}

/// How far log(gain) of a pair compared by scale alone may be from 0. Noise in one of the two makes the ratio of their
/// rms values wrong by the correlation at most: the regressions of each on the other are its bounds.
double scale_limit(const SensorRelation& r) {
  const double by_noise = -0.5 * std::log1p(-r.residual * r.residual);
  return by_noise + significant_stds * std::hypot(r.gain_std / r.gain, r.calibration_std);
}

SensorProblem scale_problem(const SensorRelation& r) {
  SensorProblem problem{.kind = SensorProblemKind::gain,
                        .channel = r.acceleration,
                        .value = r.gain,
                        .std = r.gain_std,
                        .limit = std::expm1(scale_limit(r)),
                        .either = true,
                        .unit = si_units[static_cast<std::size_t>(r.from_order + r.order)],
                        .sensitivity_factor = sensitivity_factor(r, false)};
  problem.sentence = fmt::format("{} reads {:.4g} +- {:.1g} times the {}derivative of {}, which no two units explain",
                                 r.acceleration, r.gain, r.gain_std, r.order == 2 ? "second " : "", r.displacement);
  return problem;
}

SensorProblem lag(const SensorRelation& r) {
  const bool displacement_late = r.lag_s > 0.0;
  SensorProblem problem{.kind = SensorProblemKind::lag, .value = r.lag_s, .std = r.lag_std_s, .limit = least_lag_s};
  problem.channel = displacement_late ? r.displacement : r.acceleration;
  problem.delay_s = std::abs(r.lag_s);
  problem.sentence = fmt::format("{} comes {:.3f} +- {:.3f} ms later than {}", problem.channel, 1e3 * problem.delay_s,
                                 1e3 * r.lag_std_s, displacement_late ? r.acceleration : r.displacement);
  return problem;
}

double sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

std::string cutoffs(const std::vector<double>& hz) {
  return hz.empty() ? std::string("none") : fmt::format("{:.4f} Hz", fmt::join(hz, " Hz and "));
}

SensorProblem cutoff(const SensorRelation& r) {
  SensorProblem problem{.kind = SensorProblemKind::cutoff,
                        .channel = r.acceleration,
                        .value = sum(r.highpass_hz),
                        .std = r.highpass_sum_std_hz};
  problem.limit = std::max(least_cutoff_hz, least_cutoff_fraction * sum(r.declared_hz));
  problem.highpass_hz = r.highpass_hz;
  const bool several = r.highpass_hz.size() > 1;
  problem.sentence = fmt::format("{}: AC-coupling cut-off{} {} (+- {:.2g} Hz{}); its description says {}",
                                 r.acceleration, several ? "s" : "", cutoffs(r.highpass_hz), problem.std,
                                 several ? " on their sum" : "", cutoffs(r.declared_hz));
  return problem;
}

}  // namespace

std::string_view to_string(SensorProblemKind kind) {
  constexpr std::array<std::string_view, 5> names{"polarity", "unit", "gain", "lag", "corner"};
  return names[static_cast<std::size_t>(kind)];
}

std::vector<SensorProblem> sensor_problems(const SensorRelation& relation, ScaleReference scale) {
  std::vector<SensorProblem> problems;
  if (!relation.reason.empty()) return problems;
  const auto exceeds = [](double difference, double std, double floor) {
    return std::abs(difference) > std::max(significant_stds * std, floor);
  };
  if (relation.sign < 0.0) problems.push_back(polarity(relation));
  if (const auto known = unit_ratio(relation))
    problems.push_back(unit(relation, *known));
  else if (relation.sign_and_unit_only && std::abs(std::log(relation.gain)) > scale_limit(relation))
    problems.push_back(scale_problem(relation));
  else if (!relation.sign_and_unit_only && exceeds(relation.gain - 1.0, relation.gain_std, least_gain))
    problems.push_back(gain(relation, scale));
  if (relation.sign_and_unit_only) return problems;
  if (exceeds(relation.lag_s, relation.lag_std_s, least_lag_s)) problems.push_back(lag(relation));
  if (SensorProblem found = cutoff(relation); exceeds(found.value - sum(relation.declared_hz), found.std, found.limit))
    problems.push_back(std::move(found));
  return problems;
}

}  // namespace dsp
