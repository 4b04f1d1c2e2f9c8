#include "apps/output/fit_outcome.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace apps {

int outcome_of(const std::vector<ident::JudgedFit>& fits, const std::string& place, Console& console) {
  const auto undetermined = [](const ident::JudgedFit& fit) {
    return fit.fit.status == ident::FitStatus::too_few_rows || fit.fit.status == ident::FitStatus::rank_deficient;
  };
  if (std::any_of(fits.begin(), fits.end(),
                  [&](const ident::JudgedFit& fit) { return !fit.model.terms.empty() && !undetermined(fit); }))
    return 0;
  std::vector<std::string> ends;
  for (const ident::JudgedFit& fit : fits)
    if (undetermined(fit))
      ends.push_back(fmt::format("{} ended as {}", to_string(fit.fit.method), to_string(fit.fit.status)));
  if (ends.empty())
    console.error(
        "fit.nothing_selected",
        fmt::format("{}: no method selected a term. Give other candidates, or lower tau or the threshold.", place));
  else
    console.error("fit.not_determined",
                  fmt::format("{}: the rows do not determine the coefficients ({}). Give more rows or fewer terms, or "
                              "add the method ridge, which takes the smallest that do.",
                              place, fmt::join(ends, ", ")));
  return 4;
}

}  // namespace apps
