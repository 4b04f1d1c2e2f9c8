#include "dsp/values/order_statistics.hpp"

#include <algorithm>
#include <cstddef>

namespace dsp {
namespace {

double nth(std::span<double> values, std::size_t n) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(n);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

double median(std::vector<double> values) {
  return nth(values, values.size() / 2);
}

double quantile(std::vector<double> values, double fraction) {
  return quantile_in_place(values, fraction);
}

double quantile_in_place(std::span<double> values, double fraction) {
  return values.empty() ? 0.0
                        : nth(values, static_cast<std::size_t>(fraction * static_cast<double>(values.size() - 1)));
}

double interpolated_quantile(std::span<const double> ascending, double fraction) {
  const double position = fraction * static_cast<double>(ascending.size() - 1);
  const auto k = std::min(static_cast<std::size_t>(position), ascending.size() - 2);
  return ascending[k] + (position - static_cast<double>(k)) * (ascending[k + 1] - ascending[k]);
}

}  // namespace dsp
