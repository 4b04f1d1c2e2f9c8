#pragma once
#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

namespace sim {

/// dy/dt = rhs(t, y, mode, dydt). A system with switches (friction, |v|, stick) is smooth inside each mode; its
/// switching functions are located as roots and the mode changes there, never inside a step.
struct System {
  std::string name;                            ///< "duffing", "coulomb", "bouc-wen", "valanis-1" ...
  std::vector<std::string> states;             ///< names of y: "x", "v", "a", ...
  std::function<void(double t, const double* y, int mode, double* dydt)> rhs;
  int num_switches = 0;
  /// Values of the switching functions in this mode; a sign change of one is an event.
  std::function<void(double t, const double* y, int mode, double* values)> switching;
  /// At an event: the new mode; may correct y (set v to exactly 0). `which`: index of the switch that fired, -1 at the start.
  std::function<int(double t, double* y, int mode, int which)> next_mode;
  std::function<double(double t)> forcing;     ///< f(t), for output; may be empty
};

enum class SimulationStatus { finished, step_limit, diverged };

struct SimulateOptions {
  double duration_s = 0.0;                     ///< required
  double sample_rate_hz = 0.0;                 ///< required: outputs at n / sample_rate_hz, both ends included
  double start_s = 0.0;
  double relative_tolerance = 1e-10;
  double absolute_tolerance = 1e-12;
  double max_step_s = 0.0;                     ///< 0: no limit
  long max_steps_per_output = 100000;
  double divergence_bound = 1e6;               ///< |y| beyond this (any state) ends the run as diverged
};

struct Event {
  double t_s = 0.0;
  int which = 0, mode_before = 0, mode_after = 0;
};

struct Simulation {
  SimulationStatus status = SimulationStatus::finished;
  std::string reason;                          ///< empty when finished; else what happened and at what t
  Eigen::VectorXd time_s;
  Eigen::MatrixXd states;                      ///< num_samples x num_states; cut at the last good sample
  Eigen::MatrixXd derivatives;                 ///< rhs at those samples: exact, not differenced
  std::vector<int> modes;                      ///< mode at each sample
  std::vector<Event> events;
  long num_steps = 0, num_rhs_evaluations = 0;
};

/// Integrates with SUNDIALS CVODE (Adams, fixed-point), root finding for the switches, restarting at each event.
/// Throws std::invalid_argument for a missing duration or rate or a wrong number of initial values.
[[nodiscard]] Simulation simulate(const System& system, const Eigen::Ref<const Eigen::VectorXd>& initial,
                                  const SimulateOptions& options);

}  // namespace sim
