#pragma once
#include <vector>

#include "ident/records/record.hpp"
#include "ident/validate/range_result.hpp"

namespace ident {

/// Fits each method on the training rows of a range and judges all but what other ranges say of it (judgement).
/// `recordings` are the columns of each recording, of one library; their switches are placed where the first method's
/// equation of this range has them (place_switches), and stay so. Throws dsp::Fault as range_rows does, and (numerics,
/// "library.nothing_left") where no candidate is left.
[[nodiscard]] RangeResult identify(const Range& range, std::vector<Columns>& recordings,
                                   const CandidateLibrary& library, const IdentifyOptions& options);

/// Each range, on a copy of its columns, judged beside the others; several at a time where there are threads.
[[nodiscard]] std::vector<RangeResult> identify(const std::vector<Range>& ranges,
                                                const std::vector<Columns>& recordings, const CandidateLibrary& library,
                                                const IdentifyOptions& options);

/// The usual case in one call: the ranges of a record (its own, else default_ranges), about the zero of x that a
/// difference of two displacements needs, by the library given; judged. Throws as record_library, record_columns
/// and identify do; target_unit is the record's.
[[nodiscard]] std::vector<RangeResult> identify(Record record, const LibraryOptions& library,
                                                IdentifyOptions options = {});

}  // namespace ident
