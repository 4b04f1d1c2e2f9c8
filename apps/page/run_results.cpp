#include "apps/page/run_results.hpp"

#include <algorithm>
#include <cmath>

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

const char* in_words(ident::Verdict verdict) {
  switch (verdict) {
    case ident::Verdict::describes:
      return "describes its range";
    case ident::Verdict::in_part:
      return "describes its range in part";
    case ident::Verdict::does_not:
      return "does not describe its range";
    case ident::Verdict::undecided:
      break;
  }
  return "undecided";
}

}  // namespace apps
