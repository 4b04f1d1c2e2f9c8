#include "ident/selection/record_coefficients.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "ident/selection/select_size.hpp"
#include "ident/selection/term_sets.hpp"

namespace ident {
namespace {

using Eigen::Index;

double log_rss(const RecordProblems& problems, const RecordCoefficients& model) {
  return std::log(std::max(shared_rss(problems, model.common(), model.differing), rounding_power * rounding_power));
}

/// The terms as given, with what of them is common.
RecordCoefficients shared(const RecordProblems& problems, const std::vector<Index>& terms, double n) {
  const double each =
      (problems.num_records() - 1.0) * std::log(n) + 2.0 * std::log(std::max(1.0, static_cast<double>(terms.size())));
  const auto score = [&](const RecordCoefficients& model) {
    return n * log_rss(problems, model) + each * static_cast<double>(model.differing.size());
  };
  RecordCoefficients at{terms, terms}, best = at;
  double least = score(at);
  while (!at.differing.empty()) {
    RecordCoefficients cheapest;
    double lowest = std::numeric_limits<double>::infinity();
    for (const Index term : at.differing) {
      RecordCoefficients next{terms, without(at.differing, term)};
      if (const double left = log_rss(problems, next); !(left >= lowest)) lowest = left, cheapest = std::move(next);
    }
    at = std::move(cheapest);
    if (const double here = score(at); here < least) least = here, best = at;
  }
  return best;
}

/// With the left-out candidate that is worth a common coefficient, if there is one.
bool add_common(const RecordProblems& problems, RecordCoefficients& model, double n) {
  const Index b = problems.num_terms();
  const std::size_t k = model.terms.size();
  const double before = log_rss(problems, model);
  double most = gain_threshold(Selection::evidence, -1.0, std::max<Index>(2, std::lround(n)), b);
  Index best = -1;
  for (Index i = 0; i < b; ++i) {
    if (std::binary_search(model.terms.begin(), model.terms.end(), i)) continue;
    const double left = log_rss(problems, {with(model.terms, i), model.differing});
    const double gain = std::max(n - static_cast<double>(k) - 1.0, 0.0) * (before - left);
    if (gain > most) most = gain, best = i;
  }
  if (best < 0) return false;
  model.terms = with(std::move(model.terms), best);
  return true;
}

}  // namespace

std::vector<Index> RecordCoefficients::common() const {
  std::vector<Index> result;
  std::set_difference(terms.begin(), terms.end(), differing.begin(), differing.end(), std::back_inserter(result));
  return result;
}

double effective_rows_for_terms(const EffectiveSize& size) {
  constexpr double by_noise = 0.5;
  const double n = size.num_effective(), known = std::min(size.num_uncorrelated, size.num_states);
  return n >= by_noise * size.num_rows || !(known > 0.0) ? n : std::min(n, known);
}

RecordCoefficients record_coefficients(const RecordProblems& problems, const std::vector<Index>& terms,
                                       const EffectiveSize& size) {
  const double n = std::max(2.0, size.num_effective()), beyond_misfit = std::max(2.0, effective_rows_for_terms(size));
  RecordCoefficients found = shared(problems, terms, n);
  while (add_common(problems, found, beyond_misfit)) found = shared(problems, found.terms, n);
  return found;
}

}  // namespace ident
