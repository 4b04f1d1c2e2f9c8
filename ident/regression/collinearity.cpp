#include "ident/regression/collinearity.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "dsp/values/linear.hpp"
#include "ident/regression/finish_fit.hpp"
#include "ident/regression/posterior.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double infinite = std::numeric_limits<double>::infinity();
// Two columns whose unit vectors differ by less are one column but for rounding of its values.
constexpr double same_column = 1e-12;
// More sentences of one kind than this help nobody.
constexpr std::size_t most_named = 5;
// Condition index from which a combination is worth a person's attention.
constexpr double remarkable_condition = 1e3;
// Signals further from zero than this many standard deviations make their powers one another's images.
constexpr double far_offset = 30.0;

NearDependence dependence(const std::vector<Index>& columns, const VectorXd& direction, double size) {
  // Weights below a tenth of the largest belong to other, weaker relations.
  const double smallest = 0.1 * direction.cwiseAbs().maxCoeff();
  std::vector<Index> order(static_cast<std::size_t>(direction.size()));
  std::iota(order.begin(), order.end(), Index{0});
  std::sort(order.begin(), order.end(),
            [&](Index a, Index b) { return std::abs(direction(a)) > std::abs(direction(b)); });
  NearDependence found;
  found.size = size;
  std::vector<double> weights;
  for (const Index j : order)
    if (std::abs(direction(j)) >= smallest) {
      found.terms.push_back(columns[static_cast<std::size_t>(j)]);
      weights.push_back(direction(j));
    }
  found.weights = Eigen::Map<const VectorXd>(weights.data(), static_cast<Index>(weights.size()));
  return found;
}

std::string where_measured(const std::vector<const Term*>& terms,
                           const std::vector<std::pair<std::string, double>>& largest) {
  std::vector<std::string> known;
  for (const auto& [signal, value] : largest)
    for (const Term* term : terms) {
      const auto& used = term->expression.signals();
      if (std::find(used.begin(), used.end(), signal) == used.end()) continue;
      known.push_back(fmt::format("largest |{}| {:.2g}", signal, value));
      break;
    }
  return fmt::format("{}", fmt::join(known, ", "));
}

std::string sentence(const NearDependence& found, const std::vector<const Term*>& all_terms, const Fit& fit,
                     const std::vector<std::pair<std::string, double>>& largest) {
  std::vector<const Term*> terms;
  std::vector<std::string> names, kept;
  for (const Index term : found.terms) {
    terms.push_back(all_terms[static_cast<std::size_t>(term)]);
    names.push_back(terms.back()->name);
    if (std::binary_search(fit.relevant.begin(), fit.relevant.end(), term)) kept.push_back(names.back());
  }
  const std::string last = names.back();
  names.pop_back();
  const std::string all = fmt::format("{} and {}", fmt::join(names, ", "), last);
  if (names.size() == 1 && found.size <= same_column)
    return fmt::format("{} are proportional on these data; {} was kept", all,
                       kept.empty() ? "neither" : fmt::format("{}", fmt::join(kept, " and ")));
  const std::string where = where_measured(terms, largest);
  return fmt::format("{} are nearly dependent on these data{}: they differ by one part in {:.2g}", all,
                     where.empty() ? "" : " (" + where + ")", 1.0 / std::max(found.size, same_column));
}

std::string sentence(const Rival& rival, const std::vector<const Term*>& terms,
                     const std::vector<std::pair<std::string, double>>& largest) {
  const auto [first, second] = std::minmax(rival.kept, rival.other);  // as in the library
  const std::vector<const Term*> pair{terms[static_cast<std::size_t>(first)], terms[static_cast<std::size_t>(second)]};
  const std::string where = where_measured(pair, largest);
  return fmt::format("{} and {} cannot be distinguished here{}; the exchange {} {:.2g} of 2 log evidence",
                     pair[0]->name, pair[1]->name, where.empty() ? "" : ": " + where,
                     rival.evidence_lost < 0.0 ? "gains" : "costs", std::abs(rival.evidence_lost));
}

/// Of each kept term the strongest rival.
std::vector<Rival> best_exchanges(const std::vector<Rival>& strongest_first) {
  std::vector<Rival> best;
  for (const Rival& rival : strongest_first)
    if (std::none_of(best.begin(), best.end(), [&](const Rival& known) { return known.kept == rival.kept; }))
      best.push_back(rival);
  return best;
}

bool is_pair(const NearDependence& near, const Rival& rival) {
  const std::array pair{rival.kept, rival.other};
  return std::is_permutation(near.terms.begin(), near.terms.end(), pair.begin(), pair.end());
}

// |mean| / standard deviation of a column beside the constant one: cotangent of the angle between them.
double offset_of(const UnitProblem& problem, Index constant, Index column) {
  const double cosine = std::abs(problem.A.col(constant).dot(problem.A.col(column)));
  const double sine =
      (problem.A.col(column) - problem.A.col(constant) * problem.A.col(constant).dot(problem.A.col(column))).norm();
  return sine > 0.0 ? cosine / sine : infinite;
}

}  // namespace

