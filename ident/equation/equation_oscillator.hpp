#pragma once
#include <Eigen/Core>
#include <optional>
#include <utility>

#include "ident/equation/identified_equation.hpp"
#include "sim/ode/driven_oscillator.hpp"

namespace ident {

/// What the drive of an identified equation is.
enum class DriveKind { base, force };

struct EquationOscillator {
  sim::DrivenOscillator oscillator;  ///< owns its terms; not to be shared between threads
  DriveKind drive = DriveKind::base;
  bool has_friction = false;  ///< a term jumps with the sign of the velocity
};

/// The equation with these coefficients, driven by a sine of its base's displacement, or of f where it has no base.
/// Works in x where friction goes by sgn(v) and in y where it goes by sgn(dy). Throws dsp::Fault (usage,
/// "frc.equation") for a target that is no acceleration of x or y, signals that are neither motion nor drive, switches
/// of anything else, and equations without a drive.
[[nodiscard]] EquationOscillator equation_oscillator(const IdentifiedEquation& equation,
                                                     const Eigen::VectorXd& coefficients);

/// Frequencies of free vibration in Hz, lowest and highest over its amplitudes up to `largest_x`, by the first harmonic
/// of the restoring force: that of its secant at sqrt(3) / 2 of the amplitude, exact to the third degree; and of small
/// ones where it rests between -largest_x and largest_x. None where nothing pulls back.
[[nodiscard]] std::optional<std::pair<double, double>> free_frequencies_hz(const sim::DrivenOscillator& oscillator,
                                                                           double largest_x);

}  // namespace ident
