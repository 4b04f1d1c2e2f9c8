#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "apps/paper/section5_comparison.hpp"

namespace apps {
namespace {

constexpr const char* fast = "fast_rvm";

std::string pair_of(const FoundErrors& errors) {
  return fmt::format("{:.2g}/{:.2g}", errors.train, errors.test);
}

// Where the error goes when one thing after the other is put right.
std::string error_steps(const Section5Replication& replication, const Section5Case& definition) {
  std::vector<std::string> parts;
  for (const Section5Way& way : section5_ways())
    parts.push_back(fmt::format("{} {} ({})", way.name,
                                pair_of(Section5View(replication, definition, way, paper_candidates).errors(fast)),
                                pair_of(Section5View(replication, definition, way, all_candidates).errors(fast))));
  return fmt::format(
      "NMSE train/test step by step, with all candidates in brackets: {}. What is left on T1 and not on T0 is physics "
      "outside the candidates: friction that depends on speed, place and time, and where sensors stay as they are the "
      "mount resonance.",
      fmt::join(parts, "; "));
}

// An NMSE is an error over the motion's size, and that falls along the branches.
std::string residual_sizes(const Section5Replication& replication, const Section5Case& definition) {
  const Section5View ours(replication, definition, section5_ways().front(), paper_candidates);
  const FoundErrors errors = ours.errors(fast);
  const double train = ours.target_rms(true), test = ours.target_rms(false);
  return fmt::format(
      "T1 paper's residual is {:.2g} m/s^2 rms on the training rows and {:.2g} on the test rows, of targets of {:.2g} "
      "and {:.2g}.",
      std::sqrt(errors.train) * train, std::sqrt(errors.test) * test, train, test);
}

std::string phase(const Section5Replication& replication, const Section5Case& definition) {
  for (const Section5Sensors& sensors : replication.sensors) {
    if (sensors.way->twin != "T1") continue;
    const dsp::Regime regime = definition.regime == "high" ? dsp::Regime::high : dsp::Regime::low;
    const dsp::RegimePower power = balance_in(sensors.power, regime);
    std::vector<std::string> relations;
    for (const dsp::SensorRelation& relation : sensors.relations)
      relations.push_back(fmt::format("{}: gain {:.4f}, laser {:.2f} ms late, cut-offs {:.3f} Hz", relation.name,
                                      relation.gain, 1e3 * relation.lag_s, fmt::join(relation.highpass_hz, " and ")));
    return fmt::format(
        "Velocity and acceleration as measured are correlated by {:.2g} in the {} regime of T1, {:.2g} after the "
        "sensors were corrected; in steady motion they are not at all. The AC coupling of the accelerometers turns "
        "their "
        "phase ({}), and a regression books that as damping.",
        power.raw, to_string(regime), power.corrected, fmt::join(relations, "; "));
  }
  return {};
}

std::string damping(const Section5Replication& replication, const Section5Case& definition) {
  std::vector<std::string> parts;
  for (const Section5Way& way : section5_ways()) {
    const double ratio = Section5View(replication, definition, way, paper_candidates).damping_over_supply(fast);
    if (std::isfinite(ratio)) parts.push_back(fmt::format("{} {:.2g}", way.name, ratio));
  }
  return fmt::format(
      "In steady motion at the largest amplitude the damping of the printed equation takes {:.2g} times the most that "
      "its base term can give, where more than 1 cannot be; ours: {}. A phase error of the sensors does that, by sign "
      "and by size.",
      printed_damping_over_supply(definition.table), fmt::join(parts, ", "));
}

std::string printed_stds(const Section5Replication& replication, const Section5Case& definition) {
  const CovRatio ratio = printed_cov_ratio(definition.table);
  const Section5View ours(replication, definition, section5_ways().front(), paper_candidates);
  const FoundErrors errors = ours.errors(fast);
  return fmt::format(
      "The printed CoVs of F-RVM are those of S-RVM times {:.3g} on every term (to {:.1f} %), with the same means: the "
      "noise's standard deviation is left out, {:.3g} m/s^2. With the printed training NMSE that makes a target of "
      "{:.2g} m/s^2 "
      "rms (T1: {:.2g}, noise {:.2g}); divided by its maximum none could exceed 0.71, a sine's. So the targets of "
      "Tables "
      "10-12 are in m/s^2.",
      ratio.mean, 100.0 * ratio.spread, 1.0 / ratio.mean, ratio.target_rms, ours.target_rms(true), errors.noise_std);
}

std::string friction(const Section5Replication& replication, const Section5Case& definition) {
  std::vector<std::string> parts;
  for (const Section5Way& way : section5_ways()) {
    const FoundTerm sgn = Section5View(replication, definition, way, all_candidates).term(fast, "sgn(v)");
    parts.push_back(sgn.kept > 0 ? fmt::format("{} {:.3g} m/s^2 (t = {:.0f})", way.name, sgn.mean, sgn.t)
                                 : fmt::format("{} not kept", way.name));
  }
  return fmt::format(
      "sgn(v) is not among the candidates that give the printed equation; offered, it is kept: {}. T0's is -0.08, T1's "
      "kinetic level -0.065. That friction vanishes at high amplitude does not follow from leaving it out.",
      fmt::join(parts, ", "));
}

std::string cubic_exercise(const Section5Replication& replication, const Section5Case& definition) {
  const Section5Way& way = section5_ways().front();
  const Section5View paper(replication, definition, way, paper_candidates),
      all(replication, definition, way, all_candidates);
  return fmt::format(
      "With cubic terms offered as well the paper reports close to 0.05 on the test rows, twice its linear error. T1 "
      "by "
      "the paper's recipe: {:.3g} beside {:.3g}; kept are {}.",
      all.errors(fast).test, paper.errors(fast).test, fmt::join(all.kept(fast), ", "));
}

std::string offsets(const Section5Replication& replication, const Section5Case& definition) {
  const FoundTerm one =
      Section5View(replication, definition, section5_ways().front(), paper_candidates).term(fast, "1");
  if (one.kept == 0) return {};
  return fmt::format(
      "A constant is kept at {:.2g} m/s^2, which no printed equation has: it is the accelerometers' zero (-0.035 here, "
      "high-passed away once the sensors agree).",
      one.mean);
}

}  // namespace

std::vector<std::string> section5_reasons(const Section5Replication& replication, const Section5Case& definition) {
  std::vector<std::string> reasons{error_steps(replication, definition), residual_sizes(replication, definition),
                                   phase(replication, definition), damping(replication, definition),
                                   printed_stds(replication, definition)};
  const bool offered = std::find(definition.terms.begin(), definition.terms.end(), "sgn(v)") != definition.terms.end();
  reasons.push_back(offered ? cubic_exercise(replication, definition) : friction(replication, definition));
  reasons.push_back(offsets(replication, definition));
  std::erase(reasons, std::string());
  return reasons;
}

}  // namespace apps
