#pragma once
#include <vector>

#include "dsp/samples/raw_spectrum.hpp"
#include "dsp/values/recording.hpp"

namespace dsp {

/// A recorded velocity is kept only where it is the derivative of the displacement recorded beside it. Where both
/// differ, up to cutoff_hz and but for a gain, by more than 0.3 % and by more than three times what the displacement's
/// noise makes, the one is smoothed or lags; the motion of one sensor agrees with itself and a mixture of two does not.
/// The velocity then loses its role; the checks, "sensor.derivative", say so. Where the noise is not seen, and where
/// sign or unit are wrong, nothing changes. Known delays must have been removed. `spectrum`: of the recording's
/// channels, at the rate of its file.
[[nodiscard]] std::vector<Check> drop_unlike_derivatives(Recording& recording, const RawSpectrum& spectrum,
                                                         double cutoff_hz);

}  // namespace dsp
