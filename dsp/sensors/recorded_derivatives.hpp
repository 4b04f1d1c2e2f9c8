#pragma once
#include <vector>

#include "dsp/recording.hpp"
#include "dsp/samples/raw_spectrum.hpp"

namespace dsp {

/// A recorded velocity is kept only where it is the derivative of the displacement recorded beside it: where both
/// differ, up to cutoff_hz, by more than three times what the displacement's noise makes (smoothed, lagging or badly
/// scaled as the one may be), the motion of one sensor agrees with itself and a mixture of two does not. The velocity
/// then loses its role; the checks, "sensor.derivative", say so. Where the noise is not seen nothing changes.
/// `spectrum`: of the recording's channels, at the rate of its file.
[[nodiscard]] std::vector<Check> drop_unlike_derivatives(Recording& recording, const RawSpectrum& spectrum,
                                                         double cutoff_hz);

}  // namespace dsp
