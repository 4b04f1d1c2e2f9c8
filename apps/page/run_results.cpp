#include "apps/page/run_results.hpp"

#include <algorithm>
#include <cmath>

#include "ident/sensors/absolute_gains.hpp"

namespace apps {

ChosenEquation chosen_equation(const std::vector<ident::RangeResult>& ranges) {
  const std::optional<ident::ChosenFit> chosen = ident::chosen_fit(ranges);
  if (!chosen) return {};
  const ident::JudgedFit& fit = ranges[chosen->range].fits[chosen->method];
  return fit.model.terms.empty() ? ChosenEquation{} : ChosenEquation{&ranges[chosen->range], &fit};
}

ChosenEquation chosen_equation(const ident::RangeResult& range) {
  if (range.fits.empty()) return {};
  const ident::JudgedFit& fit = range.fits[ident::chosen_method(range)];
  return fit.model.terms.empty() ? ChosenEquation{} : ChosenEquation{&range, &fit};
}

double largest_displacement(const ident::RangeResult& range, const std::vector<ident::Columns>& columns) {
  double largest = 0.0;
  for (const ident::Row& row : range.rows.train)
    if (const dsp::Signal* x = columns[row.recording].signals->find("x"))
      if (const double size = std::abs(x->values(row.sample)); std::isfinite(size)) largest = std::max(largest, size);
  return largest;
}

bool base_at_rest(const dsp::Motion& signals) {
  return signals.find("y") != nullptr && signals.find("r") == nullptr && signals.find("dr") == nullptr &&
         signals.find("ddr") == nullptr;
}

std::vector<PhysicalTerm> physical_terms(const ChosenEquation& chosen, const RunResults& results) {
  const dsp::Prepared& prepared = results.inputs[chosen.range->rows.train.front().recording].prepared;
  const dsp::Signal* x = prepared.signals.find("x");
  if (x == nullptr) return {};
  const ident::Model& model = chosen.fit->model;
  return physical_terms(
      model, si_covariance(model, ident::absolute_gains(prepared)),
      {largest_displacement(*chosen.range, results.columns), x->unit, base_at_rest(prepared.signals)});
}

const char* in_words(ident::Verdict verdict) {
  switch (verdict) {
    case ident::Verdict::describes:
      return "describes";
    case ident::Verdict::in_part:
      return "describes in part";
    case ident::Verdict::does_not:
      return "does not describe";
    case ident::Verdict::undecided:
      break;
  }
  return "undecided";
}

const char* in_words(ident::FitStatus status) {
  switch (status) {
    case ident::FitStatus::converged:
      return "converged";
    case ident::FitStatus::iteration_limit:
      return "stopped at its limit of iterations";
    case ident::FitStatus::no_relevant_term:
      return "no term explains more than noise";
    case ident::FitStatus::rank_deficient:
      return "candidate terms that depend on one another";
    case ident::FitStatus::too_few_rows:
      return "too few samples for the terms";
    case ident::FitStatus::zero_target:
      break;
  }
  return "the target is zero throughout";
}

}  // namespace apps
