#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/config/inputs.hpp"
#include "apps/output/tables.hpp"
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
  };
  /// Throws as OutputFolder.
  RunFolder(const std::filesystem::path& destination, bool force, const Origin& origin);
  /// The files of these recordings, for the manifest.
  void add_files(const std::vector<Input>& inputs);
  void write(const std::string& name, std::string_view bytes);
  /// In pieces: `fill` is handed where they go. Throws Interrupted when a signal has come.
  void stream(const std::string& name, const std::function<void(const Sink&)>& fill);
  /// What every run folder holds: prepared.csv, quality.json, segments.json, steps.csv of stepped sines, config.toml,
  /// log.txt; the manifest last.
  void finish(const Config& config, const std::vector<Input>& inputs, const Console& console);
  [[nodiscard]] const std::filesystem::path& destination() const { return folder_.destination(); }

 private:
  OutputFolder folder_;
  Manifest manifest_;
};

}  // namespace apps
