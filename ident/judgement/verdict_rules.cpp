#include "ident/judgement/verdict_rules.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "ident/validate/energy_terms.hpp"

namespace ident {
namespace {

constexpr double in_step = 0.02;

bool has_left_over(const Evidence& of) {
  return of.found.unexplained > matters_to_power;
}

bool is_out_of_step(const Evidence& of) {
  return std::abs(of.range.power_balance) > in_step;
}

bool has_converged(const Evidence& of) {
  return of.fit.fit.status == FitStatus::converged;
}

std::string power_clause(const Evidence& of) {
  const double balance = std::abs(of.range.power_balance);
  if (!std::isfinite(balance)) return {};
  return is_out_of_step(of)
             ? fmt::format("velocity and acceleration are out of step (power balance {:.2g}), which reads as damping",
                           balance)
             : fmt::format("the sensors are in step (power balance {:.1g})", balance);
}

std::string carry_over_clause(const Evidence& of) {
  if (!of.found.fitted_to_its_rows) return {};
  return fmt::format("it does not carry over: NMSE {:.2g} on the test rows, {:.2g} on the training rows",
                     of.fit.test.value, of.fit.train.value);
}

std::string doubt_clause(const Evidence& of) {
  const std::vector<std::string>& terms = of.found.doubtful;
  return fmt::format("{} may not belong in the equation: by noise alone the 95 % interval of {} includes zero",
                     fmt::join(terms, " and "), terms.size() == 1 ? "its coefficient" : "each of their coefficients");
}

std::size_t num_rows(const RangeResult& range) {
  return range.rows.train.size() + range.rows.test.size();
}

std::string larger_clause(const Evidence& of) {
  return fmt::format("range {}, with {:.2g} times as many rows, is not described by its equation", of.larger->spec.name,
                     static_cast<double>(num_rows(*of.larger)) / static_cast<double>(num_rows(of.range)));
}

bool is_orbit(const Evidence& of) {
  return of.range.orbit.has_value();
}

bool is_along_motion(const Evidence& of) {
  return of.found.is_conservative && of.range.along_motion > mostly_along_motion;
}

std::string orbit_clause(const Evidence& of) {
  const ClosedOrbit& orbit = *of.range.orbit;
  return fmt::format(
      "the record is one closed orbit at {:.4g} Hz: its {} spectral line{} above noise make{} {} "
      "independent equations for {} candidates, and other equations fit them as well",
      orbit.hz, orbit.num_lines, orbit.num_lines == 1 ? "" : "s", orbit.num_lines == 1 ? "s" : "",
      orbit.num_equations(), orbit.num_candidates);
}

/// How far a sensor is off, in standard deviations of what was known of it beforehand.
double deviations(const SensorEstimate& sensor) {
  return sensor.prior_std > 0.0 ? std::abs(sensor.mean) / sensor.prior_std : 0.0;
}

/// Null: none has parameters.
const SensorEstimate* farthest_sensor(const JudgedFit& fit) {
  const auto found = std::max_element(fit.sensors.begin(), fit.sensors.end(), [](const auto& one, const auto& other) {
    return deviations(one) < deviations(other);
  });
  return found == fit.sensors.end() ? nullptr : &*found;
}

bool has_far_sensor(const Evidence& of) {
  const SensorEstimate* sensor = farthest_sensor(of.fit);
  return sensor != nullptr && deviations(*sensor) > far_off;
}

std::string sensor_clause(const Evidence& of) {
  const SensorEstimate& sensor = *farthest_sensor(of.fit);
  return fmt::format("the fit has the {} {:.2g}{} off, {:.2g} standard deviations of what is known of it", sensor.name,
                     sensor.mean, sensor.unit == "1" ? "" : " " + sensor.unit, deviations(sensor));
}

std::optional<LossPerCycle> loss_of(const Evidence& of) {
  constexpr double noises = 8.0;  // a crest above them is of the motion
  return loss_per_cycle(of.range.crests, noises * of.fit.noise.x_std);
}

bool falls(const Evidence& of) {
  const auto loss = loss_of(of);
  return of.fit.free_run.alone && loss && loss->falls();
}

/// Crests of some stretch fall to half. What excites itself falls to its limit cycle only, and few begin so far above.
bool halves(const Crests& crests) {
  return std::any_of(crests.begin(), crests.end(), [](const std::vector<double>& stretch) {
    return !stretch.empty() && stretch.back() < 0.5 * stretch.front();
  });
}

/// Where the equation explains every sample and another term takes what one feeds, it excites itself.
bool is_fed(const Evidence& of) {
  const EnergyTerms energy = energy_terms(of.fit.model);
  const bool excites_itself = of.fit.by_likelihood && !of.range.likelihood.has_unexplained() && !energy.take.empty();
  return energy.friction_feeds ||
         (!energy.feed.empty() && !excites_itself && (!of.fit.free_run.alone || halves(of.range.crests)));
}

std::string fed_clause(const Evidence& of) {
  const EnergyTerms energy = energy_terms(of.fit.model);
  return fmt::format(
      "{} feed{} energy to the motion{}", fmt::join(energy.feed, " and "), energy.feed.size() == 1 ? "s" : "",
      energy.take.empty()
          ? ""
          : fmt::format(", and {} take{} it", fmt::join(energy.take, " and "), energy.take.size() == 1 ? "s" : ""));
}

/// Every term of x and v alone, none of which takes energy.
bool falls_undamped(const Evidence& of) {
  const auto& terms = of.fit.model.terms;
  return falls(of) && energy_terms(of.fit.model).take.empty() &&
         std::all_of(terms.begin(), terms.end(), [](const ModelTerm& term) {
           const Expression expression(term.name);
           const auto& signals = expression.signals();
           return std::all_of(signals.begin(), signals.end(), [](const std::string& one) {
             return one == "x" || one == "v" || one == "y" || one == "dy";
           });
         });
}

std::string falls_clause(const Evidence& of) {
  const LossPerCycle loss = *loss_of(of);
  return fmt::format("the amplitude falls by {:.3g} +- {:.1g} % a cycle, and no term of the equation takes energy",
                     100.0 * loss.mean, 100.0 * loss.std);
}

std::string apart_clause(const Evidence& of) {
  std::vector<std::string> terms;
  for (const OwnCoefficients& one : apart_by_recording(of.range, of.fit.model)) {
    const auto [least, greatest] = one.extremes();
    terms.push_back(fmt::format("{} is {} in {} and {} in {}", one.name, number(least->mean), least->recording_name,
                                number(greatest->mean), greatest->recording_name));
  }
  return fmt::format("the recordings have one equation only with other coefficients: {}", fmt::join(terms, "; "));
}

constexpr std::array rules{
    VerdictRule{.name = "one_closed_orbit",
                .at_most = Verdict::undecided,
                .condition = "The record is one closed orbit (a steady sine, a limit cycle) with fewer independent "
                             "equations than candidates: two for each spectral line of the target above noise",
                .reason = "a periodic motion has nothing between its lines, and of a sine x'' = -(2 pi f)^2 x holds "
                          "whatever the machine is",
                .remedy = "One closed orbit does not distinguish these candidates: record a sweep, a decay, or several "
                          "amplitudes and frequencies beside it.",
                .is_cause = true,
                .holds = is_orbit,
                .clause = orbit_clause},
    VerdictRule{
        .name = "force_along_motion",
        .at_most = Verdict::undecided,
        .condition = "Nothing in the equation drives the motion or damps it, and x and v explain more than half "
                     "of the recorded force, which is not in it",
        .reason = "where motion and force share one frequency f, x'' = -(2 pi f)^2 x holds whatever the machine "
                  "is; a force that drives a resonance from outside is not along x and v",
        .holds = is_along_motion},
    VerdictRule{
        .name = "larger_range",

        .at_most = Verdict::in_part,
        .condition = "A range with more rows has an equation that does not describe it",
        .reason = "of several ranges the one that flatters says little of the record",
        .remedy = "What differs in the larger range is not in the equation: look at its residual in report.html.",
        .is_cause = true,
        .holds = [](const Evidence& of) { return of.larger != nullptr; },
        .clause = larger_clause},
    VerdictRule{.name = "sensor_far_off",
                .at_most = Verdict::in_part,
                .condition = "The fit has a sensor's gain, zero, drift or lag more than four standard deviations off "
                             "what is known of it beforehand",
                .reason = "a normal variate is so far off once in 16,000; a missing term shows as such an error",
                .remedy = "Check that sensor and state what is known of it in its [[channel]] "
                          "(sensitivity_uncertainty, range, drift, delay); if it is right, a term is missing.",
                .is_cause = true,
                .holds = has_far_sensor,
                .clause = sensor_clause},
    VerdictRule{.name = "feeds_energy",
                .at_most = Verdict::in_part,
                .condition = "Dry friction feeds energy to the motion, or any damping does in a motion that is driven "
                             "or falls to half, by more than its 95 % interval; but where another term takes it and "
                             "the likelihood of the recorded samples finds nothing unexplained",
                .reason = "what is passive takes energy; only self-excited motion is fed by its damping",
                .remedy = "Friction and damping of opposite signs imitate another law of the speed: add candidates "
                          "such as abs(v)*v to [library] terms, or leave the doubtful ones out.",
                .is_cause = true,
                .holds = is_fed,
                .clause = fed_clause},
    VerdictRule{.name = "falls_undamped",
                .at_most = Verdict::in_part,
                .condition = "The amplitude of a free motion falls, by more than three standard deviations of its loss "
                             "per cycle, and no kept term takes energy",
                .reason = "chance makes crests fall so once in 700 records",
                .remedy = "Damping was lost under noise: record longer or with less noise, or with a lower cutoff_hz; "
                          "v, abs(v)*v and sgn(v) are to be among the candidates.",
                .is_cause = true,
                .holds = falls_undamped,
                .clause = falls_clause},
    VerdictRule{.name = "differs_by_recording",
                .at_most = Verdict::in_part,
                .condition = "A coefficient that matters, dry friction aside, differs by more than 10 % between "
                             "recordings of one equation",
                .reason = "one machine has one stiffness; friction changes from day to day",
                .remedy =
                    "State what differs between the recordings (a mass, a sensor, its zero) in their sidecars, or "
                    "fit them apart.",
                .is_cause = true,
                .holds = [](const Evidence& of) { return !apart_by_recording(of.range, of.fit.model).empty(); },
                .clause = apart_clause},
    VerdictRule{.name = "recorded_left_out",
                .at_most = Verdict::does_not,
                .condition =
                    "Something recorded that is not in the equation explains more than 10 % of what is left over, "
                    "and more than noise is left over",
                .reason = "a smaller part of it does not matter to the motion",
                .holds = [](const Evidence& of) { return leaves_out_recorded(of.fit, of.found); }},
    VerdictRule{.name = "biased",
                .at_most = Verdict::does_not,
                .condition = "Noise of the recorded channels biases a coefficient by more than two standard deviations "
                             "and 2 %",
                .reason = "its 95 % interval then misses",
                .holds = [](const Evidence& of) { return !of.found.biased.empty(); }},
    VerdictRule{.name = "imitates",
                .at_most = Verdict::does_not,
                .condition = "With a usual form that was no candidate in place of kept terms the equation is better, "
                             "and x is not followed with next to nothing left over",
                .reason = "odds of 150 or more for the form, by the score that selects terms",
                .holds =
                    [](const Evidence& of) {
                      const bool follows = of.found.by_run == Verdict::describes && of.found.residual_negligible;
                      return imitates(of.fit) && !follows;
                    }},
    VerdictRule{.name = "lacks_form",
                .at_most = Verdict::does_not,
                .condition = "A usual form that was no candidate explains more than half of what is left over beside "
                             "noise, and more than 10 % of all of it",
                .reason = "the record itself shows the missing term",
                .holds = [](const Evidence& of) { return lacks_form(of.fit, of.found); }},
    VerdictRule{
        .name = "misses_beyond_noise",
        .at_most = Verdict::does_not,
        .condition = "More than noise is left over, and x is followed roughly only",
        .reason = "where noise is no excuse for it, an error of more than 10 % of its rms is the equation's",
        .holds = [](const Evidence& of) { return of.found.above_noise && of.found.by_run == Verdict::in_part; }},
    VerdictRule{.name = "nothing_to_run",
                .at_most = Verdict::does_not,
                .condition = "No free run decides, and more than 10 % of the target's power is left over",
                .reason = "a smaller part does not matter to the motion",
                .holds = [](const Evidence& of) { return of.found.by_run == Verdict::undecided && has_left_over(of); }},
    VerdictRule{.name = "above_noise",
                .at_most = Verdict::in_part,
                .condition =
                    "More than twice the noise of the recorded channels is left over, or the likelihood of the "
                    "recorded samples finds something unexplained with odds of 20,000",
                .reason = "half of it is something else then",
                .holds = [](const Evidence& of) { return of.found.above_noise; }},
    VerdictRule{.name = "misses_motion",
                .at_most = Verdict::in_part,
                .condition =
                    "More than twice that noise is left over at the frequencies at which the target is more than "
                    "noise",
                .reason = "noise of a displacement, derived twice, lies above them and hides what is missing there",
                .holds = [](const Evidence& of) { return of.found.misses_motion; }},
    VerdictRule{.name = "shows_at_motion",
                .at_most = Verdict::in_part,
                .condition = "At those frequencies a term shows that is not in the equation",
                .reason = "noise shows as much of any of those tried in one record of 1000",
                .holds = [](const Evidence& of) { return of.found.may_lack_at_motion && of.found.shows_at_motion; }},
    VerdictRule{.name = "may_lack",
                .at_most = Verdict::in_part,
                .condition = "At those frequencies a term may be missing",
                .reason = "noise shows as much of that term in one record of 100",
                .remedy = "Whether a term is missing: a longer record, or one with less noise, would tell.",
                .holds = [](const Evidence& of) { return of.found.only_doubt_is_missing_term(); }},
    VerdictRule{.name = "carries_over",
                .at_most = Verdict::in_part,
                .condition = "Ten times the power is left over on test rows that is on training rows",
                .reason = "the equation is fitted to its rows",
                .holds = [](const Evidence& of) { return of.found.fitted_to_its_rows; },
                .clause = carry_over_clause},
    VerdictRule{.name = "keeps_energy",
                .at_most = Verdict::in_part,
                .condition = "Nothing in the equation drives the motion or damps it",
                .reason = "every steady motion of its period is its solution",
                .holds = [](const Evidence& of) { return of.found.is_conservative; },
                .clause = [](const Evidence& of) -> std::string {
                  return of.found.is_conservative
                             ? "nothing in it drives the motion or damps it, and what does is not known"
                             : "";
                }},
    VerdictRule{.name = "out_of_step",
                .at_most = Verdict::in_part,
                .condition = "Velocity and acceleration have a power balance beyond 0.02",
                .reason = "one degree between them, which reads as 1 % of damping ratio",
                .holds = is_out_of_step,
                .clause = power_clause},
    VerdictRule{.name = "another_range",
                .at_most = Verdict::in_part,
                .condition = "Another range has another equation: terms of 5 % of the target or more are in one only "
                             "or differ by more than 10 %",
                .reason = "one machine has one equation",
                .holds = [](const Evidence& of) { return of.others.other; },
                .clause = [](const Evidence& of) { return of.others.clause; }},
    VerdictRule{.name = "not_converged",
                .at_most = Verdict::in_part,
                .condition = "The fit did not converge",
                .reason = "what it would have ended with is not known",
                .holds = [](const Evidence& of) { return !has_converged(of); },
                .clause = [](const Evidence& of) -> std::string {
                  return has_converged(of) ? "" : fmt::format("the fit ended as {}", to_string(of.fit.fit.status));
                }},
    VerdictRule{.name = "left_over",
                .at_most = Verdict::in_part,
                .condition = "More than 10 % of the target's power is left over one step ahead, noise aside",
                .reason = "a smaller part does not matter to the motion",
                .holds = has_left_over},
    VerdictRule{.name = "lacks_better",
                .at_most = Verdict::in_part,
                .condition = "With a usual form that was no candidate beside kept terms, or in place of them, the "
                             "equation is better",
                .reason = "odds of 150 or more for the form, by the score that selects terms",
                .holds = [](const Evidence& of) { return better_term_exists(of.fit, of.found); }},
    VerdictRule{.name = "doubtful",
                .at_most = Verdict::in_part,
                .condition = "By noise alone the 95 % interval of a coefficient includes zero, by the widest interval "
                             "that a method with the same terms has",
                .reason = "on one curve of the state several terms that only together do something are kept so",
                .remedy = "Whether that term belongs in the equation: a record with other amplitudes, a longer one, or "
                          "one with less noise, would tell.",
                .is_cause = true,
                .only_alone = true,
                .holds = [](const Evidence& of) { return !of.found.doubtful.empty(); },
                .clause = doubt_clause}};

}  // namespace

std::span<const VerdictRule> verdict_rules() {
  return rules;
}

int preference(Verdict verdict) {
  switch (verdict) {
    case Verdict::describes:
      return 3;
    case Verdict::in_part:
      return 2;
    case Verdict::undecided:
      return 1;
    case Verdict::does_not:
      break;
  }
  return 0;
}

}  // namespace ident
