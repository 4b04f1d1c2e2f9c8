#pragma once
#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace kinds {

/// Polynomial terms of the default library, in the order of Law::polynomial.
inline constexpr std::array<const char*, 10> POLYNOMIAL = {"1",   "x",   "v",     "x^2",   "x*v",
                                                           "v^2", "x^3", "x^2*v", "x*v^2", "v^3"};
std::array<double, 10> polynomial_values(double x, double v);

/// Laws of the default library, and what else may act.
inline constexpr std::array<std::string_view, 10> RIGHT = {
    "linear",  "hardening",         "softening",     "asymmetric",        "bistable",
    "coulomb", "hardening_coulomb", "cubic_damping", "amplitude_damping", "self_excited"};
inline constexpr std::array<std::string_view, 18> WRONG = {
    "one_sided_spring", "gap",         "hard_stop",        "quadratic_damping",
    "stribeck",         "bouc_wen",    "drifting_spring",  "drifting_damper",
    "mathieu",          "hidden_mass", "saturated_sensor", "late_input",
    "second_force",     "x_abs_x",     "fifth_power",      "tanh_friction",
    "magnet",           "impacts"};

/// a = polynomial + friction sgn(v) + input gain u + what no candidate holds. SI; kept scales: x_scale in m, omega in
/// rad/s.
struct Law {
  std::string kind;
  std::array<double, 10> polynomial{};
  double friction = 0.0;    ///< Coefficient of sgn(v), m/s^2, not positive.
  double input_gain = 0.0;  ///< 1/m for a force, -1 for the base.
  double strength = 0.0;    ///< Of what no candidate holds; 0: a right law. Without unit.
  double shape = 0.0;       ///< Its other parameter, as `kind` has it.
  double x_scale = 1.0;
  double omega = 1.0;
  double duration = 1.0;
  [[nodiscard]] double static_friction() const;
};

/// x, v and an inner state: hysteretic displacement, or displacement and velocity of a second mass.
using State = std::array<double, 4>;

/// What acts at one moment: of the recorded input, and of one that is not recorded (m/s^2).
struct Drive {
  double input = 0.0;
  double hidden = 0.0;
};

/// What no candidate holds, as an acceleration. `slide`: the sign of v, 0 while it sticks.
double missing_acceleration(const Law& law, double t, const State& state, const Drive& drive, double slide);

/// The motion at the samples.
struct Motion {
  std::vector<double> x, v, a, missing;
  double stuck_share = 0.0;  ///< Of the samples.
  bool finite = true;
};

/// Runge-Kutta of order 4 with `steps` steps in a sample; sticking and reversals under friction are events, found by
/// bisection. drive: at every half step, 2 steps (samples - 1) + 1 values.
Motion integrate(const Law& law, State state, const std::vector<Drive>& drive, double sample_s, int steps);

}  // namespace kinds
