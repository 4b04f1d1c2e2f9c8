#pragma once

namespace ident {

/// Standard deviations to either side that hold 95 % of a normal distribution.
inline constexpr double interval_95 = 1.96;

}  // namespace ident
