#pragma once
#include <vector>

#include "ident/evidence/range_data.hpp"

namespace ident {

/// The data of a range with the switches where its own equation has them and the sensors' columns of that equation:
/// fitted by the first method, formed and fitted again, until both agree or eight times (AndersonMixing). The switches
/// of `recordings` stay so. Throws as identify does.
[[nodiscard]] RangeData iterate_columns(const Range& range, RangeResult& result, std::vector<Columns>& recordings,
                                        const CandidateLibrary& library, const IdentifyOptions& options);

}  // namespace ident
