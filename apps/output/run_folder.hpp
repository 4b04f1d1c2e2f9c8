#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "apps/config/inputs.hpp"
#include "apps/output/output_folder.hpp"
#include "apps/output/steps_table.hpp"
#include "apps/output/tables.hpp"
#include "apps/process/background_hashes.hpp"

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
  void write(const CsvTable& table, Console& console);
  /// What every run folder holds: quality.json, segments.json, steps.csv of stepped sines, config.toml, with
  /// config.rows prepared.csv; log.txt, the manifest. Throws Interrupted when a signal has come.
  void finish(const Config& config, const std::vector<Input>& inputs, const std::vector<RecordingSteps>& steps,
              Console& console, int exit_code = 0);
  [[nodiscard]] const std::filesystem::path& destination() const& { return folder_.destination(); }
  void destination() const&& = delete;

 private:
  OutputFolder folder_;
  int num_threads_;
  Manifest manifest_;
};

}  // namespace apps
