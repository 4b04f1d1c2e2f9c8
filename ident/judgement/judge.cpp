#include "ident/judgement/judge.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "ident/equation/percent.hpp"
#include "ident/judgement/findings.hpp"
#include "ident/judgement/range_agreement.hpp"

namespace ident {
namespace {

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

std::string exchanged_clause(const RangeResult& range) {
  return fmt::format(
      "what is called the base moves as a payload on what is called the payload would: all but {} of its acceleration "
      "follows from what is between them",
      percent(range.exchanged.value_or(0.0)));
}

std::string cause_clause(const RangeResult& range, const JudgedFit& fit, const Findings& found, const NamedCause& why) {
  if (why.explanation) return explanation_clause(*why.explanation);
  switch (why.cause) {
    case Cause::missing_input:
      return "something that is not in the equation drives the motion: an input or a further moving part";
    case Cause::missing_term:
      return fmt::format("{} of what is left over comes back with the state: a term or an inner state is missing",
                         percent(fit.size.state_dependent_fraction));
    case Cause::wide_band:
    case Cause::noise: {
      if (found.biased.empty()) return "what the equation lacks is hidden by that noise";
      const std::string biased = "noise of the signals biases the coefficient of " + found.biased;
      return why.cause == Cause::noise
                 ? biased
                 : fmt::format("{}; above {:.3g} Hz the target is noise: lower cutoff_hz", biased, fit.noise.needed_hz);
    }
    case Cause::late_input:
      return fmt::format(
          "the motion answers what drives it {:.2g} s late, more than sensors are out of step by, and not as after a "
          "delay; an actuator with a lag would make it so",
          lateness_s(fit).value_or(0.0));
    case Cause::exchanged_roles:
      return exchanged_clause(range);
    case Cause::imposed_motion:
      return fmt::format(
          "x and v explain {} of the recorded force, as where a machine imposes the motion; of a motion of "
          "one frequency f, x'' = -(2 pi f)^2 x holds whatever it is of",
          percent(range.along_motion));
    case Cause::switch_variable:
    case Cause::not_found:
      break;
  }
  return "cause not found";
}

/// Of the channel that was recorded in the place of x.
std::string recorded_run_clause(const RecordedRun& run, const Findings& found) {
  return fmt::format("from where it is found to begin it {} {} as it was recorded (NMSE {:.2g}{})",
                     found.run_error <= follows           ? "follows"
                     : found.run_error <= follows_in_part ? "follows roughly"
                                                          : "does not follow",
                     run.channel, run.nmse,
                     run.nmse > 2.0 * found.run_error ? fmt::format(", {:.1g} beyond its noise", found.run_error) : "");
}

std::string free_run_clause(const FreeRun& run, const Findings& found) {
  if (run.diverged_after_s > 0.0) return "the free run " + run.reason;
  if (!run.applies) return {};
  if (!run.reason.empty()) return "there is no free run (" + run.reason + ")";
  const char* how = found.run_error <= follows           ? "follows x"
                    : found.run_error <= follows_in_part ? "follows x roughly"
                                                         : "does not follow x";
  const std::string noise = run.larger_nmse() <= 2.0 * found.run_error ? std::string()
                            : found.run_error > 0.0
                                ? fmt::format(", NMSE {:.1g} beyond the noise of x", found.run_error)
                                : std::string(", no more than the noise of x");
  const bool on_training = run.nmse_training > run.nmse_centred && !(found.run_error <= follows);
  const double error = on_training ? run.nmse_training : run.nmse_centred;
  if (!std::isfinite(error)) return "the free run through the training rows diverged";
  const std::string restarted =
      run.num_restarts > 0
          ? fmt::format(", set to the measured state {} times, before its errors have grown tenfold", run.num_restarts)
          : std::string();
  return fmt::format("the free run {}{} (NMSE {:.2g}, an error of {} of its rms{}{}{}){}", how,
                     on_training ? " through the training rows" : "", error, percent(std::sqrt(error)), noise,
                     run.sticks ? ", sticking at times" : "", restarted,
                     found.too_sensitive ? ", but so sensitive a motion does not decide"
                     : found.is_buried   ? ", but most of x is its noise, so that decides nothing"
                                         : "");
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
  if (why.cause == Cause::exchanged_roles)
    text += "; " + exchanged_clause(range);
  else if (why.explanation)
    text += fmt::format("; {} is not among them and explains {} of {}", why.explanation->what,
                        percent(why.explanation->fraction), fit.model.target);
  else if (why.cause == Cause::missing_input)
    text += "; something that is not among them drives the motion: an input or a further moving part";
  if (has_wide_band(fit.noise))
    text += fmt::format("; above {:.3g} Hz {} is noise: lower cutoff_hz", fit.noise.needed_hz, fit.model.target);
  return {.verdict = Verdict::does_not, .cause = why.cause, .named = why.explanation, .sentence = text + "."};
}

/// What takes the verdict of the free run down, and what all rules have to say.
void apply_rules(const Evidence& of, Judgement& result, std::vector<std::string>& clauses) {
  std::ptrdiff_t num_causes = 0;
  for (const VerdictRule& rule : verdict_rules()) {
    const bool lowers = preference(rule.at_most) < preference(of.found.by_run) && rule.holds(of) &&
                        (!rule.only_alone || result.rules.empty());
    if (lowers) {
      result.rules.push_back(&rule);
      if (preference(rule.at_most) < preference(result.verdict)) result.verdict = rule.at_most;
    }
    if (rule.clause != nullptr && rule.is_cause && lowers)
      clauses.insert(clauses.begin() + num_causes++, rule.clause(of));
    else if (rule.clause != nullptr && !rule.is_cause)
      clauses.push_back(rule.clause(of));
  }
}

bool has_force(const Model& model) {
  return std::any_of(model.terms.begin(), model.terms.end(), [](const ModelTerm& term) {
    const Expression expression(term.name);
    return std::find(expression.signals().begin(), expression.signals().end(), "f") != expression.signals().end();
  });
}

/// Nothing where the verdict needs none, or the clause of a rule that took it down is the cause.
std::optional<NamedCause> cause_asked(const Evidence& of, const Judgement& result) {
  if (result.verdict == Verdict::describes) return std::nullopt;
  if (of.range.exchanged && (result.verdict == Verdict::does_not || of.found.above_noise))
    return NamedCause{Cause::exchanged_roles};
  if ((of.found.is_conservative || result.verdict == Verdict::does_not) && !has_force(of.fit.model) &&
      of.range.along_motion > mostly_along_motion) {
    // A force that drives its resonance is along the motion, too; it is named where it explains what is left over.
    const NamedCause why = cause_of(of.range, of.fit, of.found);
    return why.explanation ? why : NamedCause{Cause::imposed_motion};
  }
  if (result.verdict == Verdict::undecided) return std::nullopt;
  const bool is_said = of.found.by_run == Verdict::describes &&
                       std::all_of(result.rules.begin(), result.rules.end(), [](auto* rule) { return rule->is_cause; });
  return is_said ? std::nullopt : std::optional(cause_of(of.range, of.fit, of.found));
}

Judgement judgement_of(const std::vector<RangeResult>& ranges, std::size_t range, std::size_t method,
                       const RangeResult* larger = nullptr) {
  const JudgedFit& fit = ranges[range].fits[method];
  if (fit.model.terms.empty()) return judgement_of_none(ranges[range], fit);
  const Evidence of{ranges[range], fit, findings_of(ranges[range], fit), agreement(ranges, range, method), larger};
  Judgement result{.verdict = of.found.by_run};
  const bool of_recorded = fit.recorded_run && !fit.free_run.reason.empty();
  std::vector<std::string> clauses{
      of_recorded ? recorded_run_clause(*fit.recorded_run, of.found) : free_run_clause(fit.free_run, of.found),
      of_recorded ? std::string() : residual_clause(fit, of.found)};
  apply_rules(of, result, clauses);
  if (const std::optional<NamedCause> why = cause_asked(of, result)) {
    result.cause = why->cause;
    result.named = why->explanation;
    if (result.verdict == Verdict::does_not || why->cause != Cause::not_found)
      clauses.push_back(cause_clause(of.range, fit, of.found, *why));
  }
  std::erase_if(clauses, [](const std::string& clause) { return clause.empty(); });
  result.sentence = fmt::format("{}: {}.", opening(result.verdict), fmt::join(clauses, "; "));
  remark_on_residual(fit, result.remarks);
  remark_on_terms(fit, result.remarks);
  return result;
}

/// The range with most rows, where it has more than this one and its own equation does not describe it.
const RangeResult* larger_failure(const std::vector<RangeResult>& ranges, std::size_t range, std::size_t method) {
  const auto size = [](const RangeResult& one) { return one.rows.train.size() + one.rows.test.size(); };
  const auto most = std::max_element(ranges.begin(), ranges.end(),
                                     [&](const RangeResult& a, const RangeResult& b) { return size(a) < size(b); });
  const bool fails = size(*most) > size(ranges[range]) && method < most->fits.size() &&
                     most->fits[method].judgement.verdict == Verdict::does_not;
  return fails ? &*most : nullptr;
}

}  // namespace

void judge(std::vector<RangeResult>& ranges) {
  for (std::size_t range = 0; range < ranges.size(); ++range)
    for (std::size_t method = 0; method < ranges[range].fits.size(); ++method)
      ranges[range].fits[method].judgement = judgement_of(ranges, range, method);
  for (std::size_t range = 0; range < ranges.size(); ++range)
    for (std::size_t method = 0; method < ranges[range].fits.size(); ++method)
      if (const RangeResult* larger = larger_failure(ranges, range, method))
        ranges[range].fits[method].judgement = judgement_of(ranges, range, method, larger);
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
