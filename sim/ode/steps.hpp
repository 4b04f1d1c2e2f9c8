#pragma once
#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>

#include "sim/ode/system.hpp"

// How a solution is followed from step to step while the mode of its system does not change. Switches are not looked
// at.

namespace sim {

struct StepOptions {
  double relative_tolerance = 0.0;
  Eigen::VectorXd absolute_tolerance;  ///< of each state; a step may err by absolute + relative |y|
  double stop_s = 0.0;                 ///< no step goes beyond
  double max_step_s = 0.0;             ///< 0: no limit
};

class Steps {
 public:
  virtual ~Steps() = default;
  /// Goes on from y at t in a mode, and forgets what was before.
  virtual void restart(double t, const double* y, int mode) = 0;
  /// Takes a step. Where none is small enough, says why, and nothing has moved. What the right-hand side throws comes
  /// through.
  [[nodiscard]] virtual std::optional<std::string> step() = 0;
  [[nodiscard]] virtual double begin_s() const = 0;  ///< the last step reached from here
  [[nodiscard]] virtual double end_s() const = 0;    ///< to here
  /// States at t in [begin_s, end_s].
  virtual void states(double t, double* y) = 0;
  /// Whether it is stability that has long held its steps short, not accuracy.
  [[nodiscard]] virtual bool stiff() const = 0;
  /// Of each step, so many equal parts at whose ends switches are to be looked at.
  [[nodiscard]] virtual int num_checks() const = 0;
  [[nodiscard]] virtual long num_rhs_evaluations() const = 0;
};

/// Explicit Runge-Kutta: Dormand-Prince 5(4), for tight tolerances 8(5,3). The system must outlive it, as below.
[[nodiscard]] std::unique_ptr<Steps> explicit_steps(const System& system, const StepOptions& options);

/// Backward differentiation formulas of orders 1 to 5, by CVODE of SUNDIALS. Throws std::invalid_argument for options
/// that it refuses.
[[nodiscard]] std::unique_ptr<Steps> stiff_steps(const System& system, const StepOptions& options);

}  // namespace sim
