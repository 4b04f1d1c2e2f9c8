#pragma once
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace apps {

/// Something that is not the same in all runs, and what each of them has; empty: nothing.
struct Change {
  enum class Kind { program, input, setting } kind = Kind::setting;
  std::string what;  ///< name of an input, "prepare.cutoff_hz"
  std::vector<std::string> values;
};

/// From manifests (inputs by SHA-256) and configs, as far as runs have them. Names of recordings in configs do not
/// count: their bytes do.
[[nodiscard]] std::vector<Change> changes_between(const std::vector<std::filesystem::path>& run_folders);

}  // namespace apps
