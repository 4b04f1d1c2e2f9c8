#include "apps/judgement.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace apps {
namespace {

// Below this share of the target's power, structure in the residual spoils the error bars but not the equation.
constexpr double negligible_nmse = 1e-3;
// A free run that leaves more than this share of x's power unexplained, a third of its amplitude, does not describe the
// motion.
constexpr double useless_free_run = 0.1;
constexpr double carries_over = 10.0;  // test NMSE / training NMSE beyond this: fitted to its rows only
constexpr double collinear = 1e6;      // condition number of unit-norm columns
constexpr double poorly_known_cov = 0.3;
// Noise alone gives a p-value below this in one fit of twenty: no proof of structure, no clean bill either.
constexpr double doubtful_p_value = 0.05;
constexpr double small_term = 3.0;  // times the residual's standard deviation, at the term's largest

class Verdict {
 public:
  void against(Trust trust, std::string remark) {
    result_.trust = std::max(result_.trust, trust);
    result_.remarks.push_back(std::move(remark));
  }
  void remark(std::string text) { rest_.push_back(std::move(text)); }
  Judgement finish() {
    result_.remarks.insert(result_.remarks.end(), rest_.begin(), rest_.end());
    return std::move(result_);
  }

 private:
  Judgement result_;
  std::vector<std::string> rest_;
};

void judge_status(const ident::Fit& fit, Verdict& verdict) {
  if (fit.status == ident::FitStatus::no_relevant_term) {
    verdict.against(Trust::no, "no term was selected");
  } else if (fit.status != ident::FitStatus::converged) {
    verdict.against(Trust::no, fmt::format("the fit ended as {}", to_string(fit.status)));
  }
}

void judge_residual(const JudgedFit& fit, Verdict& verdict) {
  const ident::Whiteness& whiteness = fit.whiteness;
  if (!whiteness.tested) {
    verdict.remark("whether the residual is white could not be tested");
    return;
  }
  const std::string statistic =
      fmt::format("Bartlett p = {:.2g}; the strongest 5 % of frequencies hold {:.0f} % of its power, 20 % if white",
                  whiteness.p_value, 100.0 * whiteness.peak_share);
  if (whiteness.white && whiteness.p_value < doubtful_p_value) {
    verdict.against(Trust::with_care, fmt::format("whether the residual is white is in doubt ({})", statistic));
    return;
  }
  if (whiteness.white) {
    verdict.remark(fmt::format("residual is white ({})", statistic));
    return;
  }
  double largest_ratio = 1.0;
  for (const ident::ModelTerm& term : fit.model.terms)
    if (term.std > 0.0 && std::isfinite(term.std_robust))
      largest_ratio = std::max(largest_ratio, term.std_robust / term.std);
  const bool negligible = fit.train.reason.empty() && fit.train.value <= negligible_nmse;
  verdict.against(negligible ? Trust::with_care : Trust::no,
                  fmt::format("residual is not white: structure remains ({})", statistic));
  verdict.against(Trust::with_care, fmt::format("standard deviations assume white noise; without that they are up to "
                                                "{:.2g} times larger, and terms may be kept "
                                                "that only mend the structure",
                                                largest_ratio));
}

void judge_predictions(const JudgedFit& fit, Verdict& verdict) {
  if (fit.train.reason.empty() && fit.test.reason.empty() && fit.test.value > negligible_nmse &&
      fit.test.value > carries_over * fit.train.value)
    verdict.against(Trust::no,
                    fmt::format("it does not carry over: NMSE {:.2g} on the test rows, {:.2g} on the training rows",
                                fit.test.value, fit.train.value));
  const ident::FreeRun& run = fit.free_run;
  if (run.diverged_after_s > 0.0) {
    verdict.against(Trust::no, "free run " + run.reason);
  } else if (!run.applies) {
    verdict.remark("no free run: " + run.reason);
  } else if (!run.reason.empty()) {
    verdict.against(Trust::with_care, "not confirmed by a free run: " + run.reason);
  } else if (run.nmse > useless_free_run) {
    verdict.against(Trust::no, fmt::format("free run does not follow x: NMSE {:.2g}", run.nmse));
  } else {
    verdict.remark(fmt::format("free run follows x: NMSE {:.2g}{}", run.nmse, run.sticks ? ", sticking at times" : ""));
  }
}

void judge_terms(const JudgedFit& fit, Verdict& verdict) {
  for (const std::string& remark : fit.fit.remarks) verdict.against(Trust::with_care, remark);
  if (fit.fit.condition_number > collinear)
    verdict.against(Trust::with_care, fmt::format("the kept columns are nearly collinear: condition number {:.2g}",
                                                  fit.fit.condition_number));
  std::vector<std::string> poor;
  for (const ident::ModelTerm& term : fit.model.terms)
    if (const double cov =
            std::max(term.std, std::isfinite(term.std_robust) ? term.std_robust : 0.0) / std::abs(term.mean);
        cov > poorly_known_cov)
      poor.push_back(fmt::format("{} (CoV {:.2g})", term.name, cov));
  if (!poor.empty()) verdict.against(Trust::with_care, fmt::format("poorly determined: {}", fmt::join(poor, ", ")));
  // With structure left in the residual, a term no larger than the residual may be there only to mend it.
  std::vector<std::string> small;
  for (const ident::ModelTerm& term : fit.model.terms)
    if (std::abs(term.mean) * term.scale < small_term * fit.model.noise_std) small.push_back(term.name);
  if (!small.empty() && fit.whiteness.tested && !fit.whiteness.white)
    verdict.against(Trust::with_care,
                    fmt::format("never larger than {:g} times the residual, so perhaps only mending it: {}", small_term,
                                fmt::join(small, ", ")));
}

}  // namespace

std::string_view to_string(Trust trust) {
  if (trust == Trust::yes) return "trusted";
  return trust == Trust::with_care ? "to be taken with care" : "not to be trusted";
}

Judgement judge(const JudgedFit& fit) {
  Verdict verdict;
  judge_status(fit.fit, verdict);
  if (!fit.model.terms.empty()) {
    judge_residual(fit, verdict);
    judge_predictions(fit, verdict);
    judge_terms(fit, verdict);
  }
  return verdict.finish();
}

std::vector<RangeDisagreement> compare_ranges(const std::vector<RangeResult>& ranges) {
  std::vector<RangeDisagreement> result;
  if (ranges.empty()) return result;
  for (std::size_t method = 0; method < ranges.front().fits.size(); ++method)
    for (std::size_t a = 0; a < ranges.size(); ++a)
      for (std::size_t b = a + 1; b < ranges.size(); ++b) {
        const std::string &name_a = ranges[a].spec.name, &name_b = ranges[b].spec.name;
        auto terms = ident::disagreements(ranges[a].fits[method].model, name_a, ranges[b].fits[method].model, name_b);
        if (!terms.empty())
          result.push_back(
              {std::string(to_string(ranges[a].fits[method].fit.method)), name_a, name_b, std::move(terms)});
      }
  return result;
}

}  // namespace apps
