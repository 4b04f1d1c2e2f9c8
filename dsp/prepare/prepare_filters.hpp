#pragma once
#include <optional>

#include "dsp/prepare.hpp"

namespace dsp {

/// From the recording to the bus, for resolved options: flat to well above the states' band, and free of aliases as
/// far. None where the bus is the recording.
[[nodiscard]] std::optional<DecimateOptions> to_bus(const PrepareOptions& options, double sample_rate_hz);

/// From the bus to the regression rate. None where they are one.
[[nodiscard]] std::optional<DecimateOptions> to_regression(const PrepareOptions& options);

}  // namespace dsp