Collinearity collinearity(const RFactor& data, double limit, const Poll& poll) {
  const UnitProblem problem = unit_problem(data, poll);
  Collinearity result;
  result.inflation = VectorXd::Ones(problem.num_terms());
  for (Index i = 0; i < problem.num_terms(); ++i)
    if (problem.column_norm(i) == 0.0) result.zero_columns.push_back(i);
  const std::vector<Index> columns = usable_terms(problem);
  if (columns.empty()) return result;

  const auto [s, axes] = dsp::right_singular(triangle(problem.A(Eigen::all, columns)));
  const Index last = s.size() - 1;
  result.condition_number = s(last) > 0.0 ? s(0) / s(last) : infinite;
  const Posterior at = posterior(problem, columns, VectorXd::Constant(static_cast<Index>(columns.size()), flat_lambda));
  for (const Index i : columns) result.inflation(i) = at.sparsity(i) > 0.0 ? 1.0 / at.sparsity(i) : infinite;
  for (Index k = last; k > 0 && s(k) * limit < s(0); --k)
    result.dependences.push_back(dependence(columns, axes.col(k), s(k)));
  return result;
}

std::vector<Rival> rivals(const RFactor& data, const Fit& fit, double limit, const Poll& poll) {
  const UnitProblem problem = unit_problem(data, poll);
  const double noise = fit.noise_variance / (problem.target_norm(0) * problem.target_norm(0));
  std::vector<Rival> found;
  if (!(noise > 0.0) || !std::isfinite(noise)) return found;
  // q of a term given kept ones: of it the evidence of the two models differs by q - 1 - log q.
  const auto gain = [&](const Posterior& at, Index term) {
    return at.sparsity(term) > 0.0 ? evidence_gain(at.quality(term) * at.quality(term) / at.sparsity(term) / noise)
                                   : 0.0;
  };
  for (std::size_t j = 0; j < fit.relevant.size(); ++j) {
    std::vector<Index> others = fit.relevant;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(j));
    const Posterior without =
        posterior(problem, others, VectorXd::Constant(static_cast<Index>(others.size()), flat_lambda));
    const double own = gain(without, fit.relevant[j]);
    for (Index i = 0; i < problem.num_terms(); ++i) {
      if (problem.column_norm(i) == 0.0 || std::find(fit.relevant.begin(), fit.relevant.end(), i) != fit.relevant.end())
        continue;
      const double lost = own - gain(without, i);
      if (lost < limit && gain(without, i) > 0.0) found.push_back({fit.relevant[j], i, lost});
    }
  }
  std::sort(found.begin(), found.end(),
            [](const Rival& a, const Rival& b) { return a.evidence_lost < b.evidence_lost; });
  return found;
}

std::vector<std::string> collinearity_remarks(const RFactor& data, const Fit& fit,
                                              const std::vector<const Term*>& terms,
                                              const std::vector<std::pair<std::string, double>>& largest,
                                              const Poll& poll) {
  std::vector<std::string> remarks;
  const UnitProblem problem = unit_problem(data);
  const auto name = [&](Index column) { return terms[static_cast<std::size_t>(column)]->name; };
  const auto is_kept = [&](Index column) {
    return std::binary_search(fit.relevant.begin(), fit.relevant.end(), column);
  };
  const auto constant = std::find_if(terms.begin(), terms.end(), [](const Term* term) { return term->name == "1"; });
  for (Index i = 0; constant != terms.end() && i < problem.num_terms(); ++i) {
    const Term& term = *terms[static_cast<std::size_t>(i)];
    const bool a_signal = term.expression.signals() == std::vector<std::string>{term.name};
    const double offset = a_signal ? offset_of(problem, constant - terms.begin(), i) : 0.0;
    if (offset > far_offset)
      remarks.push_back(
          fmt::format("{} lies {:.3g} of its standard deviations from zero, which makes its powers nearly dependent: "
                      "subtract its mean",
                      term.name, offset));
  }
  Collinearity found = collinearity(data, remarkable_condition, poll);
  for (const Index column : found.zero_columns)
    remarks.push_back(name(column) + " is zero throughout and was left out");
  const std::vector<Rival> exchanges = best_exchanges(rivals(data, fit, undecided_evidence, poll));
  std::erase_if(found.dependences, [&](const NearDependence& near) {
    if (near.size <= same_column) return false;
    return std::none_of(near.terms.begin(), near.terms.end(), is_kept) ||
           std::any_of(exchanges.begin(), exchanges.end(), [&](const Rival& rival) { return is_pair(near, rival); });
  });
  for (std::size_t i = 0; i < std::min(most_named, found.dependences.size()); ++i)
    remarks.push_back(sentence(found.dependences[i], terms, fit, largest));
  if (found.dependences.size() > most_named)
    remarks.push_back(fmt::format("{} more combinations of terms are nearly dependent; condition number {:.2g}",
                                  found.dependences.size() - most_named, found.condition_number));
  for (std::size_t i = 0; i < std::min(most_named, exchanges.size()); ++i)
    remarks.push_back(sentence(exchanges[i], terms, largest));
  if (exchanges.size() > most_named)
    remarks.push_back(
        fmt::format("{} more kept terms cannot be distinguished from one left out", exchanges.size() - most_named));
  return remarks;
}

}  // namespace ident
