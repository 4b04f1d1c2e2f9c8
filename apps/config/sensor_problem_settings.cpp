#include "apps/config/sensor_problem_settings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string_view>

namespace apps {
namespace {

using Kind = sim::SensorProblem::Kind;

std::optional<Kind> kind_of(std::string_view key) {
  if (key == "rail") return Kind::rail;
  if (key == "hold") return Kind::hold;
  if (key == "clip") return Kind::clip;
  return std::nullopt;
}

std::vector<std::string_view> split(std::string_view text) {
  std::vector<std::string_view> parts;
  for (std::size_t colon; (colon = text.find(':')) != std::string_view::npos; text.remove_prefix(colon + 1))
    parts.push_back(text.substr(0, colon));
  parts.push_back(text);
  return parts;
}

int channel_of(std::string_view text) {
  const auto sensors = sim::rig_sensors(sim::SensorLevel::ideal, {});
  std::string known;
  for (int c = 0; c < sim::num_raw_channels; ++c) {
    const std::string& name = sensors[static_cast<std::size_t>(c)].name;
    if (text == name || text == std::to_string(c + 1)) return c;
    known += (c > 0 ? ", " : "") + name;
  }
  throw std::invalid_argument(fmt::format("--set: no channel \"{}\", there are {} (1 to 4)", text, known));
}

double number_of(std::string_view text, std::string_view setting) {
  double value = 0.0;
  const char* end = text.data() + text.size();
  if (text.empty() || std::from_chars(text.data(), end, value).ptr != end || !std::isfinite(value) || value < 0.0)
    throw std::invalid_argument(
        fmt::format("--set: got \"{}\" in \"{}\", want a number that is not negative", text, setting));
  return value;
}

sim::SensorProblem problem_of(Kind kind, std::string_view value, std::string_view setting) {
  const auto parts = split(value);
  const bool clip = kind == Kind::clip;
  if (parts.size() != (clip ? 4 : 3))
    throw std::invalid_argument(fmt::format("--set: got \"{}\", want {}", setting,
                                            clip ? "clip=CHANNEL:FROM:TO:VOLTS" : "KEY=CHANNEL:FROM:TO"));
  sim::SensorProblem problem{kind, channel_of(parts[0]), number_of(parts[1], setting), number_of(parts[2], setting)};
  if (clip) problem.limit_v = number_of(parts[3], setting);
  if (!(problem.from_s < problem.to_s))
    throw std::invalid_argument(fmt::format("--set: \"{}\" ends before it begins", setting));
  return problem;
}

}  // namespace

std::vector<sim::SensorProblem> take_sensor_problems(std::vector<std::string>& settings) {
  std::vector<sim::SensorProblem> problems;
  std::vector<std::string> others;
  for (const std::string& setting : settings) {
    const auto equals = std::min(setting.find('='), setting.size());
    if (const auto kind = kind_of(std::string_view(setting).substr(0, equals)); kind && equals < setting.size())
      problems.push_back(problem_of(*kind, std::string_view(setting).substr(equals + 1), setting));
    else
      others.push_back(setting);
  }
  settings = std::move(others);
  return problems;
}

}  // namespace apps
