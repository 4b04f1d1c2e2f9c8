#include "dsp/values/signals.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

namespace dsp {
namespace {

constexpr std::string_view of_base = "displacement of the base", of_payload = "displacement of the payload, absolute",
                           of_relative = "displacement of the payload relative to the base";

constexpr std::array<SignalInfo, 13> signal_infos{{
    {Role::other, "other", Body::none, -1, "", false, "", "any further channel of the recording, by its own name"},
    {Role::t, "t", Body::none, -1, "s", false, "t", "time from the start of the record, s"},
    {Role::r, "r", Body::base, 0, "m", false, "r", of_base},
    {Role::dr, "dr", Body::base, 1, "m/s", false, "\\dot{r}", of_base},
    {Role::ddr, "ddr", Body::base, 2, "m/s^2", true, "\\ddot{r}", of_base},
    {Role::y, "y", Body::payload, 0, "m", false, "y", of_payload},
    {Role::dy, "dy", Body::payload, 1, "m/s", false, "\\dot{y}", of_payload},
    {Role::ddy, "ddy", Body::payload, 2, "m/s^2", false, "\\ddot{y}", of_payload},
    {Role::x, "x", Body::relative, 0, "m", false, "x", of_relative},
    {Role::v, "v", Body::relative, 1, "m/s", false, "\\dot{x}", of_relative},
    {Role::a, "a", Body::relative, 2, "m/s^2", false, "\\ddot{x}", of_relative},
    {Role::f, "f", Body::none, -1, "N", true, "f", "measured force or input"},
    {Role::z, "z", Body::none, -1, "N", true, "z", "hysteretic force"},
}};

template <class Wanted>
const SignalInfo* find_if(Wanted wanted) {
  const auto* found = std::find_if(signal_infos.begin(), signal_infos.end(), wanted);
  return found == signal_infos.end() ? nullptr : found;
}

}  // namespace

std::span<const SignalInfo> signal_table() {
  return signal_infos;
}

const SignalInfo& info_of(Role role) {
  return *find_if([&](const SignalInfo& s) { return s.role == role; });
}

const SignalInfo* find_signal(std::string_view name) {
  return find_if([&](const SignalInfo& s) { return s.name == name; });
}

const SignalInfo& motion_signal(Body body, int order) {
  return *find_if([&](const SignalInfo& s) { return s.body == body && s.order == order; });
}

const SignalInfo* derivative_of(std::string_view name) {
  const SignalInfo* known = find_signal(name);
  if (known == nullptr || known->order < 0) return nullptr;
  return find_if([&](const SignalInfo& s) { return s.body == known->body && s.order == known->order + 1; });
}

std::string in_words(Role role) {
  const SignalInfo& signal = info_of(role);
  constexpr std::string_view displacement = "displacement";
  std::string words(signal.meaning);
  if (signal.order > 0) words.replace(0, displacement.size(), signal.order == 1 ? "velocity" : "acceleration");
  return words;
}

std::string_view to_string(Role role) {
  return info_of(role).name;
}

Role role_from_string(std::string_view name) {
  if (const SignalInfo* known = find_signal(name)) return known->role;
  std::string names;
  for (const SignalInfo& signal : signal_infos) names += (names.empty() ? "" : ", ") + std::string(signal.name);
  throw std::invalid_argument("role must be one of " + names + "; got '" + std::string(name) + "'");
}

}  // namespace dsp
