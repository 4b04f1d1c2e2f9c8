#pragma once

namespace dsp {

/// What a person says of the steps of a time column: even; uneven, to be interpolated; a row whenever something moved,
/// so that nothing is missing however long a step is.
enum class ClockKind { regular, interpolate, events };

}  // namespace dsp
