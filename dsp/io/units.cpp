#include "dsp/io/units.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "dsp/constants.hpp"
#include "dsp/io/channel_roles.hpp"
#include "dsp/io/table_cells.hpp"
#include "dsp/names.hpp"
#include "dsp/signals.hpp"

namespace dsp {
namespace {

struct Row {
  std::string_view name;
  double factor;
  std::string_view si;
};

constexpr double pound_force = 4.4482216152605;  // N
constexpr double degree = std::numbers::pi / 180;

constexpr std::array rows{
    Row{"m", 1, "m"},
    Row{"cm", 1e-2, "m"},
    Row{"mm", 1e-3, "m"},
    Row{"um", 1e-6, "m"},
    Row{"nm", 1e-9, "m"},
    Row{"in", 0.0254, "m"},
    Row{"ft", 0.3048, "m"},
    Row{"m/s", 1, "m/s"},
    Row{"cm/s", 1e-2, "m/s"},
    Row{"mm/s", 1e-3, "m/s"},
    Row{"in/s", 0.0254, "m/s"},
    Row{"m/s^2", 1, "m/s^2"},
    Row{"mm/s^2", 1e-3, "m/s^2"},
    Row{"g", gravity, "m/s^2"},
    Row{"mg", 1e-3 * gravity, "m/s^2"},
    Row{"in/s^2", 0.0254, "m/s^2"},
    Row{"N", 1, "N"},
    Row{"mN", 1e-3, "N"},
    Row{"kN", 1e3, "N"},
    Row{"lbf", pound_force, "N"},
    Row{"kip", 1e3 * pound_force, "N"},
    Row{"V", 1, "V"},
    Row{"mV", 1e-3, "V"},
    Row{"uV", 1e-6, "V"},
    Row{"A", 1, "A"},
    Row{"mA", 1e-3, "A"},
    Row{"C", 1, "C"},
    Row{"pC", 1e-12, "C"},
    Row{"rad", 1, "rad"},
    Row{"mrad", 1e-3, "rad"},
    Row{"deg", degree, "rad"},
    Row{"rad/s", 1, "rad/s"},
    Row{"deg/s", degree, "rad/s"},
    Row{"rad/s^2", 1, "rad/s^2"},
    Row{"N*m", 1, "N*m"},
    Row{"Pa", 1, "Pa"},
    Row{"kPa", 1e3, "Pa"},
    Row{"MPa", 1e6, "Pa"},
    Row{"bar", 1e5, "Pa"},
    Row{"s", 1, "s"},
    Row{"ms", 1e-3, "s"},
    Row{"us", 1e-6, "s"},
    Row{"Hz", 1, "Hz"},
    Row{"kHz", 1e3, "Hz"},
    Row{"K", 1, "K"},
    Row{"1", 1, "1"},
};

struct Alias {
  std::string_view spelling, name;
};
constexpr std::array aliases{
    Alias{"\xc2\xb5m", "um"},  // micro sign
    Alias{"\xce\xbcm", "um"},  // Greek mu
    Alias{"\xc2\xb5V", "uV"},
    Alias{"\xc2\xb5s", "us"},
    Alias{"\xc2\xb0", "deg"},
    Alias{"\xc2\xb0/s", "deg/s"},
    Alias{"m/s2", "m/s^2"},
    Alias{"m/s/s", "m/s^2"},
    Alias{"m/s\xc2\xb2", "m/s^2"},
    Alias{"mm/s2", "mm/s^2"},
    Alias{"in/s2", "in/s^2"},
    Alias{"rad/s2", "rad/s^2"},
    Alias{"lb", "lbf"},
    Alias{"gn", "g"},
    Alias{"Nm", "N*m"},
    Alias{"N m", "N*m"},
    Alias{"meter", "m"},
    Alias{"inch", "in"},
    Alias{"sec", "s"},
    Alias{"Volts", "V"},
    Alias{"Newtons", "N"},
    Alias{"Pounds", "lbf"},
    Alias{"Strain", "1"},
};

struct Hint {
  std::string_view name, text;
};
constexpr std::array hints{
    Hint{"G", "The acceleration of gravity is written g (9.80665 m/s^2)"},
    Hint{"gram", "Mass is no measured unit here; g means gravity, 9.80665 m/s^2"},
    Hint{"grams", "Mass is no measured unit here; g means gravity, 9.80665 m/s^2"},
    Hint{"gr", "Mass is no measured unit here; g means gravity, 9.80665 m/s^2"},
    Hint{"kg", "Mass is no measured unit here; for a force write N, kN, lbf or kip, for gravity g"},
    Hint{"kgf", "Write the force in N (1 kgf = 9.80665 N)"},
    Hint{"degC", "Write K; an offset in the unit is not supported"},
    Hint{"\xc2\xb0"
         "C",
         "Write K; an offset in the unit is not supported"},
    Hint{"MM", "Units are case sensitive: mm"},
    Hint{"Mm", "Units are case sensitive: mm"},
    Hint{"EU", "Name the unit itself, for example mV/mm or mV/g"},
};

std::string without_brackets(std::string_view text) {
  if (text.size() > 2 && text.front() == '(' && text.back() == ')') return std::string(text.substr(1, text.size() - 2));
  return std::string(text);
}

const Row* find_row(std::string_view name) {
  for (const auto& alias : aliases)
    if (alias.spelling == name) name = alias.name;
  for (const auto& row : rows)
    if (row.name == name) return &row;
  return nullptr;
}

// "250 mV" -> 250 and "mV".
struct Parts {
  double value;
  std::string_view unit;
};
Parts split_number(std::string_view whole, std::string_view example) {
  const auto text = trimmed(whole);
  double value = 0;
  const auto* begin = text.data() + (text.starts_with('+') ? 1 : 0);
  const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value);
  const auto unit = trimmed(text.substr(static_cast<std::size_t>(end - text.data())));
  if (error != std::errc() || unit.empty())
    throw Fault(FaultKind::usage, "unit.syntax",
                fmt::format("'{}': want a number and a unit, for example \"{}\"", clean_name(whole), example));
  return {value, unit};
}

int derivative_order(std::string_view si) {
  if (si == "m" || si == "rad") return 0;
  if (si == "m/s" || si == "rad/s") return 1;
  if (si == "m/s^2" || si == "rad/s^2") return 2;
  return -1;
}

}  // namespace

