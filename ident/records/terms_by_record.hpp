#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "ident/columns/columns.hpp"
#include "ident/library/library.hpp"

namespace ident {

/// A recording by its number (1-based) and name.
struct RecordingName {
  int recording = 0;
  std::string name;
};

/// The library with these of its terms (indices) once for each recording as well, behind the others, a term at a time;
/// the terms themselves stand aside (Term::by_record).
[[nodiscard]] CandidateLibrary terms_by_record(CandidateLibrary library, const std::vector<Eigen::Index>& terms,
                                               const std::vector<RecordingName>& recordings);

/// The library with these of its terms once for each of these recordings (0-based) as well, behind the others; the
/// terms themselves stand aside. The recordings' columns are then of the library returned, until columns_of_library.
[[nodiscard]] CandidateLibrary terms_by_record(CandidateLibrary library, const std::vector<Eigen::Index>& terms,
                                               const std::vector<std::size_t>& recordings,
                                               std::vector<Columns>& columns);

/// Makes them columns of the library they were formed of again.
void columns_of_library(std::vector<Columns>& columns);

}  // namespace ident
