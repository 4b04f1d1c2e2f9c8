#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace apps {

/// A file of a run, and of its repeat.
struct RepeatedFile {
  std::string path;  ///< as the run's manifest has it
  bool found = false, same = false;
  bool counts = true;   ///< false: the repeat does not read it, so it changes nothing
  bool is_new = false;  ///< the repeat reads it, the run did not
};

/// What a repeated run shows.
struct RepeatReport {
  std::string run, program_then, program_now;
  std::vector<RepeatedFile> inputs, results;
  std::filesystem::path folder;  ///< of the repeat; empty: it was not kept
  [[nodiscard]] bool inputs_same() const;
  [[nodiscard]] bool results_same() const;
};

[[nodiscard]] std::string repeat_text(const RepeatReport& report);
[[nodiscard]] std::string repeat_json(const RepeatReport& report);

}  // namespace apps
