#include "sim/ode/friction.hpp"

#include <fmt/format.h>

#include <array>
#include <stdexcept>
#include <utility>

namespace sim {
namespace {

using Sides = std::array<double, max_switches>;

int mode_of(const Sides& sides, int count) {
  int mode = 0;
  for (int i = count; i-- > 0;) mode = 3 * mode + static_cast<int>(sides[i]);
  return mode;
}

/// The side on which the motion goes on from switch i.
int side_after(const Switches& switches, int i, double t, const double* y, const Sides& sides) {
  const int before = static_cast<int>(sides[i]);
  auto rates = switches.rates_at_zero(i, t, y, sides.data());
  if (!rates) {
    const double value = switches.value(i, t, y);
    return value > 0.0 ? 1 : value < 0.0 ? -1 : -before;
  }
  constexpr double later_s = 1e-6;  // at rest while the force passes zero: far shorter than any step
  if (rates->above == 0.0 && rates->below == 0.0) rates = switches.rates_at_zero(i, t + later_s, y, sides.data());
  return side_from_zero(*rates, before);
}

/// Lets go of the first switch that is held where, with the others on their sides now, one side leads away; false:
/// there is none.
bool release(const Switches& switches, double t, const double* y, Sides& sides) {
  for (int i = 0; i < switches.count; ++i) {
    if (sides[i] != 0.0) continue;
    const auto rates = switches.rates_at_zero(i, t, y, sides.data());
    const int side = rates ? side_from_zero(*rates, 1) : 0;
    sides[i] = side;
    if (side != 0) return true;
  }
  return false;
}

int starting_mode(const Switches& switches, double t, const double* y) {
  Sides sides;
  sides.fill(1.0);
  for (int i = 0; i < switches.count; ++i)
    if (const double value = switches.value(i, t, y); value != 0.0) sides[i] = value < 0.0 ? -1.0 : 1.0;
  // At zero each of several that can hold does, until what the others leave it to hold lets it go.
  for (int i = 0; i < switches.count; ++i)
    if (switches.value(i, t, y) == 0.0)
      sides[i] = switches.count > 1 && switches.rates_at_zero(i, t, y, sides.data())
                     ? 0.0
                     : side_after(switches, i, t, y, sides);
  while (switches.count > 1 && release(switches, t, y, sides)) continue;
  return mode_of(sides, switches.count);
}

}  // namespace

int side_from_zero(const RatesAtZero& rates, int before) {
  if (rates.above <= 0.0 && rates.below >= 0.0) return 0;
  if (rates.above > 0.0 && rates.below < 0.0) return -before;
  return rates.above > 0.0 ? 1 : -1;
}

void sides_of(int mode, int count, double* sides) {
  for (int i = 0; i < count; ++i) {
    const int side = (mode % 3 + 4) % 3 - 1;
    sides[i] = side;
    mode = (mode - side) / 3;
  }
}

Switches velocity_switch(std::function<RatesAtZero(double t, const double* y)> rates) {
  return {
      .value = [](int, double, const double* y) { return y[1]; },
      .rates_at_zero = [rates = std::move(rates)](int, double t, const double* y,
                                                  const double*) -> std::optional<RatesAtZero> { return rates(t, y); },
      .settle = [](int, int, double, double* y) { y[1] = 0.0; }};
}

void add_switches(System& system, Switches switches) {
  const int count = switches.count;
  if (count < 1 || count > max_switches)
    throw std::invalid_argument(
        fmt::format("{}: 1 to {} switches are wanted, got {}", system.name, max_switches, count));
  system.num_switches = 2 * count;
  // Off a switch: its own value. On it: how it would go on to either side; once one leads away, the motion goes there.
  system.switching = [switches, count](double t, const double* y, int mode, double* values) {
    Sides sides;
    sides_of(mode, count, sides.data());
    for (int i = 0; i < count; ++i) {
      const bool held = sides[i] == 0.0;
      const RatesAtZero at = held ? *switches.rates_at_zero(i, t, y, sides.data()) : RatesAtZero{};
      values[2 * i] = held ? at.above : switches.value(i, t, y);
      values[2 * i + 1] = held ? at.below : 1.0;
    }
  };
  system.next_mode = [switches = std::move(switches), count](double t, double* y, int mode, int which) {
    if (which < 0) return starting_mode(switches, t, y);
    Sides sides;
    sides_of(mode, count, sides.data());
    const int i = which / 2;
    if (sides[i] == 0.0) {
      sides[i] = which % 2 == 0 ? 1.0 : -1.0;
    } else {
      const int side = side_after(switches, i, t, y, sides);
      switches.settle(i, side, t, y);
      sides[i] = side;
    }
    // What this lets go may change the side on which it goes on itself.
    for (int again = 0; again < count && count > 1 && release(switches, t, y, sides); ++again) {
      sides[i] = side_after(switches, i, t, y, sides);
      switches.settle(i, static_cast<int>(sides[i]), t, y);
    }
    return mode_of(sides, count);
  };
}

}  // namespace sim
