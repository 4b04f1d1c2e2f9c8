#pragma once
#include <functional>
#include <optional>

#include "sim/ode/system.hpp"

// Switches of an equation, and what happens where one is zero: the law of dry friction, for every system that has it.

namespace sim {

/// How a switch g would go on from zero: dg/dt, up to a positive factor, just above zero and just below it.
struct RatesAtZero {
  double above = 0.0, below = 0.0;
};

/// The side of g = 0 on which the motion goes on: 0, held there, where neither side leads away (Filippov; with g a
/// velocity, the pull does not exceed the friction); else the side that does, 1 or -1; where both do, across from
/// `before`.
[[nodiscard]] int side_from_zero(const RatesAtZero& rates, int before);

inline constexpr int max_switches = 12;  ///< 3^12 modes

/// The switches g_i(t, y) of a system.
struct Switches {
  int count = 1;  ///< at most max_switches
  std::function<double(int i, double t, const double* y)> value;
  /// How g_i goes on from zero, the other switches being on `sides`; none for a switch that is passed and cannot hold.
  std::function<std::optional<RatesAtZero>(int i, double t, const double* y, const double* sides)> rates_at_zero;
  /// At an event of g_i, after which it is on `side`: corrects y where g_i must be exactly zero from here (held, 0) or
  /// may be (passed).
  std::function<void(int i, int side, double t, double* y)> settle;
};

/// The switch of friction on a velocity, state 1; `rates` says how it goes on from rest.
[[nodiscard]] Switches velocity_switch(std::function<RatesAtZero(double t, const double* y)> rates);

/// Gives a system its switches; its modes are then made of their sides: sum of side_i 3^i, each -1, 0 (held) or 1. With
/// one switch the mode is its side. Throws std::invalid_argument for a count outside 1 to max_switches.
void add_switches(System& system, Switches switches);

/// Of each of `count` switches in a mode.
void sides_of(int mode, int count, double* sides);

}  // namespace sim
