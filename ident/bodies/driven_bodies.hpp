#pragma once
#include <string>
#include <vector>

#include "ident/bodies/bodies.hpp"
#include "ident/equation/equation_oscillator.hpp"
#include "sim/ode/driven.hpp"

namespace ident {

/// What a sine can drive: the inputs by their names; "r" is the base's displacement, whatever of its motion they are.
[[nodiscard]] std::vector<std::string> drives_of(const BodiesLayout& layout);

/// A base or a force, by such a name.
[[nodiscard]] DriveKind kind_of_drive(const std::string& drive);

/// The equations driven by a sine of one input, every other at zero, looked at in one body (from 1): x relative to the
/// base where it moves, y absolute. Owns what it needs; not to be shared between threads. Throws dsp::Fault (usage,
/// "frc.equation") for an imposed motion, terms of t and a drive that no term looks at, (usage, "term.*") for terms
/// that cannot be read.
[[nodiscard]] sim::DrivenSystem driven_bodies(const BodiesModel& model, const std::string& drive, int body);

}  // namespace ident
