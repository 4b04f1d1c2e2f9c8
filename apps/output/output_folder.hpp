#pragma once
#include <filesystem>
#include <string_view>
#include <vector>

#include "apps/output/manifest.hpp"
#include "apps/output/staging_folder.hpp"
#include "apps/process/output_file.hpp"

namespace apps {

/// Throws dsp::Fault (usage, "output.overlap") if writing the folder `destination` would touch one of the inputs: the
/// output is an input, lies inside one, or an input lies inside the output.
void require_apart(const std::filesystem::path& destination, const std::vector<std::filesystem::path>& inputs);

/// Throws dsp::Fault (usage, "output.current") if `destination` is the current folder or holds it: replaced, that would
/// leave whoever is in it nowhere.
void require_not_current(const std::filesystem::path& destination);

/// A folder of results that is complete or absent: written in a StagingFolder, it appears under its name when its
/// manifest.json is on the disk, and an older one stays until then. Only a folder that was absent, empty, or an earlier
/// result with nothing else in it is ever replaced. Throws dsp::Fault, usage: "output.current" for the current folder
/// and those that hold it; output: "output.exists" for an earlier result without `force`, "output.foreign" for a folder
/// with anything in it that its manifest does not list, or files changed since, also with `force`; "output.symlink",
/// "output.locked" where another command is writing, "output.replaced", "output.write".
class OutputFolder {
 public:
  /// `num_threads`: that check and list its files.
  OutputFolder(const std::filesystem::path& destination, bool force, int num_threads = 1);
  /// Where a file is to be written until the commit. Names are ours: one that is not plain is std::invalid_argument.
  [[nodiscard]] std::filesystem::path path(std::string_view name) const;
  /// Where it will be, which is what messages call it.
  [[nodiscard]] std::filesystem::path shown(std::string_view name) const { return destination_ / name; }
  [[nodiscard]] OutputFile file(std::string_view name) const;  ///< with the folders it is to be in
  void write(std::string_view name, std::string_view bytes) const;
  void make_folder(std::string_view name) const;
  [[nodiscard]] const Folder& folder() const& { return folder_; }  ///< until the commit
  void folder() const&& = delete;
  /// Lists all files in the manifest, ends it and puts the folder in its place.
  void commit(Manifest manifest);
  [[nodiscard]] const std::filesystem::path& destination() const& { return destination_; }
  void destination() const&& = delete;

 private:
  void require_replaceable(const Folder& folder, const std::string& name) const;
  std::filesystem::path destination_;
  bool force_;
  int num_threads_;
  StagingFolder staging_;
  Folder folder_;  ///< being filled
};

}  // namespace apps
