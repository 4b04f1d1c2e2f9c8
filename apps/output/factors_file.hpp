#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "ident/identify.hpp"
#include "ident/joint_fit.hpp"

// factors.json: R factors of records, from which they are fitted together without being read again. The format is in
// the reference (ardent help files), numbered by `schema`.

namespace apps {

inline constexpr const char* factors_name = "factors.json";
/// Of one record; also what is formed for it (IdentifyOptions::most_blocks).
inline constexpr Eigen::Index most_factor_blocks = 16;

/// What the file says of each range. `recordings`: the columns that were identified. `sources`: files of each of them.
[[nodiscard]] std::vector<ident::RecordFactors> record_factors(
    const std::vector<ident::RangeResult>& ranges, const std::vector<ident::Columns>& recordings,
    const std::vector<std::vector<ident::FactorSource>>& sources, const ident::CandidateLibrary& library,
    const ident::IdentifyOptions& options);

/// All of them. Records of one name that come from different files get the shortest end of its path that tells them
/// apart before it: "mon/run: drive.csv". `of_files`: of each file.
[[nodiscard]] std::vector<ident::RecordFactors> name_apart(std::vector<std::vector<ident::RecordFactors>> of_files,
                                                           const std::vector<std::filesystem::path>& files);

[[nodiscard]] std::string factors_json(const std::vector<ident::RecordFactors>& records);

/// A factors.json, or the one in a run folder. Throws dsp::Fault (input): "factors.file" where it cannot be read or is
/// none, "factors.schema" of another version, "factors.damaged" naming the field, what was found and what is wanted.
[[nodiscard]] std::vector<ident::RecordFactors> read_factors(const std::filesystem::path& file_or_folder);

/// Writes a file of R factors, complete or not at all; nothing where no `file` is named. Throws dsp::Fault: usage
/// "output.overlap" where it is one of the files that were read; output "output.exists" for a file that is there,
/// unless `force` and it holds R factors; "output.foreign", "output.symlink", "output.write". `force` without a file to
/// save is refused (usage).
void save_factors(const std::filesystem::path& file, const std::vector<ident::RecordFactors>& records,
                  const std::vector<std::filesystem::path>& read, bool force);

}  // namespace apps
