#pragma once
#include "dsp/filter/decimate.hpp"

namespace apps {

/// Magnitude of a decimation at a frequency of its input, all stages together, from their coefficients: 20 log10 |H|,
/// not below -200 dB.
[[nodiscard]] double gain_db(const dsp::FilterSheet& sheet, double frequency_hz);

}  // namespace apps
