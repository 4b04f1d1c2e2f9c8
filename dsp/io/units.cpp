#include "dsp/io/units.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "dsp/io/channel_roles.hpp"
#include "dsp/io/table_cells.hpp"
#include "dsp/values/constants.hpp"
#include "dsp/values/names.hpp"
#include "dsp/values/signals.hpp"

namespace dsp {
namespace {

struct Row {
  std::string_view name;
  double factor;
  std::string_view si;
};

constexpr double pound_force = 4.4482216152605;  // N
constexpr double kilogram_force = gravity;       // N: the mass times standard gravity
constexpr double degree = std::numbers::pi / 180;
constexpr double minute_s = 60.0, hour_s = 3600.0;

constexpr std::array rows{
    Row{"m", 1, "m"},
    Row{"dm", 1e-1, "m"},
    Row{"cm", 1e-2, "m"},
    Row{"mm", 1e-3, "m"},
    Row{"um", 1e-6, "m"},
    Row{"nm", 1e-9, "m"},
    Row{"in", 0.0254, "m"},
    Row{"mil", 2.54e-5, "m"},
    Row{"ft", 0.3048, "m"},
    Row{"m/s", 1, "m/s"},
    Row{"cm/s", 1e-2, "m/s"},
    Row{"mm/s", 1e-3, "m/s"},
    Row{"in/s", 0.0254, "m/s"},
    Row{"m/s^2", 1, "m/s^2"},
    Row{"mm/s^2", 1e-3, "m/s^2"},
    Row{"cm/s^2", 1e-2, "m/s^2"},
    Row{"Gal", 1e-2, "m/s^2"},
    Row{"g", gravity, "m/s^2"},
    Row{"mg", 1e-3 * gravity, "m/s^2"},
    Row{"in/s^2", 0.0254, "m/s^2"},
    Row{"N", 1, "N"},
    Row{"mN", 1e-3, "N"},
    Row{"daN", 10, "N"},
    Row{"kN", 1e3, "N"},
    Row{"kgf", kilogram_force, "N"},
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
    Row{"deg/s^2", degree, "rad/s^2"},
    Row{"N*m", 1, "N*m"},
    Row{"Pa", 1, "Pa"},
    Row{"kPa", 1e3, "Pa"},
    Row{"MPa", 1e6, "Pa"},
    Row{"bar", 1e5, "Pa"},
    Row{"s", 1, "s"},
    Row{"ms", 1e-3, "s"},
    Row{"us", 1e-6, "s"},
    Row{"ns", 1e-9, "s"},
    Row{"min", minute_s, "s"},
    Row{"h", hour_s, "s"},
    Row{"d", day_s, "s"},
    Row{"Hz", 1, "Hz"},
    Row{"kHz", 1e3, "Hz"},
    Row{"K", 1, "K"},
    Row{"1", 1, "1"},
};

/// What a spelling has in place of what the table has. Signs first, then words between letters, then endings.
struct Spelling {
  std::string_view spelt, meant;
};
constexpr std::array signs{
    Spelling{"\xe2\x81\xbb\xc2\xb2", "^-2"},  // superscripts
    Spelling{"\xe2\x81\xbb\xc2\xb9", "^-1"},
    Spelling{"\xc3\x82\xc2", "\xc2"},  // a sign of UTF-8 that was read as Latin-1 and written again
    Spelling{"\xc2\xb2", "^2"},
    Spelling{"\xc2\xb7", "*"},      // middle dot
    Spelling{"\xe2\x8b\x85", "*"},  // dot operator
    Spelling{"**", "^"},
    Spelling{"\xc2\xb5", "u"},  // micro sign
    Spelling{"\xce\xbc", "u"},  // Greek mu
    Spelling{"\xc2\xb0", "deg"},
    Spelling{" per ", "/"},
};
// Without capitals; one letter of a unit never is spelt so.
constexpr std::array unit_words{
    Spelling{"meter", "m"},        Spelling{"meters", "m"},
    Spelling{"metre", "m"},        Spelling{"metres", "m"},
    Spelling{"centimeter", "cm"},  Spelling{"centimeters", "cm"},
    Spelling{"millimeter", "mm"},  Spelling{"millimeters", "mm"},
    Spelling{"millimetre", "mm"},  Spelling{"millimetres", "mm"},
    Spelling{"micrometer", "um"},  Spelling{"micrometers", "um"},
    Spelling{"micron", "um"},      Spelling{"microns", "um"},
    Spelling{"inch", "in"},        Spelling{"inches", "in"},
    Spelling{"feet", "ft"},        Spelling{"sec", "s"},
    Spelling{"secs", "s"},         Spelling{"second", "s"},
    Spelling{"seconds", "s"},      Spelling{"sekunde", "s"},
    Spelling{"sekunden", "s"},     Spelling{"secondes", "s"},
    Spelling{"segundos", "s"},     Spelling{"msec", "ms"},
    Spelling{"millisecond", "ms"}, Spelling{"milliseconds", "ms"},
    Spelling{"millis", "ms"},      Spelling{"usec", "us"},
    Spelling{"microsecond", "us"}, Spelling{"microseconds", "us"},
    Spelling{"micros", "us"},      Spelling{"nanosecond", "ns"},
    Spelling{"nanoseconds", "ns"}, Spelling{"newton", "N"},
    Spelling{"newtons", "N"},      Spelling{"kilonewton", "kN"},
    Spelling{"kilonewtons", "kN"}, Spelling{"lb", "lbf"},
    Spelling{"lbs", "lbf"},        Spelling{"pound", "lbf"},
    Spelling{"pounds", "lbf"},     Spelling{"volt", "V"},
    Spelling{"volts", "V"},        Spelling{"millivolt", "mV"},
    Spelling{"millivolts", "mV"},  Spelling{"amp", "A"},
    Spelling{"amps", "A"},         Spelling{"ampere", "A"},
    Spelling{"amperes", "A"},      Spelling{"degree", "deg"},
    Spelling{"degrees", "deg"},    Spelling{"grad", "deg"},
    Spelling{"radian", "rad"},     Spelling{"radians", "rad"},
    Spelling{"pascal", "Pa"},      Spelling{"hertz", "Hz"},
    Spelling{"hz", "Hz"},          Spelling{"khz", "kHz"},
    Spelling{"gn", "g"},           Spelling{"strain", "1"},
    Spelling{"minute", "min"},     Spelling{"minutes", "min"},
    Spelling{"minuten", "min"},    Spelling{"minutos", "min"},
    Spelling{"hour", "h"},         Spelling{"hours", "h"},
    Spelling{"hr", "h"},           Spelling{"hrs", "h"},
    Spelling{"stunden", "h"},      Spelling{"heures", "h"},
    Spelling{"horas", "h"},        Spelling{"day", "d"},
    Spelling{"days", "d"},         Spelling{"tage", "d"},
    Spelling{"mils", "mil"},       Spelling{"thou", "mil"},
    Spelling{"gal", "Gal"},        Spelling{"kilopond", "kgf"},
};
constexpr std::array endings{
    Spelling{"/s/s", "/s^2"},  Spelling{"/s2", "/s^2"},  Spelling{"*s^-2", "/s^2"}, Spelling{" s^-2", "/s^2"},
    Spelling{".s^-2", "/s^2"}, Spelling{"*s-2", "/s^2"}, Spelling{" s-2", "/s^2"},  Spelling{".s-2", "/s^2"},
    Spelling{"*s^-1", "/s"},   Spelling{" s^-1", "/s"},  Spelling{".s^-1", "/s"},   Spelling{"*s-1", "/s"},
    Spelling{" s-1", "/s"},    Spelling{".s-1", "/s"},   Spelling{"Nm", "N*m"},     Spelling{"N m", "N*m"},
};

struct Hint {
  std::string_view name, text;
};
constexpr std::array hints{
    Hint{"G", "The acceleration of gravity is written g (9.80665 m/s^2)"},
    Hint{"gram", "Mass is no measured unit here; g means gravity, 9.80665 m/s^2"},
    Hint{"grams", "Mass is no measured unit here; g means gravity, 9.80665 m/s^2"},
    Hint{"gr", "Mass is no measured unit here; g means gravity, 9.80665 m/s^2"},
    Hint{"kg", "Mass is no measured unit here; for a force write N, kgf, lbf or kip, for gravity g"},
    Hint{"degC", "Write K; an offset in the unit is not supported"},
    Hint{"\xc2\xb0"
         "C",
         "Write K; an offset in the unit is not supported"},
    Hint{"MM", "Units are case sensitive: mm"},
    Hint{"Mm", "Units are case sensitive: mm"},
    Hint{"EU", "Name the unit itself, for example mV/mm or mV/g"},
};

std::string unbracketed(std::string_view text) {
  if (text.size() > 2 && text.front() == '(' && text.back() == ')') return std::string(text.substr(1, text.size() - 2));
  return std::string(text);
}

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

// "Meters per second\u00b2" as the table writes it.
std::string canonical(std::string_view text) {
  std::string plain(text);
  for (const Spelling& sign : signs)
    for (auto at = plain.find(sign.spelt); at != std::string::npos; at = plain.find(sign.spelt, at + sign.meant.size()))
      plain.replace(at, sign.spelt.size(), sign.meant);
  std::string result;
  for (std::size_t at = 0; at < plain.size();) {
    auto end = at;
    while (end < plain.size() && is_letter(plain[end])) ++end;
    if (end == at) {
      result += plain[at++];
      continue;
    }
    const std::string run = plain.substr(at, end - at), word = lower(run);
    const auto* found =
        std::find_if(unit_words.begin(), unit_words.end(), [&](const Spelling& one) { return one.spelt == word; });
    result += found == unit_words.end() ? std::string_view(run) : found->meant;
    at = end;
  }
  for (const Spelling& ending : endings)
    if (result.ends_with(ending.spelt)) {
      result.replace(result.size() - ending.spelt.size(), ending.spelt.size(), ending.meant);
      break;
    }
  return result;
}

const Row* find_row(std::string_view name) {
  constexpr std::size_t longest = 40;
  if (name.size() > longest) return nullptr;
  const std::string known = canonical(name);
  const auto* found = std::find_if(rows.begin(), rows.end(), [&](const Row& row) { return row.name == known; });
  return found == rows.end() ? nullptr : found;
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
  const Unit measured = find_unit(unbracketed(trimmed(ratio.substr(slash + 1))));
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

namespace {

struct TimeWord {
  std::string_view text;
  bool is_whole;  // alone it names a clock, and not only as one of several words
};
constexpr std::array time_words{
    TimeWord{"t", true},       TimeWord{"time", true},   TimeWord{"timestamp", true},    TimeWord{"zeit", true},
    TimeWord{"temps", true},   TimeWord{"tiempo", true}, TimeWord{"tempo", true},        TimeWord{"seconds", true},
    TimeWord{"millis", true},  TimeWord{"micros", true}, TimeWord{"elapsed", false},     TimeWord{"sekunden", true},
    TimeWord{"uhrzeit", true}, TimeWord{"clock", false}, TimeWord{"milliseconds", true}, TimeWord{"microseconds", true},
};

/// Ends of a name that are more often something else than a unit: "force_in" is an input, "a_s" a hysteretic force.
struct Doubtful {
  std::string_view unit;
  bool (*counts_behind)(std::string_view);  ///< the rest of the name
};
constexpr auto never = [](std::string_view) { return false; };
constexpr std::array doubtful{
    Doubtful{"in", names_position}, Doubtful{"g", names_acceleration},
    Doubtful{"A", never},           Doubtful{"C", never},
    Doubtful{"K", never},           Doubtful{"1", never},
    Doubtful{"strain", never},
};

/// Whether any run of letters, without capitals, passes.
template <class Test>
bool any_letters(std::string_view text, Test&& test) {
  const std::string name = lower(text);
  for (std::size_t at = 0; at < name.size();) {
    auto end = at;
    while (end < name.size() && is_letter(name[end])) ++end;
    if (end > at && test(std::string_view(name).substr(at, end - at))) return true;
    at = end + 1;
  }
  return false;
}

/// Only a clock is in a unit of time: "a_s" is a hysteretic force, "x_min" and "x (min)" are the least.
bool is_time_elsewhere(std::string_view base, std::string_view unit) {
  const Row* row = find_row(trimmed(unit));
  return row != nullptr && row->si == "s" && !speaks_of_time(base);
}

bool may_end(std::string_view base, std::string_view unit) {
  constexpr std::size_t longest_unit = 40;
  if (unit.size() > longest_unit || base.empty() || is_time_elsewhere(base, unit)) return false;
  const auto* found =
      std::find_if(doubtful.begin(), doubtful.end(), [&](const Doubtful& one) { return one.unit == unit; });
  return found == doubtful.end() || found->counts_behind(base);
}

// "Time (s) Run #1" is "Time Run #1" in s.
std::optional<NamedUnit> unit_in_brackets(std::string_view name) {
  for (const auto& [open, close] : {std::pair{'[', ']'}, std::pair{'(', ')'}})
    for (auto at = name.rfind(open); at != std::string_view::npos && at > 0; at = name.rfind(open, at - 1)) {
      auto end = name.find(close, at);
      if (name.back() == close && !is_unit(name.substr(at + 1, std::min(end, name.size()) - at - 1)))
        end = name.size() - 1;  // (m/(s^2))
      if (end == std::string_view::npos || !is_unit(name.substr(at + 1, end - at - 1))) continue;
      if (find_unit(name.substr(at + 1, end - at - 1)).factor >= minute_s &&
          is_time_elsewhere(name.substr(0, at), name.substr(at + 1, end - at - 1)))
        continue;
      std::string base(trimmed(name.substr(0, at)));
      if (const auto behind = trimmed(name.substr(end + 1)); !behind.empty()) base += fmt::format(" {}", behind);
      return NamedUnit{base, std::string(trimmed(name.substr(at + 1, end - at - 1)))};
    }
  return std::nullopt;
}

// "Time ms", "v mm/s".
std::optional<NamedUnit> unit_behind_blank(std::string_view name) {
  for (auto at = name.find(' '); at != std::string_view::npos; at = name.find(' ', at + 1)) {
    const auto base = trimmed(name.substr(0, at)), unit = trimmed(name.substr(at + 1));
    if (base.empty() || base.back() == '/' || base.back() == ',') continue;
    const bool counts = unit.size() > 1 ? may_end(base, unit) : unit == "s" && is_time_name(base);
    if (counts && is_unit(unit)) return NamedUnit{std::string(base), std::string(unit)};
  }
  return std::nullopt;
}

// "x / mm", "Displacement, mm".
std::optional<NamedUnit> unit_behind_mark(std::string_view name) {
  if (is_unit(name)) return std::nullopt;  // m/s alone
  for (auto at = name.find_first_of("/,"); at != std::string_view::npos; at = name.find_first_of("/,", at + 1)) {
    const auto base = trimmed(name.substr(0, at));
    const std::string unit = unbracketed(trimmed(name.substr(at + 1)));
    if (!base.empty() && unit != "1" && is_unit(unit)) return NamedUnit{std::string(base), unit};
  }
  return std::nullopt;
}

// x_top_mm, a_m_per_s2, omega_rad_s: the longest ending that is a unit.
std::optional<NamedUnit> unit_behind_underscore(std::string_view name) {
  for (auto at = name.find('_'); at != std::string_view::npos; at = name.find('_', at + 1)) {
    std::string unit(name.substr(at + 1));
    if (!may_end(name.substr(0, at), unit)) continue;
    for (auto per = unit.find("_per_"); per != std::string::npos; per = unit.find("_per_")) {
      unit[per] = '/';
      unit.erase(per + 1, 4);
    }
    for (auto under = unit.find('_'); under != std::string::npos; under = unit.find('_')) unit[under] = '/';
    if (is_unit(unit)) return NamedUnit{std::string(name.substr(0, at)), unit};
  }
  return std::nullopt;
}

}  // namespace

bool is_time_name(std::string_view base) {
  const std::string name = lower(trimmed(base));
  return name == "x_value" || std::any_of(time_words.begin(), time_words.end(),
                                          [&](const TimeWord& word) { return word.is_whole && word.text == name; });
}

bool speaks_of_time(std::string_view base) {
  return is_time_name(base) || any_letters(base, [](std::string_view word) {
           return word.size() > 1 && std::any_of(time_words.begin(), time_words.end(),
                                                 [&](const TimeWord& one) { return one.text == word; });
         });
}

std::string unit_of_time_name(std::string_view base) {
  std::string unit;
  (void)any_letters(base, [&](std::string_view word) {
    const bool found = word.size() > 1 && is_unit(word) && find_unit(word).si == "s";
    if (found) unit = find_unit(word).name;
    return found;
  });
  return unit;
}

NamedUnit split_unit(std::string_view column) {
  const auto name = trimmed(column);
  for (const auto find : {unit_in_brackets, unit_behind_blank, unit_behind_mark, unit_behind_underscore})
    if (const auto found = find(name)) return *found;
  return {std::string(name), ""};
}

}  // namespace dsp
