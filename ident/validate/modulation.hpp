#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "ident/columns/columns.hpp"
#include "ident/ranges/ranges.hpp"

namespace ident {

/// Of a stiffness that follows a clock (Mathieu's equation), x cos(w t + phase): w, rad/s, with which it fits best what
/// an equation leaves of its target on these rows, to an eighth of a period on them, two periods or more. Nothing where
/// white noise has one as good once in a thousand records, where x is no signal, or the rows are of several recordings,
/// of which each has a clock of its own.
[[nodiscard]] std::optional<double> modulation_rad_s(const Eigen::Ref<const Eigen::VectorXd>& residual,
                                                     const std::vector<Row>& rows,
                                                     const std::vector<Columns>& recordings);

}  // namespace ident
