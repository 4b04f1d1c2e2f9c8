#pragma once
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "ident/validate/range_result.hpp"

// What the equations of several ranges, found by one method from one library, say of one another.

namespace ident {

/// The equations of two ranges as they are beside one another: that of a recording, where one range is of it alone.
[[nodiscard]] std::pair<Model, Model> comparable(const RangeResult& a, const RangeResult& b, std::size_t method);

struct Agreement {
  bool other = false;  ///< some range that shares no samples with this one has another equation
  std::string clause;  ///< which one and in what, or which ones agree; empty: there is no such range
};
/// Of one range with the others. Equations are the same where the terms that matter (5 % of the target's largest or
/// more) are in both and within 10 %.
[[nodiscard]] Agreement agreement(const std::vector<RangeResult>& ranges, std::size_t range, std::size_t method);

/// The terms that matter, dry friction aside, whose coefficients for each recording are more than 10 % apart. Friction
/// is another from day to day; of one machine springs, dampers and masses are not.
[[nodiscard]] std::vector<OwnCoefficients> apart_by_recording(const RangeResult& range, const Model& model);

}  // namespace ident
