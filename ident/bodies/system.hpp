#pragma once
#include <functional>

#include "ident/bodies/bodies.hpp"
#include "sim/ode/system.hpp"

namespace ident {

/// Of every input of a layout: its value at a time, and its rate there; NaN where that is not known, and no switch that
/// looks at it can then be held.
using InputsAt = std::function<void(double t, double* values, double* rates)>;

/// The equations as a system to integrate: states x1, v1, x2, v2 ... z, everything that jumps or bends located. Where a
/// sgn(g) of a speed pushes g back from either side, its side in between is the one that keeps g at zero (Filippov):
/// two bodies that friction holds together go on together. Where several hold and one of them is held by the others
/// alone, its side is 0. Throws std::invalid_argument for more switches than sim::max_switches, dsp::Fault (usage,
/// "term.*") for terms that cannot be read.
[[nodiscard]] sim::System system_of(const BodiesModel& model, InputsAt inputs_at);

}  // namespace ident
