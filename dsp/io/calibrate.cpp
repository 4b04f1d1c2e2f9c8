#include "dsp/io/calibrate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

namespace dsp {
namespace {

bool is_sound_file(const SourceInfo& source) {
  for (const char* kind : {"WAV", "RF64", "W64", "CAF", "FLAC", "AIFF"})
    if (source.container.starts_with(kind)) return true;
  return false;
}

std::optional<Unit> unit_of_column(const SourceInfo& source, int column) {
  const auto& unit = source.units[static_cast<std::size_t>(column)];
  if (unit.empty()) return std::nullopt;
  return find_unit(unit);
}

// What the sidecar states wins over a letter at the end of a column's name: "acc_V" in g is the vertical one, "acc_N"
// the northern. "acc_mV" is nothing but a unit, and so is one in brackets or in a line of units.
std::optional<Unit> unit_of_column(const SourceInfo& source, int column, const std::vector<std::string>& stated) {
  auto unit = unit_of_column(source, column);
  const auto at = static_cast<std::size_t>(column);
  const auto& name = source.columns[at];
  const bool is_letter = source.units[at].size() == 1 && name.find_first_of("([/,") == std::string::npos &&
                         split_unit(name).unit == source.units[at];
  if (unit && is_letter && std::find(stated.begin(), stated.end(), unit->si) == stated.end()) return std::nullopt;
  return unit;
}

// A full scale in volts is no value of a channel that is to be in something else.
bool lacks_sensitivity(const ChannelSpec& channel) {
  const std::string wanted = channel.unit.empty() ? si_unit(channel.role) : find_unit(channel.unit).si;
  return !channel.sensitivity && is_electrical(channel.full_scale->si) && !wanted.empty() &&
         wanted != channel.full_scale->si;
}

std::string example_unit(Role role) {
  return role == Role::other || role == Role::f || role == Role::z ? "N" : si_unit(role);
}

std::string sensitivity_line(Role role) {
  const auto unit = example_unit(role);
  const auto* example = unit == "m"       ? "250 mV/mm"
                        : unit == "m/s"   ? "20 mV/(mm/s)"
                        : unit == "m/s^2" ? "100 mV/g"
                                          : "10 mV/N";
  return fmt::format("sensitivity = \"{}\"  # from the sensor's sheet\n", example);
}

constexpr const char* full_scale_line = "full_scale = \"10 V\"  # what 1.0 in the file means\n";

// Number to plug: what 1.0 in the file is in the sensitivity's electrical unit.
std::optional<double> electrical_scale(const ChannelSpec& channel, const SourceInfo& source, int column,
                                       Calibration& calibration) {
  if (channel.full_scale) return channel.full_scale->value;
  if (source.scaled) return std::nullopt;
  if (const auto unit =
          unit_of_column(source, column, {channel.sensitivity->electrical, channel.sensitivity->measured})) {
    if (unit->si == channel.sensitivity->electrical) return unit->factor;
    throw Fault(FaultKind::usage, "calibration.twice",
                fmt::format("{}: channel '{}' has a sensitivity, but its column is in {} already", channel.place,
                            channel.name, unit->name));
  }
  calibration.remark = fmt::format("1.0 in the file taken as 1 {}", channel.sensitivity->electrical);
  return 1.0;
}

Calibration by_sensitivity(const ChannelSpec& channel, const SourceInfo& source, int column) {
  Calibration calibration;
  calibration.unit = channel.sensitivity->measured;
  const auto electrical = electrical_scale(channel, source, column, calibration);
  if (!electrical) {
    calibration.missing = full_scale_line;
    return calibration;
  }
  calibration.scale = *electrical / channel.sensitivity->value;
  return calibration;
}

// A column says its unit. Another of the same kind corrects it; one of another kind is a mistake.
void require_same_kind(const ChannelSpec& channel, const Unit& unit, const Unit& in_file, const std::string& column) {
  if (unit.si == in_file.si) return;
  const std::string remedy =
      is_electrical(in_file.si)
          ? fmt::format("Give its sensitivity in place of the unit, as in sensitivity = \"100 {}/{}\"", in_file.name,
                        unit.name)
          : fmt::format(
                "Correct the unit or the column. If the file is wrong: full_scale = \"1 {}\" in place of the "
                "unit",
                unit.name);
  throw Fault(FaultKind::usage, "unit.kind",
              fmt::format("{}: channel '{}': got unit = \"{}\", but its column '{}' is in {}. {}", channel.place,
                          channel.name, unit.name, column, in_file.name, remedy));
}

Calibration by_unit(const ChannelSpec& channel, const SourceInfo& source, int column) {
  Calibration calibration;
  if (is_sound_file(source) && !source.scaled && !channel.unit.empty()) {
    const auto unit = find_unit(channel.unit);
    calibration.scale = unit.factor;
    calibration.unit = unit.si;
    calibration.remark = fmt::format("1.0 in the file taken as 1 {}", unit.name);
    return calibration;
  }
  if (is_sound_file(source)) {
    if (!channel.unit.empty())  // what 1.0 means is all that lacks
      calibration.missing = fmt::format("full_scale = \"... {}\"  # what 1.0 in the file means\n", channel.unit);
    else
      calibration.missing = sensitivity_line(channel.role) + (source.scaled ? full_scale_line : "");
    return calibration;
  }
  const auto in_name = channel.unit.empty() ? unit_of_column(source, column)
                                            : unit_of_column(source, column, {find_unit(channel.unit).si});
  const auto base = split_unit(source.columns[static_cast<std::size_t>(column)]).base;
  if (!channel.unit.empty()) {
    const auto unit = find_unit(channel.unit);
    if (in_name) require_same_kind(channel, unit, *in_name, source.columns[static_cast<std::size_t>(column)]);
    calibration.scale = unit.factor;
    calibration.unit = unit.si;
    if (in_name && (in_name->si != unit.si || in_name->factor != unit.factor))
      calibration.remark =
          fmt::format("the column says {}, the sidecar {}: the sidecar was followed", in_name->name, unit.name);
  } else if (in_name) {
    calibration.scale = in_name->factor;
    calibration.unit = in_name->si;
  } else if (channel.role == Role::other) {
    calibration.remark = "no unit given; numbers taken as they are";
  } else if (base == to_string(channel.role)) {
    calibration.unit_is_assumed = true;
    calibration.unit = si_unit(channel.role);
    calibration.remark = fmt::format("no unit given; taken as {}", calibration.unit);
  } else {
    calibration.missing = fmt::format("unit = \"{}\"\n", example_unit(channel.role));
  }
  return calibration;
}

}  // namespace

double measured(const std::optional<Quantity>& quantity, const ChannelSpec& channel) {
  if (!quantity) return 0.0;
  const bool at_plug = channel.sensitivity && quantity->si == channel.sensitivity->electrical;
  return quantity->value / (at_plug ? channel.sensitivity->value : 1.0);
}

Calibration calibrate(const ChannelSpec& channel, const SourceInfo& source, int column) {
  const bool direct =
      channel.full_scale && !(channel.sensitivity && channel.full_scale->si == channel.sensitivity->electrical);
  Calibration calibration;
  if (direct && lacks_sensitivity(channel)) {
    calibration.missing = sensitivity_line(channel.role);
  } else if (direct) {
    calibration.scale = channel.full_scale->value;
    calibration.unit = channel.full_scale->si;
  } else {
    calibration = channel.sensitivity ? by_sensitivity(channel, source, column) : by_unit(channel, source, column);
  }
  if (channel.offset) calibration.shift = -measured(channel.offset, channel);
  calibration.scale *= channel.sign;
  calibration.shift *= channel.sign;
  return calibration;
}

}  // namespace dsp
