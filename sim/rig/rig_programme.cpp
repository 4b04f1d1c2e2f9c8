#include "sim/rig/rig_programme.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace sim {
namespace {

using Settings = std::vector<std::pair<std::string, double>>;

std::optional<double> take(Settings& settings, std::string_view name) {
  std::optional<double> value;
  std::erase_if(settings, [&](const auto& setting) {
    if (setting.first != name) return false;
    value = setting.second;
    return true;
  });
  return value;
}

/// An even ladder from from_hz to to_hz, either way.
std::vector<double> ladder(double from_hz, double to_hz, double step_hz) {
  const double count = std::round(std::abs(to_hz - from_hz) / step_hz);
  if (!(step_hz > 0.0 && from_hz > 0.0 && to_hz > 0.0 && count <= 1e4))
    throw std::invalid_argument(
        fmt::format("qzs: from_hz, to_hz and step_hz must be positive and make at most 10000 steps, got {}, {} and {}",
                    from_hz, to_hz, step_hz));
  std::vector<double> frequencies;
  for (int k = 0; k <= static_cast<int>(count); ++k)
    frequencies.push_back(from_hz + (to_hz < from_hz ? -k : k) * step_hz);
  return frequencies;
}

Programme stepped(bool up, Settings& settings) {
  const double amplitude_m = 1e-3 * take(settings, "amplitude_mm").value_or(4.5);
  const double dwell_s = take(settings, "dwell_s").value_or(40.0);
  const auto from_hz = take(settings, "from_hz"), to_hz = take(settings, "to_hz"), step_hz = take(settings, "step_hz");
  if (!from_hz && !to_hz && !step_hz)
    return up ? stepped_sine_up(amplitude_m, dwell_s) : stepped_sine_down(amplitude_m, dwell_s);
  const double low_hz = 0.8, high_hz = up ? 1.6 : 1.84;
  const double first = from_hz.value_or(up ? low_hz : high_hz), last = to_hz.value_or(up ? high_hz : low_hz);
  if (up ? first > last : first < last)
    throw std::invalid_argument(
        fmt::format("qzs: programme {} cannot go from {} to {} Hz", up ? "up" : "down", first, last));
  Programme programme = stepped_sine(
      {.frequencies_hz = ladder(first, last, step_hz.value_or(0.01)), .amplitude_m = amplitude_m, .dwell_s = dwell_s});
  programme.name = up ? "stepped sine, up" : "stepped sine, down";
  return programme;
}

}  // namespace

Programme rig_programme(std::string_view name, Settings& settings) {
  for (const auto& [key, value] : settings)
    if (key == "amplitude_mm" && !(value > 0.0))
      throw std::invalid_argument(fmt::format("qzs: amplitude_mm must be positive, got {}", value));
  if (name == "down" || name == "up") return stepped(name == "up", settings);
  if (name != "decay")
    throw std::invalid_argument(fmt::format("qzs: no programme \"{}\"; there are down, up, decay", name));
  Releases releases;
  if (const auto value = take(settings, "amplitude_mm")) releases.amplitude_m = 1e-3 * *value;
  if (const auto value = take(settings, "dwell_s")) releases.dwell_s = *value;
  if (const auto value = take(settings, "releases")) {
    if (*value != std::floor(*value) || !(*value >= 1.0 && *value <= 10000.0))
      throw std::invalid_argument(fmt::format("qzs: releases must be a whole number from 1 to 10000, got {}", *value));
    releases.num_releases = static_cast<int>(*value);
  }
  return free_decay(releases);
}

std::string_view programme_settings(std::string_view name) {
  return name == "decay" ? "amplitude_mm, dwell_s, releases" : "amplitude_mm, dwell_s, from_hz, to_hz, step_hz";
}

}  // namespace sim
