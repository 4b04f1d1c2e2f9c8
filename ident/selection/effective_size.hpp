#pragma once
#include <Eigen/Core>
#include <limits>
#include <vector>

namespace ident {

/// How many independent numbers rows hold about the coefficients of an equation.
struct EffectiveSize {
  double num_rows = 0.0;             ///< n
  double num_uncorrelated = 0.0;     ///< n_a: by the autocorrelation of the residual
  double num_noise = 0.0;            ///< by that of the residual and of the candidate most like it; 0: as n_a
  double num_states = 0.0;           ///< n_s: dimensions of what smooth functions of the state could add; 0: not known
  double structural_fraction = 0.0;  ///< f: of the residual's power, a function of the state
  /// Of that power, what comes back when the state does, less two of its standard errors; NaN: not known.
  double state_dependent_fraction = std::numeric_limits<double>::quiet_NaN();
  double revisit_error = 0.0;   ///< two of them
  bool has_inputs = true;       ///< more than x, v, y and dy are part of the state; true too where it is not known
  double autoregression = 0.0;  ///< rho: the rows were whitened by it; 0: they were not
  /// 1 / ((1 - f) / n_noise + f / min(n_a, n_s)): noise is averaged over rows, misfit comes back in every cycle.
  [[nodiscard]] double num_effective() const;
  /// Of the rows; 1 where the residual is white.
  [[nodiscard]] double fraction() const;
};

/// Of the rows of several records, one misfit of which comes back in all: rows and what is independent of them add up,
/// states do not.
[[nodiscard]] EffectiveSize together(const std::vector<EffectiveSize>& records);

/// The best model of a number of terms, as Selection::evidence compares them.
struct ModelOfSize {
  std::vector<Eigen::Index> terms;
  double left_over = 1.0;      ///< power of the target that least squares on them leaves, as a fraction
  double num_effective = 0.0;  ///< what the rows are worth beside it; 0 where there is no term
};

}  // namespace ident
