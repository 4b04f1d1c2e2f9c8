#pragma once
#include <optional>
#include <vector>

#include "ident/state_space/linear.hpp"

namespace ident::state_space {

/// Equations that run on their own from the first sample of each record, driven by its inputs.
struct OutputErrorOptions {
  std::vector<double> coefficients = {};  ///< to begin with, as Layout has them; empty: zero
  std::vector<int> free_states = {};      ///< whose first values are sought, in each record; the others begin at zero
  int num_threads = 1;
};

struct OutputError {
  Point point;               ///< states as the equations run
  Eigen::MatrixXd slopes;    ///< of the outputs: samples recorded x (coefficients, then first values record by record)
  Eigen::VectorXd residual;  ///< recorded less computed, record after record, channel by channel
  bool settled = false;      ///< the iterations came to rest
  [[nodiscard]] double squares() const { return residual.squaredNorm(); }
};

/// Coefficients and first values that leave the least sum of squares between recorded and computed outputs: no process
/// noise, so that whatever the equations do not explain counts as error of the channels. That is what is asked of
/// equations whose states nothing records and nothing but the inputs moves. Gauss-Newton steps damped as [Mar63]; the
/// same bits on any number of threads. Nothing where the equations run away from where they begin. Throws as
/// Linearisation, and std::invalid_argument for a free state that there is not.
[[nodiscard]] std::optional<OutputError> output_error(const Problem& problem, const OutputErrorOptions& options);

}  // namespace ident::state_space
