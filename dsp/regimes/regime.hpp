#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace dsp {

enum class Regime {
  low,       ///< moving, lower amplitude branch
  high,      ///< moving, upper amplitude branch
  stick,     ///< locked, or stopping so often that friction is not at its sliding value
  excluded,  ///< not to be used: faults, annotations, start transient
};

/// One line of the table of regimes, the only list of them.
struct RegimeInfo {
  Regime regime;
  std::string_view name;
  bool moving;  ///< equations are identified there
};
[[nodiscard]] std::span<const RegimeInfo> regime_table();
[[nodiscard]] std::string_view to_string(Regime regime);
/// Throws std::invalid_argument for a name that is none of them, listing them.
[[nodiscard]] Regime regime_from_string(std::string_view name);

/// The regimes whose samples a range takes in.
class RegimeSet {
 public:
  RegimeSet() = default;                      ///< any sample, whatever its regime
  RegimeSet(Regime one) : bits_(bit(one)) {}  // NOLINT: a regime is a set of one
  [[nodiscard]] static RegimeSet mixed();     ///< all regimes of motion
  [[nodiscard]] bool any() const { return bits_ == 0; }
  [[nodiscard]] bool holds(Regime regime) const { return any() || (bits_ & bit(regime)) != 0; }
  [[nodiscard]] bool meets(const RegimeSet& other) const { return any() || other.any() || (bits_ & other.bits_) != 0; }
  /// "" (any), "low" ..., "mixed".
  [[nodiscard]] std::string name() const;
  bool operator==(const RegimeSet&) const = default;

 private:
  static unsigned bit(Regime regime) { return 1U << static_cast<unsigned>(regime); }
  unsigned bits_ = 0;
};
/// What a range may name: "" (any), every regime but excluded, "mixed".
[[nodiscard]] std::vector<std::string> regime_set_names();
/// Throws std::invalid_argument for any other name.
[[nodiscard]] RegimeSet regime_set_from_string(std::string_view name);

}  // namespace dsp
