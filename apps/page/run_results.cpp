#include "apps/page/run_results.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

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

bool base_at_rest(const dsp::Motion& signals) {
  return signals.find("y") != nullptr && signals.find("r") == nullptr && signals.find("dr") == nullptr &&
         signals.find("ddr") == nullptr;
}

std::vector<PhysicalTerm> physical_terms(const ChosenEquation& chosen, const RunResults& results) {
  const dsp::Prepared& prepared = results.inputs[chosen.range->rows.train.front().recording].prepared;
  const dsp::Signal* x = prepared.signals.find("x");
  if (x == nullptr || chosen.range->orbit || chosen.fit->judgement.cause == ident::Cause::imposed_motion) return {};
  const ident::Model& model = chosen.fit->model;
  PhysicalContext context{.x_unit = x->unit, .base_at_rest = base_at_rest(prepared.signals)};
  for (const ident::Extent& extent : model.extents)
    if (extent.signal == "x") context.lowest = extent.lowest, context.highest = extent.highest;
  if (!differs_by_recording(model)) return physical_terms(model, context);
  std::vector<PhysicalTerm> terms;
  std::vector<std::size_t> of_recording;
  const auto same = [&](const PhysicalTerm& one, const PhysicalTerm& other) {
    constexpr double rounding = 1e-9;
    return one.name == other.name && std::abs(one.value - other.value) <= rounding * std::abs(one.value);
  };
  for (std::size_t r = 0; r < results.inputs.size(); ++r) {
    if (!std::any_of(chosen.range->rows.train.begin(), chosen.range->rows.train.end(),
                     [&](const ident::Row& row) { return row.recording == r; }))
      continue;
    for (PhysicalTerm& term : physical_terms(ident::equation_of(model, static_cast<int>(r) + 1), context))
      if (std::none_of(terms.begin(), terms.end(), [&](const PhysicalTerm& known) { return same(known, term); }))
        terms.push_back(std::move(term)), of_recording.push_back(r);
  }
  std::vector<PhysicalTerm> named = terms;
  for (std::size_t i = 0; i < terms.size(); ++i)
    if (std::count_if(terms.begin(), terms.end(), [&](const auto& other) { return other.name == terms[i].name; }) > 1)
      named[i].name += " in " + results.inputs[of_recording[i]].prepared.name;
  return named;
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
