#pragma once
#include <vector>

#include "ident/state_space/smoother.hpp"

namespace ident::state_space {

struct FitOptions {
  std::vector<double> coefficients = {};  ///< to begin with, as Layout has them; empty: zero, which does as well
  std::vector<int> terms = {};            ///< coefficients to be sought, the others held at zero; empty: all
  /// States to begin with that channels do not give: the last columns of those of the equations, for each record;
  /// empty: zero.
  std::vector<Eigen::MatrixXd> last_states = {};
  int num_threads = 1;
  int most_linearised = 250;  ///< then it does not come to rest: a search that does takes 40 to 200
};

/// Of a wander's step, as a fraction of the noise of a sample: it is none.
inline constexpr double least_wander = 1e-3;

/// What a fit came to.
struct Fit {
  std::vector<int> parameters;     ///< those sought, ascending, as Layout has them
  Point point;                     ///< states include those of AC couplings and wanders
  std::vector<double> covariance;  ///< of the sought, row after row
  std::vector<double> scattered;   ///< the same by scatter_covariance; empty where process noise lowers J by nothing
  Noise noise;
  std::vector<double> floors;        ///< of each channel: noise_std, or what its spectrum ends in
  std::vector<double> residual_std;  ///< of each channel: recorded less computed from the smoothed states
  double J = 0.0;                    ///< -2 log likelihood, up to a constant of the problem
  /// By how much process noise lowers J with the parameters integrated out: what the equation does not explain. 0 where
  /// it does not.
  double gain_of_process_noise = 0.0;
  int parts = 1;          ///< steps a sample
  bool settled = false;   ///< the iterations came to rest
  bool at_floor = false;  ///< no channel's residual exceeds its floor by more than that is uncertain
  /// Whether coefficients and covariance may be shown.
  [[nodiscard]] bool converged() const { return settled && at_floor; }
  /// Standard deviation of the i-th of `parameters`.
  [[nodiscard]] double std(std::size_t i) const;
  /// `covariance` with each standard deviation the larger of its own and that of `scattered`.
  [[nodiscard]] std::vector<double> wider() const;
};

/// Coefficients, states, output parameters, process and channel noise of most likelihood: from soft to hard (steps of
/// large process noise that shrinks), the noise estimated from a soft stage and from the hard end, the better kept;
/// where process noise remains, with the gradient of the log-determinant. Same bits on any number of threads.
/// Throws as Linearisation; std::invalid_argument for coefficients or terms that do not fit.
[[nodiscard]] Fit fit(const Problem& problem, const FitOptions& options);

}  // namespace ident::state_space
