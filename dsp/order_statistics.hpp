#pragma once
#include <span>
#include <vector>

namespace dsp {

/// The value that half of the others do not exceed; of an even number the upper one. `values` must not be empty.
[[nodiscard]] double median(std::vector<double> values);

/// The value that `share` (0 to 1) of the others do not exceed; 0 where there are none.
[[nodiscard]] double quantile(std::vector<double> values, double share);

/// The same without a copy: `values` are reordered.
[[nodiscard]] double quantile_in_place(std::span<double> values, double share);

}  // namespace dsp
