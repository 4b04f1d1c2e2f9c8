#include "ident/records/terms_by_record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace ident {
namespace {

/// Its name; with its number where another has the same.
std::string name_of(const std::vector<Columns>& columns, std::size_t recording) {
  const std::string& name = columns[recording].name;
  const auto same = std::count_if(columns.begin(), columns.end(), [&](const Columns& one) { return one.name == name; });
  return same > 1 ? fmt::format("{} (recording {})", name, recording + 1) : name;
}

}  // namespace

CandidateLibrary terms_by_record(CandidateLibrary library, const std::vector<Eigen::Index>& terms,
                                 const std::vector<RecordingName>& recordings) {
  for (const Eigen::Index j : terms) {
    library.terms[static_cast<std::size_t>(j)].by_record = true;
    Term own = library.terms[static_cast<std::size_t>(j)];
    own.by_record = false;
    for (const RecordingName& recording : recordings) {
      own.recording = recording.recording;
      own.recording_name = recording.name;
      library.terms.push_back(own);
    }
  }
  return library;
}

CandidateLibrary terms_by_record(CandidateLibrary library, const std::vector<Eigen::Index>& terms,
                                 const std::vector<std::size_t>& recordings, std::vector<Columns>& columns) {
  std::vector<TermColumn> where;
  for (Eigen::Index j = 0; j < std::ssize(library.terms); ++j) where.push_back({j});
  std::vector<RecordingName> names;
  for (const std::size_t recording : recordings)
    names.push_back({static_cast<int>(recording) + 1, name_of(columns, recording)});
  for (const Eigen::Index j : terms)
    for (const RecordingName& recording : names) where.push_back({j, recording.recording});
  for (Columns& one : columns) one.term_columns = where;
  return terms_by_record(std::move(library), terms, names);
}

void columns_of_library(std::vector<Columns>& columns) {
  for (Columns& one : columns) one.term_columns.clear();
}

}  // namespace ident
