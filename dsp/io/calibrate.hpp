#pragma once
#include <optional>
#include <string>

#include "dsp/io/sample_source.hpp"
#include "dsp/io/sidecar.hpp"
#include "dsp/values/recording.hpp"

namespace dsp {

/// What turns the numbers of one column into SI: value = number x scale + shift.
struct Calibration {
  double scale = 1.0, shift = 0.0;
  std::string unit;  ///< SI, empty where nobody knows it
  bool calibrated = true;
  bool unit_is_assumed = false;  ///< SI, because the column is called like a role and nobody said another
  std::string missing;           ///< sidecar lines that would complete it; not empty: it cannot be done
  std::string remark;            ///< what had to be taken as given
};

/// A quantity that was said at the plug or after calibration, as what the channel measures (SI); 0 where there is none.
[[nodiscard]] double measured(const std::optional<Quantity>& quantity, const ChannelSpec& channel);

/// From a sidecar's channel and what the file says of the column (0-based), in this order: sensitivity and full scale,
/// a full scale in the measured unit, the sidecar's unit, the unit in the column's name, SI where the name is the role
/// itself. Integers of a sound file mean nothing without a full scale. Throws Fault calibration.twice (usage) where a
/// sensitivity is given for a column that already is in the measured unit, unit.kind where the sidecar and the
/// column state units of different kinds; a single letter behind a name, "acc_V", counts only where the sidecar does
/// not state another kind.
[[nodiscard]] Calibration calibrate(const ChannelSpec& channel, const SourceInfo& source, int column);

}  // namespace dsp
