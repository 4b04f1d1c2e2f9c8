#include "dsp/sensors/sensor_faults.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

namespace dsp {
namespace {

constexpr double deviations = 4.0;
constexpr double least_gain = 3e-3, least_lag_s = 50e-6, least_corner_hz = 0.02, least_corner_share = 0.05;
constexpr double calibration_std = 0.01;  // of a sensor's gain, where nothing better is known
constexpr double gravity = 9.80665;

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

SensorFault polarity(const SensorRelation& r) {
  SensorFault fault{.kind = SensorFaultKind::polarity, .channel = r.acceleration, .value = -1.0, .either = true};
  fault.sentence = fmt::format("{} and {} have opposite signs", r.displacement, r.acceleration);
  return fault;
}

SensorFault unit(const SensorRelation& r, const UnitRatio& known) {
  SensorFault fault{.kind = SensorFaultKind::unit, .value = r.gain, .std = r.gain_std, .limit = known.ratio};
  fault.channel = known.first ? r.displacement : r.acceleration;
  fault.unit = known.unit;
  fault.sensitivity_factor = sensitivity_factor(r, known.first);
  fault.sentence =
      fmt::format("{}: {}: {} reads {:.5g} +- {:.2g} times the {}derivative of {}", fault.channel, known.what,
                  r.acceleration, r.gain, r.gain_std, r.order == 2 ? "second " : "", r.displacement);
  return fault;
}

SensorFault gain(const SensorRelation& r, ScaleReference scale) {
  const bool of_displacement = scale == ScaleReference::accelerometer;
  SensorFault fault{.kind = SensorFaultKind::gain, .value = r.gain, .std = r.gain_std, .limit = least_gain};
  fault.channel = of_displacement ? r.displacement : r.acceleration;
  fault.unit = si_units[of_displacement ? 0 : 2];
  fault.sensitivity_factor = sensitivity_factor(r, of_displacement);
  const double excess = of_displacement ? 1.0 / r.gain - 1.0 : r.gain - 1.0;
  fault.sentence = fmt::format("{} reads {:.2f} +- {:.2f} % {} than {} says", fault.channel, 100.0 * std::abs(excess),
                               100.0 * r.gain_std, excess > 0.0 ? "more" : "less",
                               of_displacement ? r.acceleration : r.displacement);
  return fault;
}

/// How far log(gain) of a pair compared by scale alone may be from 0. Noise in one of the two makes the ratio of their
/// rms values wrong by the correlation at most: the regressions of each on the other are its bounds.
double scale_limit(const SensorRelation& r) {
  const double by_noise = -0.5 * std::log1p(-r.residual * r.residual);
  return by_noise + deviations * std::hypot(r.gain_std / r.gain, std::numbers::sqrt2 * calibration_std);
}

SensorFault scale_fault(const SensorRelation& r) {
  SensorFault fault{.kind = SensorFaultKind::gain,
                    .channel = r.acceleration,
                    .value = r.gain,
                    .std = r.gain_std,
                    .limit = std::expm1(scale_limit(r)),
                    .either = true,
                    .unit = si_units[static_cast<std::size_t>(r.from_order + r.order)],
                    .sensitivity_factor = sensitivity_factor(r, false)};
  fault.sentence = fmt::format("{} reads {:.4g} +- {:.1g} times the {}derivative of {}, which no two units explain",
                               r.acceleration, r.gain, r.gain_std, r.order == 2 ? "second " : "", r.displacement);
  return fault;
}

SensorFault lag(const SensorRelation& r) {
  const bool displacement_late = r.lag_s > 0.0;
  SensorFault fault{.kind = SensorFaultKind::lag, .value = r.lag_s, .std = r.lag_std_s, .limit = least_lag_s};
  fault.channel = displacement_late ? r.displacement : r.acceleration;
  fault.delay_s = std::abs(r.lag_s);
  fault.sentence = fmt::format("{} comes {:.3f} +- {:.3f} ms later than {}", fault.channel, 1e3 * fault.delay_s,
                               1e3 * r.lag_std_s, displacement_late ? r.acceleration : r.displacement);
  return fault;
}

double sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

std::string corners(const std::vector<double>& hz) {
  return hz.empty() ? std::string("none") : fmt::format("{:.4f} Hz", fmt::join(hz, " Hz and "));
}

SensorFault corner(const SensorRelation& r) {
  SensorFault fault{.kind = SensorFaultKind::corner,
                    .channel = r.acceleration,
                    .value = sum(r.highpass_hz),
                    .std = r.highpass_sum_std_hz};
  fault.limit = std::max(least_corner_hz, least_corner_share * sum(r.declared_hz));
  fault.highpass_hz = r.highpass_hz;
  const bool several = r.highpass_hz.size() > 1;
  fault.sentence = fmt::format("{}: coupling corner{} {} (+- {:.2g} Hz{}); its description says {}", r.acceleration,
                               several ? "s" : "", corners(r.highpass_hz), fault.std, several ? " on their sum" : "",
                               corners(r.declared_hz));
  return fault;
}

}  // namespace

std::string_view to_string(SensorFaultKind kind) {
  constexpr std::array<std::string_view, 5> names{"polarity", "unit", "gain", "lag", "corner"};
  return names[static_cast<std::size_t>(kind)];
}

std::vector<SensorFault> sensor_faults(const SensorRelation& relation, ScaleReference scale) {
  std::vector<SensorFault> faults;
  if (!relation.reason.empty()) return faults;
  const auto exceeds = [](double difference, double std, double floor) {
    return std::abs(difference) > std::max(deviations * std, floor);
  };
  if (relation.sign < 0.0) faults.push_back(polarity(relation));
  if (const auto known = unit_ratio(relation))
    faults.push_back(unit(relation, *known));
  else if (relation.sign_and_unit_only && std::abs(std::log(relation.gain)) > scale_limit(relation))
    faults.push_back(scale_fault(relation));
  else if (!relation.sign_and_unit_only && exceeds(relation.gain - 1.0, relation.gain_std, least_gain))
    faults.push_back(gain(relation, scale));
  if (relation.sign_and_unit_only) return faults;
  if (exceeds(relation.lag_s, relation.lag_std_s, least_lag_s)) faults.push_back(lag(relation));
  if (SensorFault found = corner(relation); exceeds(found.value - sum(relation.declared_hz), found.std, found.limit))
    faults.push_back(std::move(found));
  return faults;
}

}  // namespace dsp
