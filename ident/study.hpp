#pragma once
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "ident/identify.hpp"

// How an identification depends on what a person had to choose (Sec. 5.2 of [QZS23] does this by hand).

namespace ident {

struct StudyCase {
  LibraryOptions library;
  std::vector<Range> ranges;
  IdentifyOptions options;
};

/// What one case gave on one range; models and figures only.
struct StudyRange {
  std::string name;
  std::vector<std::string> terms;  ///< of the library
  std::size_t num_train = 0, num_test = 0;
  std::vector<JudgedFit> fits;
};
struct StudyOutcome {
  std::vector<StudyRange> ranges;
  std::string trouble;  ///< not empty: numerics ended it, and how
};

/// Identifies from the same records with other options time after time: `vary` gives each case by its index, in order,
/// and may throw to stop. Columns are formed once for each library and target; the fits of a case are those of
/// `identify` with its options. Throws as record_library, record_columns and identify, but that a fault of numerics is
/// that case's trouble.
[[nodiscard]] std::vector<StudyOutcome> study(const std::vector<const Record*>& records, std::size_t num_cases,
                                              const std::function<StudyCase(std::size_t)>& vary,
                                              std::size_t max_memory_bytes = dsp::ReadOptions{}.max_memory_bytes);

}  // namespace ident
