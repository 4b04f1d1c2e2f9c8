#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kinds {

inline constexpr std::array<std::string_view, 10> RIGHT = {
    "linear",  "hardening",         "softening",     "asymmetric",        "bistable",
    "coulomb", "hardening_coulomb", "cubic_damping", "amplitude_damping", "self_excited"};
inline constexpr std::array<std::string_view, 18> WRONG = {
    "one_sided_spring", "gap",         "hard_stop",        "quadratic_damping",
    "stribeck",         "bouc_wen",    "drifting_spring",  "drifting_damper",
    "mathieu",          "hidden_mass", "saturated_sensor", "late_input",
    "second_force",     "x_abs_x",     "fifth_power",      "tanh_friction",
    "magnet",           "impacts"};

/// Terms of the default library in x and v, in the order of Law::polynomial.
inline constexpr std::array<const char*, 10> POLYNOMIAL = {"1",   "x",   "v",     "x^2",   "x*v",
                                                           "v^2", "x^3", "x^2*v", "x*v^2", "v^3"};

/// a = polynomial + friction sgn(v) + input_gain u + what no candidate holds; SI.
struct Law {
  std::string kind;
  std::array<double, 10> polynomial{};
  double friction = 0.0;                              ///< Coefficient of sgn(v), m/s^2, not positive.
  double input_gain = 0.0;                            ///< 1/m for a force, -1 for the base.
  double strength = 0.0;                              ///< Of what no candidate holds, without unit; 0: a right law.
  double shape = 0.0;                                 ///< Its other parameter, without unit.
  double x_scale = 1.0, omega = 1.0, duration = 1.0;  ///< m, rad/s, s
};

/// Signals at the samples, free of noise. Those of the motion are relative to the base.
struct Signals {
  Eigen::ArrayXd x, v, a;
  Eigen::ArrayXd missing;  ///< What no candidate holds, m/s^2.
  Eigen::ArrayXd input;    ///< f or the base's acceleration; empty in a decay.
  Eigen::ArrayXd base;     ///< The base's displacement, where it is recorded.
  double stuck_share = 0.0;
};

/// What acts at every half step: the input, and an acceleration that is not recorded.
struct Drive {
  Eigen::ArrayXd input, hidden;
};

/// The motion by Runge-Kutta steps of order 4, `steps` in a sample; sticking and reversals under friction are events.
/// state: x, v and an inner state. No samples where |x| exceeds `most` scales.
Signals integrate(const Law& law, Eigen::Array4d state, const Drive& drive, double sample_s, int steps, double most);

struct Column {
  std::string header;
  Eigen::ArrayXd values;  ///< With noise, in the unit of the header.
};

struct Record {
  std::string name;
  bool right = false;
  Law law;
  std::string drive, excitation;  ///< noise, multisine, sweep, steps, decay; force, base, none.
  double noise = 0.0, rate_hz = 0.0, natural_hz = 0.0, lag_s = 0.0;
  Signals signals;          ///< As ideal sensors and clocks would record them, but for what is wrong with one.
  double share_term = 0.0;  ///< rms of what no candidate holds over that of a; 0 where a sensor or a clock is wrong.
  double share_left = 0.0;  ///< rms of what the best combination of all candidates leaves over that of a.
  std::vector<Column> columns;
};

/// Even indices: a law of the default library; odd ones: another. The same for the same seed and index.
Record draw_record(std::uint64_t seed, std::uint64_t index);

/// Columns of the default library: polynomials to third order, sgn(v), the input; each of norm 1 or 0.
Eigen::MatrixXd library_columns(const Signals& signals);

}  // namespace kinds
