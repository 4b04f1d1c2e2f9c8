#include "ident/selection/settled_model.hpp"

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

}  // namespace

Settled settled_model(const RecordProblems& problems, const SizeOfModel& size_of) {
  const Index num_terms = problems.num_terms();
  const std::vector<Subset> path = best_subsets(problems, std::min(num_terms, largest_model));
  std::vector<std::optional<EffectiveSize>> known(path.size());
  const auto size = [&](std::size_t l) -> const EffectiveSize& {
    if (!known[l]) known[l] = size_of(path[l]);
    return *known[l];
  };
  std::size_t settled = 0;
  for (std::size_t l = 1; l < path.size(); ++l) {
    const double n = size(l).num_effective(), more = static_cast<double>(l - settled);
    const double each = 1.0 + (1.0 - size(l).structural_fraction) * (problems.num_records() - 1.0);
    const double gain = std::max(n - each * static_cast<double>(l), 0.0) *
                        std::log(path[settled].rss / std::max(path[l].rss, rounding_power * rounding_power));
    if (gain >
        std::max(least_gain * each * more, model_cost(n, num_terms, l, each) - model_cost(n, num_terms, settled, each)))
      settled = l;
  }
  std::vector<ModelOfSize> compared;
  for (std::size_t l = 0; l < path.size(); ++l)
    compared.push_back({path[l].terms, path[l].rss, l == 0 ? 0.0 : size(l).num_effective()});
  return {path[settled], size(settled), std::move(compared)};
}

void prefer_simpler(Settled& settled, const RecordProblems& problems, const Eigen::VectorXd& complexity) {
  const double spare = settled.size.num_effective() - static_cast<double>(settled.model.terms.size());
  if (spare < 2.0) return;
  const double limit = threshold(settled.size.num_effective(), problems.num_terms()), least = settled.model.rss;
  while (true) {
    std::optional<Subset> simpler;
    double most_saved = 0.0;
    for (const Index leaving : settled.model.terms)
      for (Index i = 0; i < problems.num_terms(); ++i) {
        const double saved = complexity(leaving) - complexity(i);
        if (!(saved > most_saved) || std::binary_search(settled.model.terms.begin(), settled.model.terms.end(), i))
          continue;
        std::vector<Index> exchanged = settled.model.terms;
        std::replace(exchanged.begin(), exchanged.end(), leaving, i);
        std::sort(exchanged.begin(), exchanged.end());
        const double rss = least_squares_rss(problems, exchanged);
        if (spare * std::log(rss / least) >= limit) continue;
        simpler = Subset{std::move(exchanged), rss};
        most_saved = saved;
      }
    if (!simpler) return;
    settled.model = std::move(*simpler);
  }
}

}  // namespace ident
