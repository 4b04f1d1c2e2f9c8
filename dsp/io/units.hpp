#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "dsp/recording.hpp"

namespace dsp {

/// A unit of the closed table: 1 of it is `factor` of the SI unit `si`. `g` is 9.80665 m/s^2; a gram is no unit here.
struct Unit {
  std::string name, si;
  double factor = 1.0;
};
/// Throws Fault unit.unknown (usage) with the nearest unit, or the hint that belongs to it.
[[nodiscard]] Unit find_unit(std::string_view name);
[[nodiscard]] bool is_unit(std::string_view name);
/// The closed table, in its order.
[[nodiscard]] std::vector<std::string> unit_names();
/// V, A or C: what sensors give, before it is made into what they measure.
[[nodiscard]] bool is_electrical(std::string_view si);

/// "0.23 ms", "10 V": in SI.
struct Quantity {
  double value = 0.0;
  std::string si;
};
/// Throws Fault unit.unknown, or unit.syntax where it is not a finite number and a unit.
[[nodiscard]] Quantity parse_quantity(std::string_view text);

/// "250 mV/mm", "100.1 mV/g": `value` is in electrical / measured, both SI (here 250 V/m and V, m).
struct Sensitivity {
  double value = 0.0;
  std::string electrical, measured;
};
/// Throws Fault unit.unknown, unit.syntax, or calibration.value for zero, a negative number, NaN or infinity (the sign
/// of a channel has its own key).
[[nodiscard]] Sensitivity parse_sensitivity(std::string_view text);

/// SI unit that goes with a role: m for x, m/s for v, ...; empty for `other`.
[[nodiscard]] std::string si_unit(Role role);
/// False where role and SI unit contradict each other: an acceleration in m, a base displacement in m/s^2 or N. A
/// motion may be in V, A, C or without a unit (raw), and what drives it (f, z, other) in any.
[[nodiscard]] bool fits(Role role, std::string_view si);

/// "x, y or r" for m: the roles that a channel in this SI unit can have, those of motion first.
[[nodiscard]] std::string roles_in(std::string_view si);

/// Whether a column of this name is a clock ("t", "Time", "timestamp", LabVIEW's "X_Value").
[[nodiscard]] bool is_time_name(std::string_view base);

/// A unit written into a column's name: "x_top_mm", "omega_rad_s", "force [kN]", "acc (m/s^2)". `base` is the rest.
/// Endings that are more often something else only count in brackets (force_in, load_g) or behind a clock (a_s).
struct NamedUnit {
  std::string base, unit;  ///< unit empty where there is none
};
[[nodiscard]] NamedUnit split_unit(std::string_view column);

}  // namespace dsp
