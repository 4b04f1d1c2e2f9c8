#pragma once
#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "apps/output/manifest.hpp"
#include "apps/output/staging_folder.hpp"

namespace apps {

/// The folder of `ardent batch`. `runs/` fills with run folders, each complete or absent, and stays when the command is
/// stopped; the summary beside it comes at the end, manifest.json last: where it is the batch is complete. An earlier
/// summary goes when a batch begins again. One command at a time: StagingFolder's lock. Throws dsp::Fault: usage
/// "output.current"; output "output.foreign" for a folder that no batch has written, or whose summary somebody has
/// changed or begun; "output.locked", "output.symlink", "output.write".
class BatchFolder {
 public:
  explicit BatchFolder(const std::filesystem::path& destination);
  [[nodiscard]] std::filesystem::path runs() const { return destination_ / runs_name; }
  [[nodiscard]] const std::filesystem::path& destination() const& { return destination_; }
  void destination() const&& = delete;
  /// A file of the summary, one of summary_names; nothing appears before commit.
  void write(const std::string& name, std::string_view bytes);
  /// Lists the files of the summary in the manifest and puts all of them into the folder.
  void commit(Manifest manifest);

  static constexpr const char* runs_name = "runs";
  static constexpr std::array summary_names{"table.csv", "table.json", "report.html", "log.txt", manifest_name};

 private:
  void remove_summary() const;
  std::filesystem::path destination_;
  StagingFolder staging_;
  std::vector<ManifestFile> written_;
};

}  // namespace apps
