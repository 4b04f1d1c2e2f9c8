#pragma once
#include <optional>
#include <vector>

#include "ident/validate/range_result.hpp"

namespace ident {

struct RangeData;

/// Of the training rows of a range: `data` has its candidates. It speaks for one equation for a body whose relative
/// displacement, velocity or acceleration was recorded, with inputs that were recorded too or none, and where the fit
/// reached the channels' own noise.
/// Where something remains that the equation does not explain, or the fit did not reach the channels' noise, the zero
/// of a displacement may wander, if no recorded signal is missing and the record is likelier by the price of a term.
/// Where something remains then, terms that are not worth their price by the variances of Likelihood are left out.
[[nodiscard]] Likelihood likelihood_of(const Range& range, const RangeRows& rows, const RangeData& data,
                                       const std::vector<Columns>& recordings, const IdentifyOptions& options);

/// The equation through the recorded samples of further rows. Nothing where it cannot be told.
[[nodiscard]] std::optional<RecordedRun> run_through(const Likelihood& likelihood, const Range& range,
                                                     const std::vector<Row>& rows, const RangeData& data,
                                                     const std::vector<Columns>& recordings, int num_threads);

}  // namespace ident
