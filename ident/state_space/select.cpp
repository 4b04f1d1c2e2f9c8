#include "ident/state_space/select.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "ident/state_space/fitter.hpp"

namespace ident::state_space {
namespace {

using std::size_t;
using Terms = std::vector<int>;

Terms with(Terms terms, int term) {
  terms.insert(std::lower_bound(terms.begin(), terms.end(), term), term);
  return terms;
}
Terms without(Terms terms, int term) {
  std::erase(terms, term);
  return terms;
}
bool has(const Terms& terms, int term) {
  return std::find(terms.begin(), terms.end(), term) != terms.end();
}

/// The quadratic cost of subsets, from the triangle of a problem with all terms freed.
class Subsets {
 public:
  explicit Subsets(Fitter& fitter) : triangle_(fitter.freed()), num_coefficients_(fitter.layout().num_coefficients) {
    if (fitter.gradient().empty()) return;
    for (const int i : fitter.all_parameters()) linear_.push_back(fitter.gradient()[static_cast<size_t>(i)]);
  }
  [[nodiscard]] double cost(const Terms& terms) const {
    const Terms columns = columns_of(terms);
    const Triangle part = triangle_.only(columns);
    return part.value(part.solve(linear_of(columns)), linear_of(columns));
  }
  /// Of all parameters; zero for terms that are not among these.
  [[nodiscard]] std::vector<double> values(const Terms& terms) const {
    const Terms columns = columns_of(terms);
    const std::vector<double> found = triangle_.only(columns).solve(linear_of(columns));
    std::vector<double> all(static_cast<size_t>(triangle_.columns()), 0.0);
    for (size_t j = 0; j < columns.size(); ++j) all[static_cast<size_t>(columns[j])] = found[j];
    return all;
  }

 private:
  /// These terms and all parameters of outputs, which stand behind the coefficients.
  [[nodiscard]] Terms columns_of(Terms terms) const {
    for (int i = num_coefficients_; i < triangle_.columns(); ++i) terms.push_back(i);
    return terms;
  }
  [[nodiscard]] std::vector<double> linear_of(const Terms& columns) const {
    std::vector<double> part;
    if (!linear_.empty())
      for (const int i : columns) part.push_back(linear_[static_cast<size_t>(i)]);
    return part;
  }
  Triangle triangle_;
  int num_coefficients_;
  std::vector<double> linear_;
};

/// From these terms to those that no removal, addition or exchange of one makes more likely.
Terms best_near(const Subsets& subsets, Terms terms, const Terms& allowed, double price) {
  const auto score = [&](const Terms& some) { return subsets.cost(some) + price * static_cast<double>(some.size()); };
  double best = score(terms);
  while (true) {
    Terms next = terms;
    const auto consider = [&](const Terms& some) {
      if (const double one = score(some); one < best) best = one, next = some;
    };
    for (const int out : terms) consider(without(terms, out));
    for (const int in : allowed) {
      if (has(terms, in)) continue;
      consider(with(terms, in));
      for (const int out : terms) consider(with(without(terms, out), in));
    }
    if (next == terms) return terms;
    terms = next;
  }
}

double num_recorded(const Problem& problem) {
  double count = 0.0;
  for (const Record& record : problem.records) count += static_cast<double>((!record.channels.array().isNaN()).count());
  return count;
}

std::vector<Score> scores_of(const Subsets& subsets, const Terms& terms, int num_coefficients, double price) {
  std::vector<Score> scores;
  const double cost = subsets.cost(terms);
  for (int i = 0; i < num_coefficients; ++i) {
    const double gain = has(terms, i) ? subsets.cost(without(terms, i)) - cost : cost - subsets.cost(with(terms, i));
    scores.push_back({gain, 1.0 / (1.0 + std::exp(0.5 * (price - gain)))});
  }
  return scores;
}

}  // namespace

Selection select(const Problem& problem, const SelectOptions& options) {
  constexpr int most_rounds = 20;
  constexpr double curved = 50.0;  // -2 log likelihood beyond what the linear problem foretold
  Fitter fitter(problem, options.fit.num_threads);
  const int num_coefficients = fitter.layout().num_coefficients;
  Terms allowed(static_cast<size_t>(num_coefficients));
  std::iota(allowed.begin(), allowed.end(), 0);
  std::erase_if(allowed, [&](int term) { return has(options.barred, term); });
  Terms terms = options.fit.terms.empty() ? allowed : options.fit.terms;
  std::sort(terms.begin(), terms.end());
  fitter.seek(terms);
  fitter.begin(options.fit.coefficients);
  fitter.settle();

  Selection selection{.price = std::log(num_recorded(problem)) + 2.0 * std::log(static_cast<double>(allowed.size()))};
  if (!fitter.is_finite()) {
    selection.fit = fitter.result();
    selection.scores.resize(static_cast<size_t>(num_coefficients));
    return selection;
  }
  std::map<Terms, double> visited{{terms, fitter.J() + selection.price * static_cast<double>(terms.size())}};
  for (int round = 0; round < most_rounds; ++round) {
    const Subsets subsets(fitter);
    const Terms next = best_near(subsets, terms, allowed, selection.price);
    selection.settled = next == terms;
    if (selection.settled || visited.contains(next)) break;
    const double rise = subsets.cost(next) - subsets.cost(terms), before = fitter.J();
    fitter.move_to(next, subsets.values(next));
    if (!fitter.refit() || fitter.J() > before + 3.0 * std::max(rise, 0.0) + curved) (void)fitter.refit_softly();
    terms = next;
    visited[terms] = fitter.J() + selection.price * static_cast<double>(terms.size());
  }
  const auto best = std::min_element(visited.begin(), visited.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  if (best->first != terms) {
    terms = best->first;
    fitter.move_to(terms, Subsets(fitter).values(terms));
    (void)fitter.refit();
  }
  fitter.settle_again();
  selection.fit = fitter.result();
  selection.scores = scores_of(Subsets(fitter), terms, num_coefficients, selection.price);
  return selection;
}

}  // namespace ident::state_space
