#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "dsp/values/recording.hpp"

namespace dsp {

/// A unit of the closed table, in any usual spelling ("mm/sec", "Newtons", "m*s^-2", superscripts): 1 of it is `factor`
/// of the SI unit `si`. `g` is 9.80665 m/s^2; a gram is no unit here.
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

/// Whether a name speaks of a clock among other words ("Latest: Time", "seconds_elapsed").
[[nodiscard]] bool speaks_of_time(std::string_view base);

/// "ms" for millis, "s" for seconds_elapsed: the unit of time that a clock is called by; else empty.
[[nodiscard]] std::string unit_of_time_name(std::string_view base);

/// A unit written into a column's name, in brackets anywhere, behind a slash, a comma, a blank or an underscore:
/// "x_top_mm", "omega_rad_s", "force [kN]", "Time (s) Run #1", "x / mm", "Displacement, mm". `base` is the rest.
/// Endings that are more often something else count behind an underscore only where the rest fits: base_in, acc_g,
/// time_s, but force_in is an input and a_s a force.
struct NamedUnit {
  std::string base, unit;  ///< unit empty where there is none
};
[[nodiscard]] NamedUnit split_unit(std::string_view column);

}  // namespace dsp
