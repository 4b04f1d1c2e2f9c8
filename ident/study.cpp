#include "ident/study.hpp"

#include <algorithm>
#include <utility>

#include "dsp/fault.hpp"

namespace ident {
namespace {

/// The columns of one library on all records.
struct FormedColumns {
  LibraryOptions options;
  std::string target;
  std::vector<CandidateLibrary> libraries;
  std::vector<Columns> columns;
};

/// Those of a case, formed where no case before had the same.
FormedColumns& columns_of(const StudyCase& one, const std::vector<const Record*>& records, std::size_t max_memory_bytes,
                          std::vector<FormedColumns>& known) {
  const std::string& target = one.options.target;
  const auto same = std::find_if(known.begin(), known.end(), [&](const FormedColumns& formed) {
    return formed.options == one.library && formed.target == target;
  });
  if (same != known.end()) return *same;
  FormedColumns formed{one.library, target, {}, {}};
  for (const Record* record : records)
    formed.libraries.push_back(record_library(one.library, target, record->prepared));
  for (std::size_t i = 0; i < records.size(); ++i)
    formed.columns.push_back(
        record_columns(formed.libraries[i], target, *records[i], max_memory_bytes, one.options.poll));
  return known.emplace_back(std::move(formed));
}

StudyRange summary_of(RangeResult result) {
  StudyRange range{result.spec.name, std::move(result.terms), result.rows.train.size(), result.rows.test.size(), {}};
  for (JudgedFit& fit : result.fits) {
    fit.predicted.resize(0);
    fit.predicted_std.resize(0);
    range.fits.push_back(std::move(fit));
  }
  return range;
}

}  // namespace

std::vector<StudyOutcome> study(const std::vector<const Record*>& records, std::size_t num_cases,
                                const std::function<StudyCase(std::size_t)>& vary, std::size_t max_memory_bytes) {
  std::vector<StudyOutcome> outcomes(num_cases);
  std::vector<FormedColumns> known;
  for (std::size_t k = 0; k < num_cases; ++k) {
    const StudyCase one = vary(k);
    try {
      FormedColumns& formed = columns_of(one, records, max_memory_bytes, known);
      for (RangeResult& range : identify(one.ranges, formed.columns, formed.libraries.front(), one.options))
        outcomes[k].ranges.push_back(summary_of(std::move(range)));
    } catch (const dsp::Fault& fault) {
      if (fault.kind() != dsp::FaultKind::numerics) throw;
      outcomes[k].trouble = fault.what();
    }
  }
  return outcomes;
}

}  // namespace ident
