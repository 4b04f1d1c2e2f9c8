#include "dsp/regimes/regime.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <stdexcept>

namespace dsp {
namespace {

constexpr std::array<RegimeInfo, 4> regime_infos{{{Regime::low, "low", true},
                                                  {Regime::high, "high", true},
                                                  {Regime::stick, "stick", false},
                                                  {Regime::excluded, "excluded", false}}};
constexpr std::string_view mixed_name = "mixed";

[[noreturn]] void refuse(const std::vector<std::string>& names, std::string_view got) {
  throw std::invalid_argument(fmt::format("regime must be one of {}; got '{}'", fmt::join(names, ", "), got));
}

}  // namespace

std::span<const RegimeInfo> regime_table() {
  return regime_infos;
}

std::string_view to_string(Regime regime) {
  return std::find_if(regime_infos.begin(), regime_infos.end(), [&](const RegimeInfo& r) { return r.regime == regime; })
      ->name;
}

Regime regime_from_string(std::string_view name) {
  std::vector<std::string> names;
  for (const RegimeInfo& known : regime_infos) {
    if (known.name == name) return known.regime;
    names.emplace_back(known.name);
  }
  refuse(names, name);
}

RegimeSet RegimeSet::mixed() {
  RegimeSet set;
  for (const RegimeInfo& known : regime_infos)
    if (known.moving) set.bits_ |= bit(known.regime);
  return set;
}

std::string RegimeSet::name() const {
  if (any()) return {};
  for (const RegimeInfo& known : regime_infos)
    if (*this == RegimeSet(known.regime)) return std::string(known.name);
  return std::string(mixed_name);
}

std::vector<std::string> regime_set_names() {
  std::vector<std::string> names{""};
  for (const RegimeInfo& known : regime_infos)
    if (known.regime != Regime::excluded) names.emplace_back(known.name);
  names.emplace_back(mixed_name);
  return names;
}

RegimeSet regime_set_from_string(std::string_view name) {
  if (name.empty()) return {};
  if (name == mixed_name) return RegimeSet::mixed();
  return regime_from_string(name);
}

}  // namespace dsp
