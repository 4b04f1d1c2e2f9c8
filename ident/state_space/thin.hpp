#pragma once
#include "ident/state_space/problem.hpp"

namespace ident::state_space {

/// Every how many-th sample says as much, when what is above is filtered away: up to a quarter of the lower rate the
/// spectra of all channels must have fallen to their noise, and those of all inputs to it or to 1e-10 of their power;
/// the quarter above shows the noise. 1 where samples are missing or an acceleration is recorded, which jumps where
/// friction turns and shows it at all frequencies, if under noise; never so that less than a thousand are left.
[[nodiscard]] Eigen::Index thinning(const Problem& problem);

/// Of every record each `factor`-th sample behind a low-pass that ends at half the lower rate, without the first and
/// last 8, which lean on what was before the record and behind it; records that would have fewer than 16 are left out.
/// Throws std::invalid_argument for a factor below 1.
[[nodiscard]] Problem thinned(Problem problem, Eigen::Index factor);

}  // namespace ident::state_space
