#include "apps/paper/printed_equation.hpp"

#include <algorithm>
#include <cmath>

#include "apps/paper/paper_tables.hpp"
#include "ident/fit.hpp"

namespace apps {

using Eigen::Index;

Index column_of(const Section4Study& study, const char* term) {
  const auto& terms = study.library.terms;
  return std::find_if(terms.begin(), terms.end(), [&](const auto& known) { return known.name == term; }) -
         terms.begin();
}

Index PrintedRow::position_of(Index term) const {
  return std::find(terms.begin(), terms.end(), term) - terms.begin();
}

PrintedRow printed_row(const Section4Study& study, const Section4Regression& regression, const Section4Row& row,
                       const std::string& method) {
  PrintedRow result;
  std::vector<double> printed;
  for (const PaperTerm& term : paper_terms())
    if (term.table == study.definition->table && term.row == row.row && row.where == term.where &&
        std::isfinite(term.printed(method))) {
      result.terms.push_back(column_of(study, term.term));
      printed.push_back(term.printed(method));
    }
  result.printed = Eigen::Map<const Eigen::VectorXd>(printed.data(), std::ssize(printed));
  if (row.truth_known)
    result.expected = row.truth(result.terms);
  else
    result.expected = ident::fit_ols(ident::r_factor(regression.phi(Eigen::all, result.terms), row.values)).mean;
  result.root = unit_root(regression, result.terms) * stated_noise * row.std;
  return result;
}

}  // namespace apps
