#include "ident/validate/judge.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "ident/percent.hpp"
#include "ident/validate/crests.hpp"

namespace ident {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
// Free-run error of x about its mean, beyond what its noise makes, as a fraction of its power: a tenth of its
// amplitude, and three tenths; where more than noise is left over, a seventh.
constexpr double follows = 0.01, follows_in_part = 0.1, follows_beyond_noise = 0.02;
constexpr double in_step = 0.02;   // power balance: a degree between v and a
constexpr double explained = 0.1;  // a smaller part, of the target's power or of what is left of it, does not matter
// Power of a residual, as a fraction of the target's, that sensors themselves may make: few are linear to 0.3 %.
constexpr double linearity = 1e-5;
// Where the noise of the channels makes less than this fraction of the residual, twice as much is something else.
constexpr double mostly_noise = 0.5;
// Of the residual's power, what comes back when the state does: from here on it is a function of the state, and up to
// there of something else.
constexpr double of_the_state = 0.75, of_something_else = 0.1;
// Below this fraction of the target's power, structure in the residual spoils the error bars but not the equation.
constexpr double negligible = 1e-3;
constexpr double carries_over = 10.0;  // residual power on test rows / on training rows: fitted to its rows only
constexpr double matters = 0.05, same = 0.1;
constexpr double collinear = 1e6;  // condition number of unit-norm columns
constexpr double poorly_known_cov = 0.3;
// Noise alone gives a p-value below this in one fit of twenty: no proof of structure, no clean bill either.
constexpr double doubtful_p_value = 0.05;
constexpr double small_term = 3.0;  // times the residual's standard deviation, at the term's largest
constexpr double bias_in_stds = 2.0, bias_of_mean = 0.02;  // by noise of regressors: beyond both the interval misses
// A start from a measured state carries the noise of x and of v into the run, beside that of x itself.
constexpr double noises_of_a_run = 3.0;

/// About the mean: of a force about its rest the mean is most of the power and none of the news.
const Figure& error_of(const JudgedFit& fit) {
  return fit.test_centred.reason.empty() ? fit.test_centred : fit.train_centred;
}

bool structured(const JudgedFit& fit) {
  return fit.whiteness.tested && !fit.whiteness.white;
}

double mean_square(const Eigen::Ref<const Eigen::VectorXd>& values) {
  return values.size() > 0 ? values.squaredNorm() / static_cast<double>(values.size()) : nan;
}

double variance(const Eigen::Ref<const Eigen::VectorXd>& values) {
  return values.size() > 0 ? mean_square((values.array() - values.mean()).matrix()) : nan;
}

/// What was found about a fit on a range, apart from other ranges.
struct Findings {
  Verdict by_run = Verdict::undecided;
  double run_error = nan;    ///< NMSE of the free run beyond what noise makes; NaN: none
  double unexplained = nan;  ///< of the target's variation one step ahead, beyond the noise of the channels
  bool noise_is_known = false;
  double noise_share = 0.0;  ///< of the power of what is left on the training rows, at most
  bool is_noise = false;     ///< what is left on the training rows is the noise of the channels
  bool above_noise = false;  ///< what is left on the training rows is more than noise
  bool fitted_to_its_rows = false;
  std::string biased;  ///< a term whose interval misses by noise of the regressors
};

std::string biased_term(const JudgedFit& fit) {
  for (std::size_t i = 0; i < fit.model.terms.size() && fit.noise.bias.size() > 0; ++i) {
    const ModelTerm& term = fit.model.terms[i];
    const double bias = std::abs(fit.noise.bias(static_cast<Eigen::Index>(i)));
    if (bias > bias_in_stds * term.std && bias > bias_of_mean * std::abs(term.mean)) return term.name;
  }
  return {};
}

Verdict by_power(double left_over) {
  if (!std::isfinite(left_over)) return Verdict::undecided;
  return left_over <= follows           ? Verdict::describes
         : left_over <= follows_in_part ? Verdict::in_part
                                        : Verdict::does_not;
}

Findings findings_of(const RangeResult& range, const JudgedFit& fit) {
  const auto num_train = static_cast<Eigen::Index>(range.rows.train.size());
  const auto train = range.target.head(std::min(num_train, range.target.size()));
  const auto test = range.target.tail(range.target.size() - train.size());
  const RegressorNoise& noise = fit.noise;
  Findings found;
  found.noise_is_known = noise.residual_power > 0.0 && noise.residual_std > 0.0;
  const double noise_power = found.noise_is_known ? noise.residual_std * noise.residual_std : 0.0;
  const Figure& error = error_of(fit);
  if (error.reason.empty()) {
    const double power = variance(fit.test_centred.reason.empty() ? test : train);
    found.unexplained = std::max(0.0, error.value - (power > 0.0 ? noise_power / power : 0.0));
  }
  const bool negligible_rest = fit.train_centred.reason.empty() && fit.train_centred.value <= linearity;
  if (found.noise_is_known) found.noise_share = noise_power / noise.residual_power;
  found.is_noise = found.noise_is_known ? noise.known_std * noise.known_std >= mostly_noise * noise.residual_power
                                        : fit.whiteness.tested && fit.whiteness.white;
  if (found.noise_is_known)
    found.above_noise = !negligible_rest && found.noise_share < mostly_noise;
  else
    found.above_noise = structured(fit) && fit.train.reason.empty() && fit.train.value > negligible;
  if (fit.train.reason.empty() && fit.test.reason.empty()) {
    const double before = fit.train.value * mean_square(train), after = fit.test.value * mean_square(test);
    found.fitted_to_its_rows =
        fit.test.value > negligible && after > carries_over * before && found.unexplained > follows;
  }
  const FreeRun& run = fit.free_run;
  if (run.diverged_after_s > 0.0) {
    found.by_run = Verdict::does_not;
  } else if (run.applies && run.reason.empty()) {
    const double floor = run.mean_square > 0.0 ? noise.x_std * noise.x_std / run.mean_square : 0.0;
    if (std::isfinite(run.nmse_centred)) found.run_error = std::max(0.0, run.nmse_centred - noises_of_a_run * floor);
    found.by_run = by_power(found.run_error);
  } else if (!run.applies) {
    found.by_run = by_power(found.unexplained);
  }
  found.biased = biased_term(fit);
  return found;
}

/// With more than noise left over.
Verdict lowered(const Findings& found) {
  const double error = std::isfinite(found.run_error) ? found.run_error : found.unexplained;
  if (found.by_run == Verdict::in_part && error > follows_beyond_noise) return Verdict::does_not;
  return found.by_run == Verdict::describes ? Verdict::in_part : found.by_run;
}

/// Most of what is in the band of the target is noise.
bool wide_band(const RegressorNoise& noise) {
  return noise.needed_hz > 0.0 && noise.needed_hz < 0.5 * noise.band_hz;
}

/// Something recorded explains a part that matters of what is left over beside noise.
bool explains(const JudgedFit& fit, const Findings& found) {
  return found.above_noise && fit.explanations.recorded && fit.explanations.recorded->fraction > explained;
}

/// A usual form that is no candidate explains most of what is left over beside noise.
bool lacks_form(const JudgedFit& fit, const Findings& found) {
  constexpr double most = 0.5;
  return found.above_noise && fit.explanations.form &&
         fit.explanations.form->fraction > std::max(explained, most * (1.0 - found.noise_share));
}

/// However little of what is left over it explains: an equation that fails has nothing better to show for it.
bool was_no_candidate(const JudgedFit& fit) {
  return fit.explanations.recorded && !fit.explanations.recorded->candidate;
}

/// Lost amplitude comes back, more than once, though nothing measured drives the equation.
bool is_driven(const RangeResult& range, const JudgedFit& fit) {
  if (!fit.model.terms.empty() && !fit.free_run.alone) return false;
  constexpr double once = 1.0;
  constexpr double noises = 8.0;  // among hundreds of crests the extremes lie six standard deviations apart
  constexpr double quarter = 0.25, half = 0.5;  // of the largest: less is a passing transient; half where the noise of
                                                // x was not looked for
  double renewed = 0.0;
  for (const std::vector<double>& crests : range.crests) {
    if (crests.empty()) continue;
    const double largest = *std::max_element(crests.begin(), crests.end());
    const double least = (fit.noise.x_std > 0.0 ? quarter : half) * largest;
    renewed += renewed_amplitude(crests, std::max(least, noises * fit.noise.x_std));
  }
  return renewed > once;
}

/// Named where a test found it, in this order.
Cause cause_of(const RangeResult& range, const JudgedFit& fit, const Findings& found) {
  if (explains(fit, found)) return fit.explanations.recorded->cause;
  if (!found.biased.empty()) return wide_band(fit.noise) ? Cause::wide_band : Cause::noise;
  if (was_no_candidate(fit) && found.by_run == Verdict::does_not) return fit.explanations.recorded->cause;
  if (!found.above_noise) return Cause::not_found;
  if (found.by_run == Verdict::does_not && is_driven(range, fit)) return Cause::missing_input;
  if (lacks_form(fit, found) || fit.size.revisit_fraction > of_the_state) return Cause::missing_term;
  const bool driven_otherwise =
      fit.free_run.applies && fit.size.revisit_fraction < of_something_else && fit.free_run.alone;
  return driven_otherwise && found.by_run == Verdict::does_not ? Cause::missing_input : Cause::not_found;
}

std::string cause_clause(const JudgedFit& fit, const Findings& found, Cause cause) {
  const auto& recorded = fit.explanations.recorded;
  const bool by_recorded = explains(fit, found) || was_no_candidate(fit);
  if (by_recorded && recorded->cause == cause && cause != Cause::switch_variable)
    return fmt::format("{} was recorded and is not in the equation: it explains {} of what is left over",
                       recorded->what, percent(recorded->fraction));
  switch (cause) {
    case Cause::missing_input:
      return "something that is not in the equation drives the motion: an input or a further moving part";
    case Cause::switch_variable:
      return fmt::format("{} explains {} of what is left over: the sign is that of another motion", recorded->what,
                         percent(recorded->fraction));
    case Cause::missing_term:
      if (lacks_form(fit, found))
        return fmt::format("{} is no candidate and explains {} of what is left over", fit.explanations.form->what,
                           percent(fit.explanations.form->fraction));
      return fmt::format("{} of what is left over comes back with the state: a term or an inner state is missing",
                         percent(fit.size.revisit_fraction));
    case Cause::wide_band:
      return fmt::format(
          "noise of the signals biases the coefficient of {}; above {:.3g} Hz the target is noise: lower "
          "cutoff_hz",
          found.biased, fit.noise.needed_hz);
    case Cause::noise:
      return fmt::format("noise of the signals biases the coefficient of {}", found.biased);
    case Cause::not_found:
      break;
  }
  return "cause not found";
}

std::string free_run_clause(const FreeRun& run, const Findings& found) {
  if (run.diverged_after_s > 0.0) return "the free run " + run.reason;
  if (!run.applies) return {};
  if (!run.reason.empty()) return "there is no free run (" + run.reason + ")";
  const char* how = found.run_error <= follows           ? "follows x"
                    : found.run_error <= follows_in_part ? "follows x roughly"
                                                         : "does not follow x";
  const std::string noise = run.nmse_centred > 2.0 * found.run_error
                                ? fmt::format(", NMSE {:.1g} beyond the noise of x", found.run_error)
                                : std::string();
  return fmt::format("the free run {} (NMSE {:.2g}, an error of {} of its rms{}{})", how, run.nmse_centred,
                     percent(std::sqrt(run.nmse_centred)), noise, run.sticks ? ", sticking at times" : "");
}

std::string residual_clause(const JudgedFit& fit, const Findings& found) {
  const Figure& error = error_of(fit);
  std::string text = error.reason.empty() ? fmt::format("one step ahead {} of the variation of {} is unexplained",
                                                        percent(error.value), fit.model.target)
                                          : std::string("the error one step ahead is not known");
  if (found.above_noise)
    return text + (found.noise_is_known ? ", more than the noise of the signals" : ", and that is structure");
  if (!found.is_noise) return text;
  text += ", no more than noise";
  if (error.reason.empty() && error.value > explained && wide_band(fit.noise))
    text += fmt::format(", most of it above {:.3g} Hz: lower cutoff_hz", fit.noise.needed_hz);
  return text;
}

std::string power_clause(double balance) {
  if (!std::isfinite(balance)) return {};
  return std::abs(balance) <= in_step
             ? fmt::format("the sensors are in step (power balance {:.1g})", std::abs(balance))
             : fmt::format("velocity and acceleration are out of step (power balance {:.2g}), which reads as damping",
                           std::abs(balance));
}

std::string carry_over_clause(const JudgedFit& fit, const Findings& found) {
  if (!found.fitted_to_its_rows) return {};
  return fmt::format("it does not carry over: NMSE {:.2g} on the test rows, {:.2g} on the training rows",
                     fit.test.value, fit.train.value);
}

/// The equations of two ranges as they are beside one another: that of a recording, where one range is of it alone.
std::pair<Model, Model> comparable(const RangeResult& a, const RangeResult& b, std::size_t method) {
  const Model &one = a.fits[method].model, &other = b.fits[method].model;
  if (own_coefficients(one).size() == own_coefficients(other).size() && a.recording == b.recording) return {one, other};
  const int recording = std::max(a.recording, b.recording);
  return {equation_of(one, recording), equation_of(other, recording)};
}

/// Terms that matter in one of two equations and are not the same in the other.
std::vector<std::string> unlike(const RangeResult& a, const RangeResult& b, std::size_t method) {
  std::vector<std::string> names;
  const auto one_way = [&](const RangeResult& one, const RangeResult& other) {
    const double bar = matters * one.target.cwiseAbs().maxCoeff();
    const auto [model, other_model] = comparable(one, other, method);
    const auto& others = other_model.terms;
    for (const ModelTerm& term : model.terms) {
      if (std::abs(term.mean) * term.scale < bar) continue;
      const auto twin = std::find_if(others.begin(), others.end(), [&](const auto& t) { return t.name == term.name; });
      const bool alike = twin != others.end() && std::abs(twin->mean - term.mean) <= same * std::abs(term.mean);
      if (!alike && std::find(names.begin(), names.end(), term.name) == names.end()) names.push_back(term.name);
    }
  };
  one_way(a, b);
  one_way(b, a);
  return names;
}

/// Ranges that share no samples are the ones whose agreement says something: mixed holds low and high, all recordings
/// hold each.
bool apart(const RangeResult& a, const RangeResult& b) {
  return (a.recording == 0) == (b.recording == 0) && a.regime != dsp::RegimeSet::mixed() &&
         b.regime != dsp::RegimeSet::mixed();
}

struct Agreement {
  bool other = false;  // some range has another equation
  std::string clause;
};

Agreement agreement(const std::vector<RangeResult>& ranges, std::size_t range, std::size_t method) {
  std::vector<std::string> agree, disagree;
  for (std::size_t other = 0; other < ranges.size(); ++other) {
    if (other == range || !apart(ranges[range], ranges[other]) || ranges[other].fits[method].model.terms.empty())
      continue;
    const auto names = unlike(ranges[range], ranges[other], method);
    if (names.empty())
      agree.push_back(ranges[other].spec.name);
    else
      disagree.push_back(fmt::format("{} has another {}", ranges[other].spec.name, fmt::join(names, ", ")));
  }
  if (!disagree.empty()) return {true, fmt::format("{}", fmt::join(disagree, ", "))};
  if (agree.empty()) return {};
  return {false, fmt::format("{} agree{} within 10 %", fmt::join(agree, " and "), agree.size() == 1 ? "s" : "")};
}

const char* opening(Verdict verdict) {
  switch (verdict) {
    case Verdict::describes:
      return "This equation describes the record";
    case Verdict::in_part:
      return "This equation describes the record in part";
    case Verdict::does_not:
      return "This equation does not describe the record";
    case Verdict::undecided:
      break;
  }
  return "Whether this equation describes the record is undecided";
}

void remark_on_residual(const JudgedFit& fit, std::vector<std::string>& remarks) {
  const Whiteness& whiteness = fit.whiteness;
  if (!whiteness.tested) {
    remarks.emplace_back("whether the residual is white could not be tested");
    return;
  }
  const std::string statistic =
      fmt::format("Bartlett p = {:.2g}; the strongest 5 % of frequencies hold {:.0f} % of its power, 20 % if white",
                  whiteness.p_value, 100.0 * whiteness.peak_fraction);
  if (whiteness.white) {
    remarks.push_back(whiteness.p_value < doubtful_p_value
                          ? fmt::format("whether the residual is white is in doubt ({})", statistic)
                          : fmt::format("residual is white ({})", statistic));
    return;
  }
  remarks.push_back(fmt::format("residual is not white: structure remains ({})", statistic));
  if (fit.size.fraction() < 1.0) {
    remarks.push_back(
        fmt::format("that is in the standard deviations: the {:.0f} rows count as {:.0f} independent ones",
                    fit.size.num_rows, fit.size.num_effective()));
    return;
  }
  if (!fit.sensors.empty()) {
    remarks.push_back(
        fmt::format("its autocorrelation is in the standard deviations: the rows count as {:.0f} % of as "
                    "many white ones",
                    100.0 * fit.independent_fraction));
    return;
  }
  double largest_ratio = 1.0;
  for (const ModelTerm& term : fit.model.terms)
    if (term.std > 0.0 && std::isfinite(term.std_robust))
      largest_ratio = std::max(largest_ratio, term.std_robust / term.std);
  remarks.push_back(
      fmt::format("standard deviations assume white noise; without that they are up to {:.2g} times larger, and terms "
                  "may be kept that only fit the structure",
                  largest_ratio));
}

void remark_on_terms(const JudgedFit& fit, std::vector<std::string>& remarks) {
  remarks.insert(remarks.end(), fit.fit.remarks.begin(), fit.fit.remarks.end());
  if (fit.fit.condition_number > collinear)
    remarks.push_back(
        fmt::format("the kept columns are nearly collinear: condition number {:.2g}", fit.fit.condition_number));
  std::vector<std::string> poor, small;
  for (const ModelTerm& term : fit.model.terms) {
    const double std = std::max(term.std, std::isfinite(term.std_robust) ? term.std_robust : 0.0);
    if (const double cov = std / std::abs(term.mean); cov > poorly_known_cov)
      poor.push_back(fmt::format("{} (CoV {:.2g})", label(term), cov));
    // With structure left in the residual, a term no larger than the residual may be there only to fit it.
    if (structured(fit) && std::abs(term.mean) * term.scale < small_term * fit.model.noise_std)
      small.push_back(label(term));
  }
  if (!poor.empty()) remarks.push_back(fmt::format("poorly determined: {}", fmt::join(poor, ", ")));
  if (!small.empty())
    remarks.push_back(fmt::format("never larger than {:g} times the residual, so perhaps only fitted to it: {}",
                                  small_term, fmt::join(small, ", ")));
}

Judgement judgement_of(const std::vector<RangeResult>& ranges, std::size_t range, std::size_t method) {
  const JudgedFit& fit = ranges[range].fits[method];
  if (fit.model.terms.empty()) {
    std::string text = "No equation was found: no candidate term explains more than noise";
    const bool driven = is_driven(ranges[range], fit);
    if (was_no_candidate(fit))
      text += fmt::format("; {} is not among them and explains {} of {}", fit.explanations.recorded->what,
                          percent(fit.explanations.recorded->fraction), fit.model.target);
    else if (driven)
      text += "; something that is not among them drives the motion: an input or a further moving part";
    if (wide_band(fit.noise))
      text += fmt::format("; above {:.3g} Hz {} is noise: lower cutoff_hz", fit.noise.needed_hz, fit.model.target);
    return {Verdict::does_not,
            was_no_candidate(fit) ? fit.explanations.recorded->cause
            : driven              ? Cause::missing_input
                                  : Cause::not_found,
            text + ".",
            {}};
  }
  const Findings found = findings_of(ranges[range], fit);
  Judgement result{found.by_run, {}, {}, {}};
  if (found.above_noise) result.verdict = lowered(found);
  if (explains(fit, found) || !found.biased.empty()) result.verdict = Verdict::does_not;
  const bool left_over = found.unexplained > explained;
  if (result.verdict == Verdict::undecided && left_over) result.verdict = Verdict::does_not;

  const bool converged = fit.fit.status == FitStatus::converged;
  const double balance = ranges[range].power_balance;
  const bool out_of_step = std::isfinite(balance) && std::abs(balance) > in_step;
  const Agreement others = agreement(ranges, range, method);
  if (result.verdict == Verdict::describes &&
      (!converged || left_over || found.fitted_to_its_rows || out_of_step || others.other))
    result.verdict = Verdict::in_part;

  std::vector<std::string> clauses{free_run_clause(fit.free_run, found), residual_clause(fit, found),
                                   carry_over_clause(fit, found), power_clause(balance), others.clause};
  if (!converged) clauses.push_back(fmt::format("the fit ended as {}", to_string(fit.fit.status)));
  if (result.verdict == Verdict::in_part || result.verdict == Verdict::does_not) {
    result.cause = cause_of(ranges[range], fit, found);
    if (result.verdict == Verdict::does_not || result.cause != Cause::not_found)
      clauses.push_back(cause_clause(fit, found, *result.cause));
  }
  std::erase_if(clauses, [](const std::string& clause) { return clause.empty(); });
  result.sentence = fmt::format("{}: {}.", opening(result.verdict), fmt::join(clauses, "; "));
  remark_on_residual(fit, result.remarks);
  remark_on_terms(fit, result.remarks);
  return result;
}

}  // namespace

