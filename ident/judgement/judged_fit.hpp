#pragma once
#include <vector>

#include "ident/evidence/range_data.hpp"
#include "ident/validate/range_result.hpp"

namespace ident {

/// One method on a range: fit, model, errors, free run, and all that is told of them but the judgement, which compares
/// ranges. `result`: of the range, with the fits of the methods before; of a free run that one of them has made, the
/// series are with that one.
[[nodiscard]] JudgedFit judged_fit(const MethodOptions& method, const RangeResult& result, const RangeData& range,
                                   const std::vector<Columns>& recordings, const CandidateLibrary& library,
                                   const IdentifyOptions& options);

}  // namespace ident
