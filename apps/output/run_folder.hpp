#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "apps/config/inputs.hpp"
#include "apps/output/steps_table.hpp"
#include "apps/output/tables.hpp"
#include "apps/process/hashes_beside.hpp"
#include "apps/process/output_folder.hpp"

namespace apps {

/// The folder of `ardent run` and `prep` being filled. Nothing appears under its name before finish().
class RunFolder {
 public:
  struct Origin {
    std::string command;  ///< "run" or "prep"
    std::vector<std::string> command_line;
    std::uint64_t seed = 1;
    std::vector<std::filesystem::path> files;  ///< that were read besides recordings: config, segments
    std::string request = {};                  ///< as of Manifest
    int num_threads = 1;                       ///< that make its tables and check its files
  };
  /// Throws as OutputFolder.
  RunFolder(const std::filesystem::path& destination, bool force, const Origin& origin);
  /// The files of these recordings, for the manifest, and as it has them, of each recording.
  std::vector<std::vector<ManifestFile>> add_files(const std::vector<Input>& inputs, HashesBeside& hashes);
  void write(const std::string& name, std::string_view bytes);
  /// Written by finish, in a form that fits the folder's size. What it rests on must last until then.
  void add_table(CsvTable table);
  /// What every run folder holds: quality.json, segments.json, steps.csv of stepped sines, config.toml; then
  /// prepared.csv and the other tables, each in the first of table_forms() in which the folder is no larger than its
  /// recordings or 10 MB, unless config.full_tables; log.txt, the manifest. Throws Interrupted when a signal has come.
  void finish(const Config& config, const std::vector<Input>& inputs, const std::vector<RecordingSteps>& steps,
              Console& console, int exit_code = 0);
  [[nodiscard]] const std::filesystem::path& destination() const& { return folder_.destination(); }
  void destination() const&& = delete;

 private:
  [[nodiscard]] double write_table_within(const CsvTable& table, double most_bytes, Console& console);
  void write_tables(const CsvTable& prepared, double most_bytes, Console& console);
  OutputFolder folder_;
  int num_threads_;
  std::vector<CsvTable> tables_;
  double bytes_ = 0.0;           ///< written so far
  double recorded_bytes_ = 0.0;  ///< of the files that were read
  Manifest manifest_;
};

}  // namespace apps
