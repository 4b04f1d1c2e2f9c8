#pragma once
#include <Eigen/Core>
#include <functional>
#include <vector>

#include "ident/selection/best_subsets.hpp"
#include "ident/selection/effective_size.hpp"

namespace ident {

/// What a term must gain in twice the log evidence however likely it was beforehand: what it costs in prediction.
inline constexpr double least_gain = 2.0;
/// Power of a residual, as a fraction of the target's, that is rounding of sums over up to 1e6 rows, not structure.
inline constexpr double rounding_power = 1e-24;
/// Power of a residual, as a fraction of the target's, that the filters of a preparation leave: what folds into their
/// pass band, or past the ends of a record, lies 110 dB below what they let through.
inline constexpr double filtered_power = 1e-11;

/// What the rows are worth beside a model.
using SizeOfModel = std::function<EffectiveSize(const Subset&)>;

/// The model that is settled on, its size, and what was compared.
struct Settled {
  Subset model;
  EffectiveSize size;
  std::vector<ModelOfSize> path;
};

/// Forward selection over model sizes, with coefficients of each record: a larger model must gain more,
/// (n_eff - k') ln(rss / rss'), than its price (model_cost) rises, at the effective size of the larger model. Noise
/// tells the coefficients of R records apart, so that a term costs as R of them; misfit that is a function of the state
/// comes back in every record, and a term that answers it counts once: a term is 1 + (1 - f) (R - 1) coefficients. What
/// leaves no more than `complete` of the target's power has nothing left to explain.
[[nodiscard]] Settled select_size(const RecordProblems& problems, const SizeOfModel& size_of,
                                  double complete = rounding_power);

/// Exchanges single terms for simpler ones while the two models cannot be told apart; where the simpler one would not
/// be worth its place, the term is left out. `degree`: of each candidate.
void prefer_simpler(Settled& settled, const RecordProblems& problems, const Eigen::VectorXd& degree);

}  // namespace ident
