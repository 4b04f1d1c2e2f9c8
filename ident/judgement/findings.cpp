#include "ident/judgement/findings.hpp"

#include <algorithm>
#include <cmath>

#include "dsp/values/constants.hpp"
#include "ident/equation/interval_95.hpp"

namespace ident {
namespace {

using dsp::nan;
// Where the noise of the channels makes less than this fraction of the residual, twice as much is something else.
constexpr double mostly_noise = 0.5;
constexpr double hardly_any = 0.1;  // of the residual's power: too little to be a cause
// A residual of which this fraction comes back with the state is a function of it where the noise, which may be the
// rest, is not known.
constexpr double of_the_state = 0.75;
// Below this fraction of the target's power, structure in the residual spoils the error bars but not the equation.
constexpr double negligible = 1e-3;
constexpr double most_of_it = 0.5;     // of what is left over
constexpr double carries_over = 10.0;  // residual power on test rows / on training rows: fitted to its rows only
constexpr double bias_in_stds = 2.0, bias_of_mean = 0.02;  // by noise of regressors: beyond both the interval misses

double mean_square(const Eigen::Ref<const Eigen::VectorXd>& values) {
  return values.size() > 0 ? values.squaredNorm() / static_cast<double>(values.size()) : nan;
}

double variance(const Eigen::Ref<const Eigen::VectorXd>& values) {
  return values.size() > 0 ? mean_square((values.array() - values.mean()).matrix()) : nan;
}

std::string biased_term(const JudgedFit& fit) {
  for (std::size_t i = 0; i < fit.model.terms.size() && fit.noise.bias.size() > 0; ++i) {
    const ModelTerm& term = fit.model.terms[i];
    const double bias = std::abs(fit.noise.bias(static_cast<Eigen::Index>(i)));
    if (bias > bias_in_stds * term.std && bias > bias_of_mean * std::abs(term.mean)) return term.name;
  }
  return {};
}

/// Mean square of what noise makes of the error of x in a free run: that of x itself and, from the measured state at
/// its start, that of x and of v. That of v dies away in a driven run and counts no more there than that of x.
double noise_of_run(const RegressorNoise& noise, bool alone) {
  const double x = noise.x_std * noise.x_std, v = noise.v_as_x_std * noise.v_as_x_std;
  return 2.0 * x + (alone ? std::max(x, v) : x);
}

Verdict by_power(double left_over) {
  if (!std::isfinite(left_over)) return Verdict::undecided;
  return left_over <= follows           ? Verdict::describes
         : left_over <= follows_in_part ? Verdict::in_part
                                        : Verdict::does_not;
}

/// Nothing drives the equation and nothing in it takes energy: no term goes with a speed, or with an inner state.
bool has_no_damping(const JudgedFit& fit) {
  return fit.free_run.alone && std::all_of(fit.model.terms.begin(), fit.model.terms.end(), [](const ModelTerm& term) {
           const Expression expression(term.name);
           const auto& signals = expression.signals();
           return std::all_of(signals.begin(), signals.end(), [](const auto& one) { return one == "x" || one == "y"; });
         });
}

/// However little of what is left over it explains: an equation that fails has nothing better to show for it.
bool was_no_candidate(const JudgedFit& fit) {
  return fit.explanations.recorded && !fit.explanations.recorded->candidate;
}

bool same_terms(const Model& a, const Model& b) {
  return std::equal(a.terms.begin(), a.terms.end(), b.terms.begin(), b.terms.end(),
                    [](const ModelTerm& one, const ModelTerm& other) {
                      return one.name == other.name && one.recording == other.recording;
                    });
}

/// As Findings::doubtful. A method without an evidence counts every row: the widest interval decides that a fit of the
/// same terms has. A constant is a zero of a sensor.
std::vector<std::string> doubtful_terms(const RangeResult& range, const JudgedFit& fit) {
  const std::vector<ModelTerm>& terms = fit.model.terms;
  const auto is_doubtful = [&](std::size_t i) {
    return std::any_of(range.fits.begin(), range.fits.end(), [&](const JudgedFit& like) {
      return like.by_likelihood == fit.by_likelihood && same_terms(like.model, fit.model) &&
             interval_95 * like.model.terms[i].std_noise > std::abs(terms[i].mean);
    });
  };
  std::vector<std::string> names;
  for (const ModelTerm& term : terms) {
    bool all = term.name != "1" && std::find(names.begin(), names.end(), term.name) == names.end();
    for (std::size_t i = 0; i < terms.size() && all; ++i) all = terms[i].name != term.name || is_doubtful(i);
    if (all) names.push_back(term.name);
  }
  return names;
}

/// Lost amplitude comes back, more than once, though nothing measured drives the equation.
bool is_driven(const RangeResult& range, const JudgedFit& fit) {
  if (!fit.model.terms.empty() && !fit.free_run.alone) return false;
  constexpr double once = 1.0;
  constexpr double noises = 8.0;  // among hundreds of crests the extremes lie six standard deviations apart
  constexpr double quarter = 0.25, half = 0.5;  // of the largest: less is a passing transient; half where the noise of
                                                // x is not known
  const double x_std = fit.noise.x_std;
  double renewed = 0.0;
  for (const std::vector<double>& crests : range.crests) {
    if (crests.empty()) continue;
    const double largest = *std::max_element(crests.begin(), crests.end());
    renewed += renewed_amplitude(crests, std::max((x_std > 0.0 ? quarter : half) * largest, noises * x_std));
  }
  return renewed > once;
}

/// Of the residual's power, what is neither noise nor comes back with the state, at least or at most; NaN: not known.
/// Of whitened rows another fraction comes back than of the residual as it is.
struct Remainder {
  double least = nan, most = nan;
};
Remainder beside_noise_and_state(const JudgedFit& fit, const Findings& found) {
  const EffectiveSize& size = fit.size;
  if (!found.noise_is_known || size.autoregression != 0.0) return {};
  return {1.0 - found.noise_share - size.state_dependent_fraction - 2.0 * size.revisit_error,
          1.0 - found.noise_share - size.state_dependent_fraction};
}

/// What is left over beyond noise is a function of the state.
bool is_of_the_state(const JudgedFit& fit, const Findings& found) {
  const double rest = beside_noise_and_state(fit, found).most;
  return std::isfinite(rest) ? rest < hardly_any : fit.size.state_dependent_fraction > of_the_state;
}

/// Nothing in the equation drives the motion, and what it leaves is no function of the state: something outside does.
bool is_driven_otherwise(const JudgedFit& fit, const Findings& found) {
  const bool runs_alone = fit.free_run.applies && (fit.model.terms.empty() || fit.free_run.alone);
  if (!found.above_noise || !runs_alone || found.unexplained < negligible) return false;
  const double rest = beside_noise_and_state(fit, found).least;
  if (!fit.size.has_inputs && std::isfinite(rest)) return rest > hardly_any;
  // Recorded inputs may be what drives it, where it has other faults: next to nothing comes back.
  return !fit.model.terms.empty() && fit.size.state_dependent_fraction < hardly_any;
}

/// What the likelihood says of the rest in the place of what least squares leaves: noise of the channels makes it, but
/// for what the equation does not explain.
void take_likelihood(Findings& found, const Likelihood& likelihood, double target_power) {
  found.noise_is_known = true;
  found.unexplained = likelihood.unexplained_std * likelihood.unexplained_std / target_power;
  found.residual_negligible = found.unexplained <= sensor_linearity;
  found.above_noise = likelihood.has_unexplained() && !found.residual_negligible;
  found.is_noise = !found.above_noise;
  found.misses_motion = false;
}

/// The equation through the test samples as they were recorded: all there is to follow where x was not recorded, and
/// where a free run misses x it may be by the noise of where it starts.
void take_recorded_run(Findings& found, const JudgedFit& fit, double target_power) {
  const RecordedRun& run = *fit.recorded_run;
  const bool explains = run.gain_of_process_noise <= Likelihood::beyond_doubt;
  if (fit.free_run.reason.empty()) {
    if (found.by_run == Verdict::does_not && explains) found.by_run = Verdict::in_part;
    return;
  }
  found.run_error = std::max(0.0, run.nmse - run.noise);
  if (!explains) found.run_error = std::max(found.run_error, run.unexplained_std * run.unexplained_std / target_power);
  found.by_run = by_power(found.run_error);
}

}  // namespace

Figure error_of(const JudgedFit& fit) {
  return fit.test_centred.reason.empty() ? fit.test_centred : fit.train_centred;
}

bool is_structured(const JudgedFit& fit) {
  return fit.whiteness.tested && !fit.whiteness.white;
}

bool has_wide_band(const RegressorNoise& noise) {
  return noise.needed_hz > 0.0 && noise.needed_hz < 0.5 * noise.band_hz;
}

bool leaves_out_recorded(const JudgedFit& fit, const Findings& found) {
  return found.above_noise && fit.explanations.recorded && fit.explanations.recorded->fraction > matters_to_power;
}

bool imitates(const JudgedFit& fit) {
  return fit.explanations.better && !fit.explanations.better->instead_of.empty();
}

bool lacks_form(const JudgedFit& fit, const Findings& found) {
  return found.above_noise && fit.explanations.form &&
         fit.explanations.form->fraction > std::max(matters_to_power, most_of_it * (1.0 - found.noise_share));
}

bool better_term_exists(const JudgedFit& fit, const Findings& found) {
  return imitates(fit) || (fit.explanations.better && !found.residual_negligible);
}

std::optional<double> lateness_s(const JudgedFit& fit) {
  double known_s = 0.0;
  for (const SensorEstimate& sensor : fit.sensors)
    if (sensor.unit == "s") known_s = std::max(known_s, sensor.prior_std);
  if (!fit.by_likelihood || fit.free_run.alone || !(known_s > 0.0)) return std::nullopt;
  for (const Coordinates& one : fit.model.coordinates)
    if (one.lead_s < -far_off * std::hypot(known_s, one.lead_std_s)) return -one.lead_s;
  return std::nullopt;
}

bool lower_band_helps(const JudgedFit& fit) {
  const Figure error = error_of(fit);
  return error.reason.empty() && error.value > matters_to_power && has_wide_band(fit.noise);
}

Findings findings_of(const RangeResult& range, const JudgedFit& fit) {
  const auto num_train = static_cast<Eigen::Index>(range.rows.train.size());
  const auto train = range.target.head(std::min(num_train, range.target.size()));
  const auto test = range.target.tail(range.target.size() - train.size());
  const RegressorNoise& noise = fit.noise;
  Findings found;
  found.noise_is_known = noise.residual_power > 0.0 && noise.residual_std > 0.0;
  const double noise_power = found.noise_is_known ? noise.residual_std * noise.residual_std : 0.0;
  const Figure error = error_of(fit);
  if (error.reason.empty()) {
    const double power = variance(fit.test_centred.reason.empty() ? test : train);
    found.unexplained = std::max(0.0, error.value - (power > 0.0 ? noise_power / power : 0.0));
  }
  found.residual_negligible = fit.train_centred.reason.empty() && fit.train_centred.value <= sensor_linearity;
  if (found.noise_is_known) found.noise_share = noise_power / noise.residual_power;
  found.is_noise = found.noise_is_known ? noise.known_std * noise.known_std >= mostly_noise * noise.residual_power
                                        : fit.whiteness.tested && fit.whiteness.white;
  if (found.noise_is_known)
    found.above_noise = !found.residual_negligible && found.noise_share < mostly_noise;
  else
    found.above_noise = is_structured(fit) && fit.train.reason.empty() && fit.train.value > negligible;
  found.misses_motion =
      found.noise_is_known &&
      noise.motion_std * noise.motion_std < mostly_noise * (noise.motion_power - sensor_linearity * mean_square(train));
  if (fit.by_likelihood) take_likelihood(found, range.likelihood, variance(train));
  found.may_lack_at_motion = fit.explanations.may_lack_at_motion;
  found.shows_at_motion = fit.explanations.at_motion.has_value();
  found.is_conservative = !found.residual_negligible && has_no_damping(fit);
  if (fit.train.reason.empty() && fit.test.reason.empty()) {
    const double before = fit.train.value * mean_square(train), after = fit.test.value * mean_square(test);
    found.fitted_to_its_rows =
        fit.test.value > negligible && after > carries_over * before && found.unexplained > follows;
  }
  const FreeRun& run = fit.free_run;
  if (run.diverged_after_s > 0.0 || std::isinf(run.nmse_training)) {
    found.by_run = Verdict::does_not;
  } else if (run.applies && run.reason.empty()) {
    const auto beyond_noise = [&](double nmse, double power) {
      const double floor = power > 0.0 ? noise_of_run(noise, run.alone) / power : 0.0;
      return std::isfinite(nmse) ? std::max(0.0, nmse - floor) : nan;
    };
    found.run_error = std::fmax(beyond_noise(run.nmse_centred, run.mean_square),
                                beyond_noise(run.nmse_training, run.mean_square_training));
    found.by_run = by_power(found.run_error);
    found.too_sensitive =
        found.by_run == Verdict::does_not && run.num_restarts > 0 && found.is_noise && !found.above_noise;
    const double power = std::fmax(run.mean_square, run.mean_square_training);  // a decay has little left in the end
    found.is_buried = power > 0.0 && noise.x_std * noise.x_std > mostly_noise * power;
    if (found.too_sensitive || found.is_buried) found.by_run = Verdict::undecided;
  } else if (!run.applies) {
    found.by_run = by_power(found.unexplained);
  }
  if (fit.recorded_run) take_recorded_run(found, fit, variance(test));
  found.biased = biased_term(fit);
  found.doubtful = doubtful_terms(range, fit);
  return found;
}

bool Findings::only_doubt_is_missing_term() const {
  return by_run == Verdict::describes && may_lack_at_motion && !shows_at_motion && !above_noise && !misses_motion;
}

namespace {

/// Of an equation that misses, what it lacks lies under noise that is known.
bool is_hidden(const Findings& found) {
  return found.noise_is_known && found.is_noise;
}

/// What the equation lacks at the frequencies of the motion is all that speaks against it.
bool shows_alone(const Findings& found) {
  return found.by_run == Verdict::describes && !found.above_noise && found.may_lack_at_motion;
}

Cause hiding_cause(const JudgedFit& fit) {
  return lower_band_helps(fit) ? Cause::wide_band : Cause::noise;
}

}  // namespace

NamedCause cause_of(const RangeResult& range, const JudgedFit& fit, const Findings& found) {
  const Explanations& tried = fit.explanations;
  const bool fails = found.by_run == Verdict::does_not;
  if (leaves_out_recorded(fit, found)) return {tried.recorded->cause, tried.recorded};
  if (!found.biased.empty()) return {has_wide_band(fit.noise) ? Cause::wide_band : Cause::noise};
  if (imitates(fit)) return {tried.better->cause, tried.better};
  if (was_no_candidate(fit) && fails) return {tried.recorded->cause, tried.recorded};
  if (fails && is_driven(range, fit)) return {Cause::missing_input};
  if (tried.at_motion && !fails && (shows_alone(found) || tried.at_motion->fraction > most_of_it))
    return {tried.at_motion->cause, tried.at_motion};
  if (fit.by_likelihood && range.likelihood.has_unexplained() && tried.better && tried.better->fraction > most_of_it)
    return {tried.better->cause, tried.better};
  const bool misses = found.by_run != Verdict::describes || found.unexplained > matters_to_power;
  if (is_hidden(found) && misses && !found.fitted_to_its_rows) return {hiding_cause(fit)};
  if (found.by_run == Verdict::describes && better_term_exists(fit, found)) return {tried.better->cause, tried.better};
  if (!found.above_noise) return {};
  if (lacks_form(fit, found)) return {Cause::missing_term, tried.form};
  if (lateness_s(fit)) return {Cause::late_input};
  if (is_of_the_state(fit, found)) return {Cause::missing_term};
  return {fails && is_driven_otherwise(fit, found) ? Cause::missing_input : Cause::not_found};
}

NamedCause cause_of_none(const RangeResult& range, const JudgedFit& fit) {
  if (range.exchanged) return {Cause::exchanged_roles};
  if (was_no_candidate(fit)) return {fit.explanations.recorded->cause, fit.explanations.recorded};
  if (is_driven(range, fit)) return {Cause::missing_input};
  const Findings found = findings_of(range, fit);
  const bool more_than_noise = found.above_noise || !found.noise_is_known;
  if (more_than_noise && is_of_the_state(fit, found)) return {Cause::missing_term};
  if (is_driven_otherwise(fit, found)) return {Cause::missing_input};
  if (is_hidden(found)) return {hiding_cause(fit)};
  return {range.along_motion > mostly_along_motion ? Cause::imposed_motion : Cause::not_found};
}

}  // namespace ident