bool is_electrical(std::string_view si) {
  return si == "V" || si == "A" || si == "C";
}

bool is_unit(std::string_view name) {
  return find_row(trimmed(name)) != nullptr;
}

std::vector<std::string> unit_names() {
  std::vector<std::string> names;
  for (const auto& row : rows) names.emplace_back(row.name);
  return names;
}

Unit find_unit(std::string_view name) {
  const auto text = trimmed(name);
  if (const auto* row = find_row(text)) return {std::string(row->name), std::string(row->si), row->factor};
  std::string remedy;
  for (const auto& hint : hints)
    if (hint.name == text) remedy = hint.text;
  const std::vector<std::string> known = unit_names();
  if (const auto near = nearest(text, known); remedy.empty() && !near.empty())
    remedy = fmt::format("Did you mean '{}'?", near);
  if (remedy.empty()) remedy = fmt::format("Known: {}", fmt::join(known, ", "));
  throw Fault(FaultKind::usage, "unit.unknown", fmt::format("unknown unit '{}'. {}", clean_name(text), remedy));
}

Quantity parse_quantity(std::string_view text) {
  const auto [value, name] = split_number(text, "0.23 ms");
  const Unit unit = find_unit(name);
  if (!std::isfinite(value))
    throw Fault(FaultKind::usage, "unit.syntax", fmt::format("'{}': want a finite number", clean_name(text)));
  return {value * unit.factor, unit.si};
}

