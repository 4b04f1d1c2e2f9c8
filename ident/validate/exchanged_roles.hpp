#pragma once
#include <optional>
#include <vector>

#include "ident/columns/columns.hpp"
#include "ident/ranges/ranges.hpp"

namespace ident {

/// What is called the base moves as a payload on what is called the payload would: springs, dampers and friction
/// between the two (1, x, v, x^3, sgn(v)) and recorded forces leave a fraction of its acceleration that is below a
/// half, and in power below a quarter of what they and that acceleration leave of x''. The fraction; nothing where it
/// is not so, where a recording has no base, or has x, v or a from a sensor of their own, which would be the same
/// either way.
[[nodiscard]] std::optional<double> exchanged_roles(const std::vector<Row>& rows,
                                                    const std::vector<Columns>& recordings);

}  // namespace ident
