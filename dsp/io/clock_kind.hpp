#pragma once

namespace dsp {

/// What a person says of the steps of a time column: even; uneven, to be interpolated; a row whenever something moved,
/// so that nothing is missing however long a step is.
enum class ClockKind { regular, interpolate, events };

/// Of several runs side by side in a table: every one, each a recording of its own.
inline constexpr int all_runs = -1;

}  // namespace dsp
