#pragma once
#include <Eigen/Core>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/sensors/mount.hpp"

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

/// Samples [first, last) of one label.
struct Segment {
  Regime regime = Regime::low;
  Eigen::Index first = 0, last = 0;
  std::string reason;
  double probability = std::numeric_limits<double>::quiet_NaN();  ///< of the branch of low and high; NaN: not estimated
  /// Standard deviations of its ends; NaN: not estimated, as where an exclusion or the record ends.
  double first_std_s = std::numeric_limits<double>::quiet_NaN(), last_std_s = first_std_s;
};

/// Thresholds left at 0 are chosen from the record itself; the ones used come back in the Segmentation.
struct SegmentOptions {
  double stick_speed_m_per_s = 0.0;  ///< what comes to rest is looked for below this; given, nothing else shows it
  double stick_duration_s = 0.0;     ///< what halts for shorter is a reversal; 0: what noise and band allow to tell
  double high_amplitude_m = 0.0;     ///< an amplitude of x above this is high; 0: the branch is seen in the phase
};

/// Every sample has one label; segments follow one another without gap or overlap.
struct Segmentation {
  std::vector<Segment> segments;
  SegmentOptions options;            ///< with every threshold filled in
  std::vector<std::string> remarks;  ///< how thresholds were chosen, in sentences
  std::optional<Mount> mount;        ///< of the sensors; none: not looked for, as segments are not from the record
};

}  // namespace dsp
