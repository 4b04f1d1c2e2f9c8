#pragma once
#include <optional>
#include <vector>

#include "dsp/values/recording.hpp"

namespace dsp {

/// Recognises bodies by number: x1, x_2, mass_1, floor_3, "displacement 2", beside them v1, a1 and so on. Where open
/// displacements are numbered 1 to n, n at least 2, each once, they get role x (y where they are called so) and their
/// body, a velocity or acceleration of that number too, a displacement number 0 the role r; SI units where they have
/// none. `is_known` becomes true of these. A check "channel.role" (note) says it for each.
[[nodiscard]] std::vector<Check> assume_bodies(std::vector<Channel>& channels, std::vector<bool>& is_known);

/// The question that is left where displacements are numbered, but not from 1 to n; nothing where they are not, or have
/// their bodies. Its lines() are [[channel]] tables for a sidecar.
[[nodiscard]] std::optional<Fault> bodies_question(const std::string& recording, const std::vector<Channel>& channels);

/// Throws Fault recording.bodies (input) for a recording of several bodies.
void require_one_body(const Recording& recording);
[[nodiscard]] bool has_bodies(const Recording& recording);

}  // namespace dsp
