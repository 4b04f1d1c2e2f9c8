#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace apps {

/// A recording of a batch, and where its run goes.
struct RecordTask {
  std::filesystem::path recording;
  std::string called;        ///< in the tables: no two are the same
  std::string name;          ///< of its folder among the runs; no two are the same
  std::uintmax_t bytes = 0;  ///< of the recording; 0 where the system does not say
};

/// One for each recording, in their order. The name is that of the recording; where several share one, it is what the
/// recording is called, with its extension. Throws dsp::Fault (usage, "batch.twice") for a file named twice.
[[nodiscard]] std::vector<RecordTask> record_tasks(const std::vector<std::filesystem::path>& recordings);

/// Their indices by falling size, which is nearly that of the time they take: what is long ends last if it begins last.
[[nodiscard]] std::vector<std::size_t> longest_first(const std::vector<RecordTask>& tasks);

}  // namespace apps
