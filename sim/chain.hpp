#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "sim/systems.hpp"

namespace sim {

/// What drives a chain: a force (N) or the motion of the base (m), with its derivatives.
struct Drive {
  std::function<double(double t)> value, rate, acceleration;
};

/// 64 sines at random between two frequencies, each amplitude and phase from two normal deviates, together of this root
/// mean square. The same for the same seed on any machine.
[[nodiscard]] Drive random_drive(std::uint64_t seed, double from_hz, double to_hz, double rms);

/// Samples at n / sample_rate_hz, between them the cubic through the four nearest whose rate is continuous (Catmull and
/// Rom); at the ends the value stays. Throws std::invalid_argument for fewer than 4 samples or a rate that is not
/// positive.
[[nodiscard]] Drive recorded_drive(std::vector<double> samples, double sample_rate_hz);

/// A drive as an actuator of first order passes it on: its value z obeys z' = (value - z) / lag from z = value at t = 0
/// to the end of a duration, by steps of a twentieth of the lag, of 0.5 ms at most, over which the drive is straight.
/// Throws std::invalid_argument for a lag that is not from 1e-4 to 1e4 s, and for more than 1e8 steps.
[[nodiscard]] Drive lagged(const Drive& drive, double lag_s, double duration_s);

/// Between body i - 1 and body i; before the first is the base.
struct Link {
  double stiffness = 100.0, damping = 0.5, cubic = 0.0, friction = 0.0;
};

/// Masses in a row. With d_i = x_i - x_(i-1) and x_0 = r, zero where the base stands still,
///   m_i x_i'' = F_i - F_(i+1) + f where the force acts,   F_i = -(k_i d_i + c_i d_i' + k3_i d_i^3 + mu_i sgn(d_i')).
/// Displacements are absolute. Where friction holds a link, bodies go on together.
struct Chain {
  std::vector<double> masses = {1.0, 1.0};
  std::vector<Link> links = {{}, {.cubic = 1e4}};  ///< as many
  bool base_driven = false;                        ///< else by a force on body `driven`, from 1
  int driven = 1;
};

/// The states are x1 ... xn, v1 ... vn, at first zero, or where the base is. Truth has a row 2 i for each body, target
/// "a1", with terms as ident::candidates_of names them. Throws std::invalid_argument for a chain without a mass, of
/// more than 12, with a mass that is not positive or a force on a body that is not there.
[[nodiscard]] Experiment make_experiment(const Chain& chain, const Drive& drive);

/// A chain by the names of its parameters, beginning from 2 masses of 1 kg: masses, base (1: base driven), driven;
/// mass, stiffness, damping, cubic, friction of all bodies or, as mass_2, of one body and the link below it. cubic is
/// 0 below the first. What is set of all is set before what is set of one. Throws std::invalid_argument as above, and
/// for a name that is none of these.
[[nodiscard]] Chain make_chain(const std::vector<std::pair<std::string, double>>& set);

}  // namespace sim
