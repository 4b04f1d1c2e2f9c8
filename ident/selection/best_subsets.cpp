#include "ident/selection/best_subsets.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ident/selection/term_sets.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Least squares on some terms, and by how much the rest falls or grows with one more or one less.
struct LeastSquares {
  const RecordProblems& problems;
  std::vector<Posterior> at;  // of each record
  double rss = 0.0;
  LeastSquares(const RecordProblems& given, const std::vector<Index>& terms) : problems(given) {
    const VectorXd lambda = VectorXd::Constant(static_cast<Index>(terms.size()), flat_lambda);
    for (std::size_t r = 0; r < problems.records.size(); ++r) {
      at.push_back(posterior(problems.records[r], terms, lambda));
      rss += problems.weight(static_cast<Index>(r)) * at.back().residual(0, 0);
    }
  }
  [[nodiscard]] bool is_independent(std::size_t record, Index term) const {
    return at[record].sparsity(term) > smallest_sparsity(problems.records[record]);
  }
  [[nodiscard]] bool is_independent(Index term) const {
    for (std::size_t r = 0; r < at.size(); ++r)
      if (is_independent(r, term)) return true;
    return false;
  }
  [[nodiscard]] double change(Index term) const {
    double sum = 0.0;
    for (std::size_t r = 0; r < at.size(); ++r)
      if (is_independent(r, term))
        sum +=
            problems.weight(static_cast<Index>(r)) * (at[r].quality(term) * at[r].quality(term) / at[r].sparsity(term));
    return sum;
  }
};

bool holds(const std::vector<Index>& terms, Index term) {
  return std::binary_search(terms.begin(), terms.end(), term);
}

// The left-out term that takes most of the rest away, and how much; -1: none is independent.
std::pair<Index, double> best_addition(const RecordProblems& problems, const std::vector<Index>& terms,
                                       const LeastSquares& fit) {
  std::pair<Index, double> best{-1, 0.0};
  for (Index i = 0; i < problems.num_terms(); ++i)
    if (!holds(terms, i) && fit.is_independent(i) && (best.first < 0 || fit.change(i) > best.second))
      best = {i, fit.change(i)};
  return best;
}

// Exchanges one term for another while the rest falls by it.
void exchange(const RecordProblems& problems, Subset& subset) {
  constexpr double rounding = 1e-9;  // of the rest, that an exchange must beat
  for (bool moved = true; moved;) {
    moved = false;
    for (const Index leaving : std::vector<Index>(subset.terms)) {
      const std::vector<Index> rest = without(subset.terms, leaving);
      const LeastSquares fit(problems, rest);
      const auto [term, gain] = best_addition(problems, rest, fit);
      if (term < 0 || term == leaving || fit.rss - gain >= (1.0 - rounding) * subset.rss) continue;
      subset = {with(rest, term), fit.rss - gain};
      moved = true;
    }
  }
  subset.rss = LeastSquares(problems, subset.terms).rss;
}

// These terms, one at least, less the one without which least leaves.
Subset without_weakest(const RecordProblems& problems, const std::vector<Index>& terms) {
  const LeastSquares fit(problems, terms);
  const Index weakest =
      *std::min_element(terms.begin(), terms.end(), [&](Index a, Index b) { return fit.change(a) < fit.change(b); });
  return {without(terms, weakest), fit.rss + fit.change(weakest)};
}

}  // namespace

double least_squares_rss(const RecordProblems& problems, const std::vector<Index>& terms) {
  return LeastSquares(problems, terms).rss;
}

std::vector<Subset> best_subsets(const RecordProblems& problems, Index largest) {
  std::vector<Subset> best{Subset{}};
  for (Index size = 1; size <= largest; ++size) {
    const std::vector<Index>& terms = best.back().terms;
    const Index term = best_addition(problems, terms, {problems, terms}).first;
    if (term < 0) break;
    Subset next{with(terms, term), 1.0};
    next.rss = LeastSquares(problems, next.terms).rss;
    exchange(problems, next);
    best.push_back(std::move(next));
  }
  for (std::size_t size = best.size() - 1; size-- > 1;) {
    Subset next = without_weakest(problems, best[size + 1].terms);
    if (next.terms == best[size].terms) continue;
    exchange(problems, next);
    if (next.rss < best[size].rss) best[size] = std::move(next);
  }
  return best;
}

double model_cost(double num_effective, Index num_terms, std::size_t k, double coefficients,
                  double structural_fraction) {
  const auto b = static_cast<double>(num_terms), count = static_cast<double>(k);
  const double models = std::lgamma(b + 1.0) - std::lgamma(count + 1.0) - std::lgamma(b - count + 1.0);
  const double of_noise = count * std::log(b);
  return count * coefficients * std::log(std::max(2.0, num_effective)) +
         2.0 * (structural_fraction * models + (1.0 - structural_fraction) * of_noise);
}

}  // namespace ident
