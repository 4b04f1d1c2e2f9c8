#pragma once
#include <optional>

#include "dsp/prepare/prepared.hpp"

namespace dsp {

/// From the recording to the intermediate rate, for resolved options: flat to well above the states' band, and free of
/// aliases as far. None where the intermediate rate is the recording's.
[[nodiscard]] std::optional<DecimateOptions> to_intermediate(const PrepareOptions& options, double sample_rate_hz);

/// From the intermediate rate to the regression rate. None where they are one.
[[nodiscard]] std::optional<DecimateOptions> to_regression(const PrepareOptions& options);

/// What signals at the intermediate rate pass through to become target and columns: to_regression, or a taper to the
/// cut-off.
[[nodiscard]] ColumnFilter column_filter(const PrepareOptions& options);
/// Where that taper lies.
[[nodiscard]] SpectralBand column_band(const PrepareOptions& options);

}  // namespace dsp
