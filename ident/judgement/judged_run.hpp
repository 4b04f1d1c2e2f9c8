#pragma once
#include <vector>

#include "ident/evidence/range_data.hpp"
#include "ident/validate/free_run.hpp"
#include "ident/validate/range_result.hpp"

namespace ident {

/// The free run that an equation is judged by, or that of an earlier method which found the same one: through the test
/// rows, and of an equation that nothing drives through the training rows as well, as test rows of a steady motion show
/// one amplitude only, which many equations keep. One with inputs that misses is set to the measured state before its
/// errors have grown tenfold.
[[nodiscard]] FreeRun judged_run(const JudgedFit& judged, const RangeResult& result, const RangeData& range,
                                 const std::vector<Course>& courses, const std::vector<Columns>& recordings,
                                 const IdentifyOptions& options);

}  // namespace ident
