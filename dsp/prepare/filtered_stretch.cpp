#include "dsp/prepare/filtered_stretch.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "dsp/filter/decimate_between.hpp"

namespace dsp {
namespace {

using Eigen::Index;

/// With what a high-pass has not forgotten, and so much behind that what is predicted further on, unlike the record
/// itself by and by, does not ring back.
Stretch with_memory(const Prepared& prepared, const Stretch& wanted) {
  if (prepared.highpass_hz.empty()) return wanted;
  constexpr double rows_behind = 64.0;
  constexpr double forgotten = 1e-12;
  const double slowest_hz = *std::min_element(prepared.highpass_hz.begin(), prepared.highpass_hz.end());
  // Two in a row forget as t exp(-w t): a few time constants more.
  const double constants = -std::log(forgotten) + 4.0 * static_cast<double>(prepared.highpass_hz.size() - 1);
  return {wanted.from_s - constants / (2.0 * std::numbers::pi * slowest_hz),
          wanted.to_s + rows_behind / prepared.filter.output_rate_hz()};
}

/// The whole part of an index, within [0, most].
Index within(double index, Index most) {
  return static_cast<Index>(std::clamp(index, 0.0, static_cast<double>(most)));
}

}  // namespace

Stretch input_interval(const Prepared& prepared, const Stretch& wanted) {
  if (prepared.filter.sheet().stages.empty()) return {};  // a taper reaches on and on
  return with_memory(prepared, wanted).wider(prepared.filter.edge_s());
}

Eigen::MatrixXd filtered_within(const Prepared& prepared, const Stretch& wanted, Index num_signals,
                                const std::function<Eigen::MatrixXd(Index first, Index count)>& read) {
  const ColumnFilter& filter = prepared.filter;
  const Index num_samples = prepared.intermediate.num_samples();
  if (filter.sheet().stages.empty()) return filter.apply(num_samples, num_signals, read);
  const Stretch low_passed = with_memory(prepared, wanted);
  const Index num_rows = prepared.signals.num_samples();
  const double rate_hz = filter.output_rate_hz();
  // A time that is that of a row may lie a rounding before it or behind.
  const Index first = within(low_passed.from_s * rate_hz, num_rows),
              end = within(low_passed.to_s * rate_hz + 2.0, num_rows);
  Eigen::MatrixXd columns =
      decimate_between(first, std::max(first, end), num_samples, num_signals, read, filter.sheet());
  constexpr Index fewest = 8;  // of a transform
  for (Index c = 0; c < columns.cols() && end - first >= fewest; ++c)
    columns.col(c).segment(first, end - first) = filter.high_passed(columns.col(c).segment(first, end - first));
  return columns;
}

}  // namespace dsp
