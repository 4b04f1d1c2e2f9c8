#pragma once
#include <functional>
#include <string>
#include <vector>

namespace sim {

/// dy/dt = rhs(t, y, mode, dydt). A system with switches (friction, |v|, stick) is smooth inside each mode; its
/// switching functions are located as roots and the mode changes there, never inside a step.
struct System {
  std::string name;                 ///< "duffing", "coulomb", "bouc-wen", "valanis-1" ...
  std::vector<std::string> states;  ///< names of y: "x", "v", "z"
  std::function<void(double t, const double* y, int mode, double* dydt)> rhs;
  int num_switches = 0;
  /// Values of the switching functions in this mode; a sign change of one is an event.
  std::function<void(double t, const double* y, int mode, double* values)> switching = {};
  /// At an event: the new mode; may correct y (set v to exactly 0). `which`: index of the switch that fired, -1 at the
  /// start.
  std::function<int(double t, double* y, int mode, int which)> next_mode = {};
  std::function<double(double t)> forcing = {};  ///< the input f(t), for output; may be empty
  double max_step_s =
      0.0;  ///< longest step that cannot jump over two zeros of a switch (at rest steps grow); 0: no limit
  std::vector<double> scales = {};  ///< typical size of each state, for the absolute tolerance; empty: 1
};

/// A switch fired: where, which, and the modes on either side.
struct Event {
  double t_s = 0.0;
  int which = 0, mode_before = 0, mode_after = 0;
};

}  // namespace sim
