#include "dsp/prepare/sensor_checks.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "dsp/io/sidecar.hpp"

namespace dsp {
namespace {

/// In the units a sensor's sheet uses.
std::string sensitivity_text(const Sensitivity& sensitivity, double factor) {
  const double value = sensitivity.value * factor;
  if (sensitivity.electrical == "V" && sensitivity.measured == "m") return fmt::format("{:.5g} mV/mm", value);
  if (sensitivity.electrical == "V" && sensitivity.measured == "m/s^2")
    return fmt::format("{:.5g} mV/g", 1e3 * find_unit("g").factor * value);
  return fmt::format("{:.5g} {}/({})", value, sensitivity.electrical, sensitivity.measured);
}

/// What the channel's numbers are to be multiplied by, as the key that does it.
std::string scale_line(const SensorProblem& problem, const ChannelSpec* channel) {
  if (channel != nullptr && channel->sensitivity)
    return fmt::format("sensitivity = \"{}\"", sensitivity_text(*channel->sensitivity, problem.sensitivity_factor));
  if (problem.kind == SensorProblemKind::unit) return fmt::format("unit = \"{}\"", problem.unit);
  const Unit unit = channel != nullptr && !channel->unit.empty() ? find_unit(channel->unit) : Unit{};
  return fmt::format("full_scale = \"{:.6g} {}\"", unit.factor / problem.sensitivity_factor,
                     unit.si.empty() ? problem.unit : unit.si);
}

Check check_of(const SensorProblem& problem, bool corrected, const ChannelSpec* channel, const std::string& sidecar) {
  Check check{.name = "sensor." + std::string(to_string(problem.kind)),
              .channel = problem.channel,
              .value = problem.value,
              .limit = problem.limit};
  check.status = corrected ? CheckStatus::note : CheckStatus::warning;
  const char* other = !problem.either ? ""
                      : problem.kind == SensorProblemKind::polarity
                          ? " or its partner, whichever is wired the wrong way round"
                          : " or its partner, whichever is calibrated wrongly";
  check.message = fmt::format("{}; {}. In {}, [[channel]] name = \"{}\"{}: {}", problem.sentence,
                              corrected ? "corrected here" : "not corrected", sidecar, problem.channel, other,
                              remedy(problem, channel));
  return check;
}

Check relation_check(const SensorRelation& relation, std::string found, CheckStatus without) {
  const bool known = relation.reason.empty();
  return {.name = "sensor.relation",
          .channel = relation.name,
          .status = known ? CheckStatus::ok : without,
          .value = relation.gain,
          .limit = largest_gain_error,
          .message = known ? std::move(found) : "not compared: " + relation.reason};
}

}  // namespace

std::string remedy(const SensorProblem& problem, const ChannelSpec* channel) {
  switch (problem.kind) {
    case SensorProblemKind::polarity:
      return fmt::format("sign = {}", channel != nullptr && channel->sign < 0.0 ? 1 : -1);
    case SensorProblemKind::unit:
    case SensorProblemKind::gain:
      return scale_line(problem, channel);
    case SensorProblemKind::lag:
      return fmt::format("delay = \"{:.4g} ms\"",
                         1e3 * (problem.delay_s + (channel != nullptr ? channel->delay_s : 0.0)));
    case SensorProblemKind::cutoff:
      return fmt::format("highpass = [{:.4g}]", fmt::join(problem.highpass_hz, ", "));
  }
  return {};
}

bool is_corrected(const Prepared& prepared, const SensorRelation& relation, const SensorProblem& problem) {
  const bool pair = std::any_of(prepared.relations.begin(), prepared.relations.end(),
                                [&](const SensorRelation& one) { return one.name == relation.name; });
  const bool of_scale = problem.kind == SensorProblemKind::unit || problem.kind == SensorProblemKind::gain;
  return pair && prepared.equalised() && can_be_corrected(relation) && problem.kind != SensorProblemKind::polarity &&
         (!of_scale || gain_is_plausible(relation));
}

std::vector<Check> sensor_checks(const Prepared& prepared, const std::vector<ChannelSpec>& channels,
                                 const std::string& sidecar) {
  std::vector<Check> checks;
  const auto add = [&](Check pair, const SensorRelation& relation) {
    checks.push_back(std::move(pair));
    for (const SensorProblem& problem : sensor_problems(relation, prepared.options.scale)) {
      const auto spec = std::find_if(channels.begin(), channels.end(),
                                     [&](const ChannelSpec& channel) { return channel.name == problem.channel; });
      checks.push_back(check_of(problem, is_corrected(prepared, relation, problem),
                                spec == channels.end() ? nullptr : &*spec, sidecar));
    }
  };
  for (const SensorRelation& relation : prepared.relations)
    add(relation_check(
            relation,
            fmt::format("accelerometer to displacement: gain {:.5f}, displacement {:.3f} ms late, "
                        "AC-coupling cut-offs [{:.4f}] Hz",
                        relation.sign * relation.gain, 1e3 * relation.lag_s, fmt::join(relation.highpass_hz, ", ")),
            CheckStatus::warning),
        relation);
  for (const SensorRelation& relation : prepared.derivatives)
    add(relation_check(
            relation,
            fmt::format("{} is {:.5f} times the {}derivative of {}", relation.acceleration,
                        relation.sign * relation.gain, relation.order == 2 ? "second " : "", relation.displacement),
            CheckStatus::note),
        relation);
  return checks;
}

}  // namespace dsp