Sensitivity parse_sensitivity(std::string_view text) {
  const auto [value, ratio] = split_number(text, "100 mV/g");
  const auto slash = ratio.find('/');
  if (slash == std::string_view::npos)
    throw Fault(FaultKind::usage, "unit.syntax",
                fmt::format("'{}': want electrical per measured unit, for example \"100 mV/g\"", clean_name(text)));
  const Unit electrical = find_unit(ratio.substr(0, slash));
  const Unit measured = find_unit(without_brackets(trimmed(ratio.substr(slash + 1))));
  if (!is_electrical(electrical.si))
    throw Fault(FaultKind::usage, "unit.syntax",
                fmt::format("'{}': '{}' is no electrical unit (V, A, C). Want for example \"100 mV/g\"",
                            clean_name(text), electrical.name));
  if (!(value > 0) || !std::isfinite(value))
    throw Fault(FaultKind::usage, "calibration.value",
                fmt::format("'{}': got sensitivity {}, want a positive number (turn a channel round with sign = -1)",
                            clean_name(text), value));
  return {value * electrical.factor / measured.factor, electrical.si, measured.si};
}

std::string si_unit(Role role) {
  return std::string(info_of(role).unit);
}

bool fits(Role role, std::string_view si) {
  if (role == Role::t) return si == "s";
  const int wanted = info_of(role).order;
  return wanted < 0 || si.empty() || si == "1" || is_electrical(si) || wanted == derivative_order(si);
}

std::string roles_in(std::string_view si) {
  std::vector<std::string> roles;
  const int order = derivative_order(si);
  for (const SignalInfo& signal : signal_table())
    if (order >= 0 && signal.order == order && signal.role != Role::other) roles.emplace_back(to_string(signal.role));
  if (order < 0) roles = {"f", "z", "other"};
  const std::string last = roles.back();
  roles.pop_back();
  return fmt::format("{} or {}", fmt::join(roles, ", "), last);
}

bool is_time_name(std::string_view base) {
  std::string name(trimmed(base));
  for (char& c : name)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  constexpr std::array clocks{"t", "time", "timestamp", "x_value", "zeit", "temps", "tiempo", "tempo", "seconds"};
  return std::find(clocks.begin(), clocks.end(), name) != clocks.end();
}

NamedUnit split_unit(std::string_view column) {
  const auto name = trimmed(column);
  for (const auto& [open, close] : {std::pair{'[', ']'}, std::pair{'(', ')'}}) {
    const auto at = name.rfind(open);
    if (at == std::string_view::npos || at == 0 || name.back() != close) continue;
    const auto unit = trimmed(name.substr(at + 1, name.size() - at - 2));
    if (is_unit(unit)) return {std::string(trimmed(name.substr(0, at))), std::string(unit)};
  }
  // x_top_mm, a_m_per_s2, omega_rad_s: the longest ending that is a unit.
  for (auto at = name.find('_'); at != std::string_view::npos; at = name.find('_', at + 1)) {
    std::string unit(name.substr(at + 1));
    if (unit == "g" && names_acceleration(name.substr(0, at))) return {std::string(name.substr(0, at)), unit};
    if (at == 0 || unit == "in" || unit == "g" || unit == "A" || unit == "C" || unit == "K" || unit == "1") continue;
    if ((unit == "s" || unit == "ms" || unit == "us") && !is_time_name(name.substr(0, at))) continue;
    for (auto per = unit.find("_per_"); per != std::string::npos; per = unit.find("_per_")) {
      unit[per] = '/';
      unit.erase(per + 1, 4);
    }
    for (auto under = unit.find('_'); under != std::string::npos; under = unit.find('_')) unit[under] = '/';
    if (is_unit(unit)) return {std::string(name.substr(0, at)), unit};
  }
  return {std::string(name), ""};
}

}  // namespace dsp
