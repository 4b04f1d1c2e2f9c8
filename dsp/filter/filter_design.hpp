#pragma once
#include <Eigen/Core>
#include <vector>

#include "dsp/filter/decimate.hpp"

namespace dsp {

/// The stages that meet the options for this input rate, cheapest split of the ratio found by trying all. The first
/// stage of a ratio of 8 or more is a sinc^4 (four cascaded means), whose zeros lie on what would fold; the next stage
/// carries the inverse of its droop. The others are Kaiser-windowed sincs with 10 dB to spare. Throws
/// std::invalid_argument as Decimator does.
[[nodiscard]] std::vector<FilterStage> design_decimation(double input_rate_hz, const DecimateOptions& options);

/// Whether there is such a design within bounds: the ratio is a fraction of whole numbers, its last stage (taps per
/// output x phases) has at most 2^18 coefficients, and the whole with its data sheet takes seconds at most. Throws
/// std::invalid_argument for bands that do not fit the rates.
[[nodiscard]] bool is_designable(double input_rate_hz, const DecimateOptions& options);

/// Gain of the cascade at a frequency of its input, from the taps.
[[nodiscard]] double cascade_gain(const std::vector<FilterStage>& stages, double frequency_hz);

/// The data sheet of the cascade.
[[nodiscard]] FilterSheet measure(std::vector<FilterStage> stages, double input_rate_hz,
                                  const DecimateOptions& options);

}  // namespace dsp
