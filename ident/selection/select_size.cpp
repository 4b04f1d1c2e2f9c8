#include "ident/selection/select_size.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace ident {
namespace {

using Eigen::Index;

constexpr Index largest_model = 60;  // candidates that are tried together: a path grows with the cube of its length

double threshold(double num_effective, Index num_terms) {
  return gain_threshold(Selection::evidence, -1.0, std::max<Index>(2, std::lround(num_effective)), num_terms);
}

/// Whether what a model leaves less than a smaller one is worth its further terms, both at this effective size.
bool outweighs(const Subset& larger, const Subset& smaller, const EffectiveSize& size, const RecordProblems& problems) {
  const double n = size.num_effective(), f = size.structural_fraction;
  const double each = 1.0 + (1.0 - f) * (problems.num_records() - 1.0);
  const auto cost = [&](const Subset& model) {
    return model_cost(n, problems.num_terms(), model.terms.size(), each, f);
  };
  const auto count = static_cast<double>(larger.terms.size());
  const double more = count - static_cast<double>(smaller.terms.size());
  const double gain =
      std::max(n - each * count, 0.0) * std::log(smaller.rss / std::max(larger.rss, rounding_power * rounding_power));
  return gain > std::max(least_gain * each * more, cost(larger) - cost(smaller));
}

}  // namespace

Settled select_size(const RecordProblems& problems, const SizeOfModel& size_of, double complete) {
  const std::vector<Subset> path = best_subsets(problems, std::min(problems.num_terms(), largest_model));
  std::vector<std::optional<EffectiveSize>> known(path.size());
  const auto size = [&](std::size_t l) -> const EffectiveSize& {
    if (!known[l]) known[l] = size_of(path[l]);
    return *known[l];
  };
  std::size_t settled = 0;
  for (std::size_t l = 1; l < path.size() && path[settled].rss > complete; ++l)
    if (outweighs(path[l], path[settled], size(l), problems)) settled = l;
  std::vector<ModelOfSize> compared;
  for (std::size_t l = 0; l < path.size(); ++l)
    compared.push_back({path[l].terms, path[l].rss, l == 0 ? 0.0 : size(l).num_effective()});
  return {path[settled], size(settled), std::move(compared)};
}

void prefer_simpler(Settled& settled, const RecordProblems& problems, const Eigen::VectorXd& degree) {
  const double spare = settled.size.num_effective() - static_cast<double>(settled.model.terms.size());
  if (spare < 2.0) return;
  const double limit = threshold(settled.size.num_effective(), problems.num_terms()), least = settled.model.rss;
  while (true) {
    std::optional<Subset> simpler;
    double most_saved = 0.0;
    for (const Index leaving : settled.model.terms) {
      Subset rest{settled.model.terms, 1.0};
      std::erase(rest.terms, leaving);
      rest.rss = least_squares_rss(problems, rest.terms);
      for (Index i = 0; i < problems.num_terms(); ++i) {
        const double saved = degree(leaving) - degree(i);
        if (!(saved > most_saved) || std::binary_search(settled.model.terms.begin(), settled.model.terms.end(), i))
          continue;
        Subset exchanged = rest;
        exchanged.terms.insert(std::upper_bound(exchanged.terms.begin(), exchanged.terms.end(), i), i);
        exchanged.rss = least_squares_rss(problems, exchanged.terms);
        if (!outweighs(exchanged, rest, settled.size, problems)) exchanged = rest;  // that one would do nothing
        if (spare * std::log(exchanged.rss / least) >= limit) continue;
        simpler = std::move(exchanged);
        most_saved = saved;
      }
    }
    if (!simpler) return;
    settled.model = std::move(*simpler);
  }
}

}  // namespace ident
