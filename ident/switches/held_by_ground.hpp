#pragma once
#include <optional>

#include "dsp/prepare.hpp"
#include "dsp/segment_regimes.hpp"
#include "dsp/sensors/motion.hpp"
#include "dsp/values/fault.hpp"

namespace ident {

/// Regimes of the payload's own motion (y), where that of its base (r) is known, too.
[[nodiscard]] std::optional<dsp::Segmentation> absolute_regimes(const dsp::Motion& motion);
/// The same without a copy of its signals: until it returns they are not in `motion`.
[[nodiscard]] std::optional<dsp::Segmentation> absolute_regimes_in_place(dsp::Motion& motion);

/// The warning "regime.ground" where the payload stands still while its base moves, for a twentieth of the time or
/// more: it is held by the ground, its friction is that of the absolute speed, and what holds it is not in the
/// equation. `absolute`: its absolute_regimes at the intermediate rate.
[[nodiscard]] std::optional<dsp::Check> held_by_ground(const dsp::Prepared& prepared,
                                                       const dsp::Segmentation& absolute);

/// Of each sample at the intermediate rate, the fraction for which the ground does not hold the payload; empty where it
/// does so for less than a twentieth of the time. A slip begins and ends where the speed, carried on straight, is zero.
[[nodiscard]] Eigen::VectorXd slipping_fraction(const dsp::Prepared& prepared);

}  // namespace ident
