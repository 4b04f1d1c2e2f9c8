#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "apps/batch/record_tasks.hpp"
#include "apps/batch/work.hpp"
#include "ident/joint_fit.hpp"

namespace apps {

/// A recording of a batch with what became of it.
struct RecordResult {
  std::string recording, run;  ///< file name; folder in the batch's, empty: there are no results
  int exit_code = 0;
  bool was_kept = false;
  std::string error;  ///< "[name] text"; empty: none
  /// As table.json has them: {name, chosen, verdict, cause, method, equation, num_train, num_effective, nmse, terms},
  /// of the equation whose verdict the range has. null: not known, or there is none.
  std::vector<nlohmann::ordered_json> ranges;
  std::vector<ident::RecordFactors> factors;  ///< of the ranges; empty: the run wrote none
};

/// Reads the run folder of a task, if it has one. `require`: least verdict, "describes", "in_part" or empty; a lower
/// one is exit code 4. A folder that cannot be read any more is an error of its record. Throws nothing but
/// std::bad_alloc.
[[nodiscard]] RecordResult record_result(const RecordTask& task, const TaskOutcome& outcome,
                                         const std::filesystem::path& runs, const std::string& require);

/// Of all ranges of all records, in order of appearance.
[[nodiscard]] std::vector<std::string> all_terms(const std::vector<RecordResult>& records);

/// table.csv: a row for each range of each record; a record without results has one row with its error.
[[nodiscard]] std::string table_csv(const std::vector<RecordResult>& records);
/// table.json: the same and, under "joint", `joint` (a document of joint_json, or empty with the reason).
[[nodiscard]] std::string table_json(const std::vector<RecordResult>& records, const std::string& joint,
                                     const std::string& joint_reason);

}  // namespace apps