void judge(std::vector<RangeResult>& ranges) {
  for (std::size_t range = 0; range < ranges.size(); ++range)
    for (std::size_t method = 0; method < ranges[range].fits.size(); ++method)
      ranges[range].fits[method].judgement = judgement_of(ranges, range, method);
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

std::size_t chosen_method(const RangeResult& range) {
  const auto rank = [](const JudgedFit& fit) {
    return std::pair(preference(fit.judgement.verdict), fit.fit.method == Method::fast_rvm);
  };
  const auto best = std::max_element(range.fits.begin(), range.fits.end(),
                                     [&](const JudgedFit& a, const JudgedFit& b) { return rank(a) < rank(b); });
  return static_cast<std::size_t>(best - range.fits.begin());
}

std::optional<ChosenFit> chosen_fit(const std::vector<RangeResult>& ranges) {
  const auto rank = [](const RangeResult& range) {
    return std::pair(range.fits.empty() ? -1 : preference(range.fits[chosen_method(range)].judgement.verdict),
                     range.rows.train.size() + range.rows.test.size());
  };
  const auto best = std::max_element(ranges.begin(), ranges.end(),
                                     [&](const RangeResult& a, const RangeResult& b) { return rank(a) < rank(b); });
  if (best == ranges.end() || best->fits.empty()) return std::nullopt;
  return ChosenFit{static_cast<std::size_t>(best - ranges.begin()), chosen_method(*best)};
}

std::vector<RangeDisagreement> compare_ranges(const std::vector<RangeResult>& ranges) {
  std::vector<RangeDisagreement> result;
  if (ranges.empty()) return result;
  for (std::size_t method = 0; method < ranges.front().fits.size(); ++method)
    for (std::size_t a = 0; a < ranges.size(); ++a)
      for (std::size_t b = a + 1; b < ranges.size(); ++b) {
        const std::string &name_a = ranges[a].spec.name, &name_b = ranges[b].spec.name;
        const auto [model_a, model_b] = comparable(ranges[a], ranges[b], method);
        auto terms = disagreements(model_a, name_a, model_b, name_b);
        if (!terms.empty())
          result.push_back(
              {std::string(to_string(ranges[a].fits[method].fit.method)), name_a, name_b, std::move(terms)});
      }
  return result;
}

}  // namespace ident
