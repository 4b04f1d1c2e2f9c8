#pragma once
#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/ode/system.hpp"

namespace sim {

enum class SimulationStatus { finished, step_limit, diverged };

struct SimulateOptions {
  double duration_s = 0.0;      ///< required
  double sample_rate_hz = 0.0;  ///< required: outputs at start_s + n / sample_rate_hz, both ends included
  double start_s = 0.0;
  double relative_tolerance = 1e-10;
  double absolute_tolerance = 1e-12;  ///< times System::scales
  double max_step_s = 0.0;            ///< 0: no limit
  /// Of an output, on average and with a hundred outputs in advance: more end the run (step_limit). What is that much
  /// faster than its outputs is in none of them.
  double max_steps_per_output = 1000.0;
  double divergence_bound = 1e6;    ///< |y| beyond this (any state) ends the run as diverged
  std::function<void()> poll = {};  ///< called now and then between steps; may throw to stop
};

struct Simulation {
  SimulationStatus status = SimulationStatus::finished;
  std::string reason;  ///< empty when finished; else what happened and at what t
  Eigen::VectorXd time_s;
  Eigen::MatrixXd states;       ///< num_samples x num_states; cut at the last good sample
  Eigen::MatrixXd derivatives;  ///< rhs at those samples: exact, not differenced
  std::vector<int> modes;       ///< mode at each sample
  std::vector<Event> events;
  std::optional<double> stiff_from_s;  ///< from when on implicit formulas were used
  long num_steps = 0, num_rhs_evaluations = 0;
};

/// Integrates by an explicit Runge-Kutta pair: Dormand-Prince 8(5,3), for relative tolerances of 1e-7 and above 5(4).
/// Where stability, not accuracy, holds its steps short (stiff), backward differentiation takes over (CVODE). Switches
/// are located on the polynomial of the step in which one changes sign; there the integration starts again.
/// Throws std::invalid_argument for a missing duration or rate or a wrong number of initial values, and whatever the
/// system's own functions throw.
[[nodiscard]] Simulation simulate(const System& system, const Eigen::Ref<const Eigen::VectorXd>& initial,
                                  const SimulateOptions& options);

/// What a simulation is worth, from a second one at ten times its tolerances.
struct SimulationError {
  /// Of each state, the largest difference between the two over the root mean square of the state: an upper estimate,
  /// since it is the looser one's error. Infinite where either did not finish, or its switches differ in number.
  Eigen::VectorXd relative;
  double growth = 0.0;  ///< the largest of these over that one's relative tolerance: what became of errors of its steps
};
/// `simulation` is what `simulate` made of the rest.
[[nodiscard]] SimulationError simulation_error(const System& system, const Eigen::Ref<const Eigen::VectorXd>& initial,
                                               SimulateOptions options, const Simulation& simulation);

/// The same integration one internal step at a time, for callers that need the solution between its steps. The mode
/// is constant over a step: an event ends it.
class Integrator {
 public:
  /// sample_rate_hz counts for the limit on steps alone; 0: there is none. Throws as `simulate`.
  Integrator(System system, const Eigen::Ref<const Eigen::VectorXd>& initial, const SimulateOptions& options);
  ~Integrator();
  Integrator(Integrator&&) noexcept;
  Integrator& operator=(Integrator&&) noexcept;

  /// Goes on to the end of the next step, event or run. False, and nothing has moved, if the run is over.
  [[nodiscard]] bool step();
  [[nodiscard]] double begin_s() const;  ///< the last step reached from here
  [[nodiscard]] double end_s() const;    ///< to here
  [[nodiscard]] int mode() const;        ///< in this mode
  /// States at t in [begin_s, end_s], to the order of the integration formula.
  void states(double t, double* y) const;
  [[nodiscard]] const System& system() const&;
  void system() const&& = delete;
  [[nodiscard]] SimulationStatus status() const;
  [[nodiscard]] const std::string& reason() const&;
  void reason() const&& = delete;
  [[nodiscard]] const std::vector<Event>& events() const&;
  void events() const&& = delete;
  [[nodiscard]] std::optional<double> stiff_from_s() const;
  [[nodiscard]] long num_steps() const;
  [[nodiscard]] long num_rhs_evaluations() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sim
