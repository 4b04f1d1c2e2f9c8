#pragma once
#include "ident/evidence/range_data.hpp"
#include "ident/validate/range_result.hpp"

namespace ident {

/// Sentences on the terms that least squares left out because others make them up.
void name_dependent(Fit& fit, const CandidateLibrary& library);

/// Candidates that would do as well as kept ones, and sensors that do the same as candidates.
void name_ties(JudgedFit& judged, const RFactor& data, const RangeData& range, const CandidateLibrary& library,
               const Poll& poll);

/// A sentence on the terms that the rows leave open.
void name_undecided(Fit& fit, const CandidateLibrary& library);

}  // namespace ident
