#pragma once
#include <cstddef>
#include <span>
#include <vector>

namespace dsp {

/// The value that half of the others do not exceed; of an even number the upper one. `values` must not be empty.
[[nodiscard]] double median(std::vector<double> values);

/// The value that `fraction` (0 to 1) of the others do not exceed; 0 where there are none.
[[nodiscard]] double quantile(std::vector<double> values, double fraction);

/// The same without a copy: `values` are reordered.
[[nodiscard]] double quantile_in_place(std::span<double> values, double fraction);

/// The same between the two nearest of at least two values in ascending order, linearly.
[[nodiscard]] double interpolated_quantile(std::span<const double> ascending, double fraction);

/// At most `most` of the items, drawn evenly in their order; all if there are no more.
template <class Item>
[[nodiscard]] std::vector<Item> drawn_evenly(const std::vector<Item>& items, std::size_t most) {
  if (items.size() <= most) return items;
  std::vector<Item> drawn;
  for (std::size_t k = 0; k < most; ++k) drawn.push_back(items[k * items.size() / most]);
  return drawn;
}

}  // namespace dsp
