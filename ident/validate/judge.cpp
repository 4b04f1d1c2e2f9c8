#include "ident/validate/judge.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "ident/percent.hpp"
#include "ident/validate/findings.hpp"

namespace ident {
namespace {

constexpr double in_step = 0.02;  // power balance: a degree between v and a
constexpr double matters = 0.05, same = 0.1;
constexpr double collinear = 1e6;  // condition number of unit-norm columns
constexpr double poorly_known_cov = 0.3;
// Noise alone gives a p-value below this in one fit of twenty: no proof of structure, no clean bill either.
constexpr double doubtful_p_value = 0.05;
constexpr double small_term = 3.0;  // times the residual's standard deviation, at the term's largest

std::string explanation_clause(const Explanation& named) {
  const std::string fraction = percent(named.fraction);
  if (!named.instead_of.empty())
    return fmt::format("{} is no candidate; in place of {} it explains {} of what the other terms leave over",
                       named.what, fmt::join(named.instead_of, " and "), fraction);
  if (named.cause == Cause::switch_variable)
    return fmt::format("{} explains {} of what is left over: the sign is that of another motion", named.what, fraction);
  if (!named.is_term)
    return fmt::format("{} explains {} of what is left over: an inner state is missing", named.what, fraction);
  if (named.at_motion)
    return fmt::format(
        "{} is not in the equation and explains {} of what is left over at the frequencies of the motion", named.what,
        fraction);
  return named.is_recorded
             ? fmt::format("{} was recorded and is not in the equation: it explains {} of what is left over",
                           named.what, fraction)
             : fmt::format("{} is no candidate and explains {} of what is left over", named.what, fraction);
}

std::string cause_clause(const JudgedFit& fit, const Findings& found, const NamedCause& why) {
  if (why.explanation) return explanation_clause(*why.explanation);
  switch (why.cause) {
    case Cause::missing_input:
      return "something that is not in the equation drives the motion: an input or a further moving part";
    case Cause::missing_term:
      return fmt::format("{} of what is left over comes back with the state: a term or an inner state is missing",
                         percent(fit.size.revisit_fraction));
    case Cause::wide_band:
    case Cause::noise: {
      if (found.biased.empty()) return "what the equation lacks is hidden by that noise";
      const std::string biased = "noise of the signals biases the coefficient of " + found.biased;
      return why.cause == Cause::noise
                 ? biased
                 : fmt::format("{}; above {:.3g} Hz the target is noise: lower cutoff_hz", biased, fit.noise.needed_hz);
    }
    case Cause::switch_variable:
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
  if (found.may_follow)
    return fmt::format(
        "the free run does not follow x (NMSE {:.2g}), but it does with coefficients within their "
        "intervals (NMSE {:.2g}): they are not known well enough for the free run to decide",
        run.larger_nmse(), run.larger_closest());
  const std::string noise = run.larger_nmse() > 2.0 * found.run_error
                                ? fmt::format(", NMSE {:.1g} beyond the noise of x", found.run_error)
                                : std::string();
  const bool on_training = run.nmse_training > run.nmse_centred && !(found.run_error <= follows);
  const double error = on_training ? run.nmse_training : run.nmse_centred;
  if (!std::isfinite(error)) return "the free run through the training rows diverged";
  const std::string restarted =
      run.num_restarts > 0
          ? fmt::format(", set to the measured state {} times, before its errors have grown tenfold", run.num_restarts)
          : std::string();
  return fmt::format("the free run {}{} (NMSE {:.2g}, an error of {} of its rms{}{}{})", how,
                     on_training ? " through the training rows" : "", error, percent(std::sqrt(error)), noise,
                     run.sticks ? ", sticking at times" : "", restarted);
}

std::string residual_clause(const JudgedFit& fit, const Findings& found) {
  const Figure error = error_of(fit);
  std::string text = error.reason.empty() ? fmt::format("one step ahead {} of the variation of {} is unexplained",
                                                        percent(error.value), fit.model.target)
                                          : std::string("the error one step ahead is not known");
  if (found.above_noise)
    return text + (found.noise_is_known ? ", more than the noise of the signals" : ", and that is structure");
  const bool helps = found.is_noise && lower_band_helps(fit);
  if (found.is_noise) text += ", no more than noise";
  if (helps) text += fmt::format(", most of it above {:.3g} Hz", fit.noise.needed_hz);
  if (found.misses_motion || found.shows_at_motion)
    text += ", but more than noise at the frequencies of the motion";
  else if (found.may_lack_at_motion)
    text += ", but a term may be missing, as noise seldom looks so much like one at the frequencies of the motion";
  if (helps) text += ": lower cutoff_hz";
  return text;
}

std::string energy_clause(const Findings& found) {
  return found.keeps_energy ? "nothing in it drives the motion or damps it, and what does is not known" : std::string();
}

std::string doubt_clause(const std::vector<std::string>& terms) {
  return fmt::format("{} may not belong in the equation: by noise alone the 95 % interval of {} includes zero",
                     fmt::join(terms, " and "), terms.size() == 1 ? "its coefficient" : "each of their coefficients");
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
    if (term.std_noise > 0.0) largest_ratio = std::max(largest_ratio, term.std / term.std_noise);
  remarks.push_back(
      fmt::format("that is in the standard deviations, up to {:.2g} times those of white noise; terms may be kept that "
                  "only fit the structure",
                  largest_ratio));
}

void remark_on_terms(const JudgedFit& fit, std::vector<std::string>& remarks) {
  remarks.insert(remarks.end(), fit.fit.remarks.begin(), fit.fit.remarks.end());
  if (fit.fit.condition_number > collinear)
    remarks.push_back(
        fmt::format("the kept columns are nearly collinear: condition number {:.2g}", fit.fit.condition_number));
  std::vector<std::string> poor, small;
  for (const ModelTerm& term : fit.model.terms) {
    if (const double cov = term.coefficient_of_variation(); cov > poorly_known_cov)
      poor.push_back(fmt::format("{} (CoV {:.2g})", label(term), cov));
    // With structure left in the residual, a term no larger than the residual may be there only to fit it.
    if (is_structured(fit) && std::abs(term.mean) * term.scale < small_term * fit.model.noise_std)
      small.push_back(label(term));
  }
  if (!poor.empty()) remarks.push_back(fmt::format("poorly determined: {}", fmt::join(poor, ", ")));
  if (!small.empty())
    remarks.push_back(fmt::format("never larger than {:g} times the residual, so perhaps only fitted to it: {}",
                                  small_term, fmt::join(small, ", ")));
}

Judgement judgement_of_none(const RangeResult& range, const JudgedFit& fit) {
  std::string text = "No equation was found: no candidate term explains more than noise";
  const NamedCause why = cause_of_none(range, fit);
  if (why.explanation)
    text += fmt::format("; {} is not among them and explains {} of {}", why.explanation->what,
                        percent(why.explanation->fraction), fit.model.target);
  else if (why.cause == Cause::missing_input)
    text += "; something that is not among them drives the motion: an input or a further moving part";
  if (has_wide_band(fit.noise))
    text += fmt::format("; above {:.3g} Hz {} is noise: lower cutoff_hz", fit.noise.needed_hz, fit.model.target);
  return {Verdict::does_not, why.cause, why.explanation, text + ".", {}};
}

Judgement judgement_of(const std::vector<RangeResult>& ranges, std::size_t range, std::size_t method) {
  const JudgedFit& fit = ranges[range].fits[method];
  if (fit.model.terms.empty()) return judgement_of_none(ranges[range], fit);
  const Findings found = findings_of(ranges[range], fit);
  Judgement result{.verdict = found.verdict()};
  if (leaves_out_recorded(fit, found) || !found.biased.empty() || imitates(fit) || lacks_form(fit, found))
    result.verdict = Verdict::does_not;
  const bool left_over = found.unexplained > matters_to_power;
  if (result.verdict == Verdict::undecided && left_over) result.verdict = Verdict::does_not;

  const bool converged = fit.fit.status == FitStatus::converged;
  const double balance = ranges[range].power_balance;
  const bool out_of_step = std::isfinite(balance) && std::abs(balance) > in_step;
  const Agreement others = agreement(ranges, range, method);
  if (result.verdict == Verdict::describes &&
      (!converged || left_over || found.fitted_to_its_rows || found.keeps_energy || out_of_step || others.other ||
       lacks_better(fit, found)))
    result.verdict = Verdict::in_part;
  const bool only_doubtful = result.verdict == Verdict::describes && !found.doubtful.empty();
  if (only_doubtful) result.verdict = Verdict::in_part;

  std::vector<std::string> clauses{free_run_clause(fit.free_run, found),
                                   residual_clause(fit, found),
                                   carry_over_clause(fit, found),
                                   energy_clause(found),
                                   power_clause(balance),
                                   others.clause};
  if (!converged) clauses.push_back(fmt::format("the fit ended as {}", to_string(fit.fit.status)));
  if (only_doubtful) {
    clauses.push_back(doubt_clause(found.doubtful));
  } else if (result.verdict == Verdict::in_part || result.verdict == Verdict::does_not) {
    const NamedCause why = cause_of(ranges[range], fit, found);
    result.cause = why.cause;
    result.named = why.explanation;
    if (result.verdict == Verdict::does_not || why.cause != Cause::not_found)
      clauses.push_back(cause_clause(fit, found, why));
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
    const bool speaks = !fit.model.terms.empty() && fit.fit.method == Method::fast_rvm;
    return std::pair(speaks, preference(fit.judgement.verdict));
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
