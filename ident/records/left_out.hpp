#pragma once
#include <vector>

#include "ident/records/record.hpp"

namespace ident {

/// "regime.left_out": which fraction of a record is used in no range of its regimes, and why: its ends, what is
/// excluded by each reason, stops. A warning with the setting to change from a quarter on, else a note.
[[nodiscard]] dsp::Check left_out(const Record& record);

/// A check of a range, which one of its recordings gives.
struct RangeCheck {
  std::size_t recording = 0;  ///< its index
  dsp::Check check;
};
/// Warnings "range.scarce" about ranges of which less than a tenth of the time that they were given is left, with the
/// setting to change: that for the reason which takes most of the range, in the recording where it takes most.
[[nodiscard]] std::vector<RangeCheck> scarce_ranges(const std::vector<Range>& ranges,
                                                    const std::vector<const Record*>& records);

}  // namespace ident
