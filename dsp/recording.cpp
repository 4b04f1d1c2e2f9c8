#include "dsp/recording.hpp"

#include <array>
#include <utility>

namespace dsp {
namespace {
constexpr std::array<std::pair<Role, std::string_view>, 13> role_names{{{Role::other, "other"},
                                                                        {Role::t, "t"},
                                                                        {Role::r, "r"},
                                                                        {Role::dr, "dr"},
                                                                        {Role::ddr, "ddr"},
                                                                        {Role::y, "y"},
                                                                        {Role::dy, "dy"},
                                                                        {Role::ddy, "ddy"},
                                                                        {Role::x, "x"},
                                                                        {Role::v, "v"},
                                                                        {Role::a, "a"},
                                                                        {Role::f, "f"},
                                                                        {Role::z, "z"}}};
}  // namespace

std::string_view to_string(Role role) {
  for (const auto& [value, name] : role_names)
    if (value == role) return name;
  return "other";
}

Role role_from_string(std::string_view name) {
  std::string known;
  for (const auto& [value, text] : role_names) {
    if (text == name) return value;
    known += known.empty() ? std::string(text) : ", " + std::string(text);
  }
  throw std::invalid_argument("role must be one of " + known + "; got '" + std::string(name) + "'");
}

Eigen::Index Recording::find(Role role) const {
  for (std::size_t i = 0; i < channels.size(); ++i)
    if (channels[i].role == role) return static_cast<Eigen::Index>(i);
  return -1;
}

}  // namespace dsp
