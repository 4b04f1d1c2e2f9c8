#include "apps/cli/repeat_run.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "apps/cli/run_job.hpp"
#include "apps/output/finished_run.hpp"
#include "apps/output/manifest.hpp"
#include "apps/output/repeat_report.hpp"
#include "apps/process/folder.hpp"
#include "apps/process/path.hpp"
#include "apps/process/sha256.hpp"
#include "apps/process/system_fault.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

/// A folder of its own that goes with its end.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::error_code error;
    const fs::path parent = fs::temp_directory_path(error);
    if (error) throw cannot_write("the folder for temporary files", error.value());
    std::string path = (parent / "ardent-XXXXXX").string();
    if (::mkdtemp(path.data()) == nullptr) throw cannot_write(parent, errno);
    path_ = path;
    folder_ = Folder(path_, path_);
  }
  ~TemporaryFolder() {
    try {
      folder_.remove(folder_.tree());
      ::rmdir(path_.c_str());
    } catch (const dsp::Fault&) {  // it stays
    }
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
  Folder folder_;
};

[[noreturn]] void refuse(const fs::path& run, const std::string& why) {
  throw dsp::Fault(dsp::FaultKind::usage, "run.repeat", fmt::format("{}: {}", run.string(), why));
}

/// The manifest of a run that can be repeated with these arguments.
Manifest manifest_to_repeat(const RunArguments& arguments) {
  const Manifest manifest = *read_manifest(arguments.input);
  if (!arguments.recording.empty())
    refuse(arguments.input, fmt::format("is a run. To apply its settings to another recording: ardent run {} {}",
                                        (arguments.input / "config.toml").string(), arguments.recording.string()));
  if (manifest.command != "run")
    refuse(arguments.input,
           fmt::format("was written by ardent {}, want the folder of a run. To have it again: ardent {}",
                       manifest.command, fmt::join(manifest.arguments, " ")));
  if (!arguments.set.empty() || arguments.salvage || arguments.uncalibrated || arguments.no_rows ||
      arguments.no_figures || !arguments.sidecar.empty())
    refuse(arguments.input, fmt::format("a repeat takes the run's own settings. To change some: ardent run {} with the "
                                        "same options",
                                        (arguments.input / "config.toml").string()));
  return manifest;
}

/// The manifest's inputs, each beside the file it was as far as that can be found again, then what the repeat read
/// beside them: a sidecar that has come since.
std::vector<RepeatedFile> repeated_inputs(const Manifest& manifest, const std::vector<fs::path>& read,
                                          const fs::path& run) {
  std::vector<RepeatedFile> files;
  for (const ManifestFile& input : manifest.inputs) {
    const auto same_name = std::find_if(read.begin(), read.end(),
                                        [&](const fs::path& file) { return manifest_path(file, run) == input.path; });
    const fs::path found = same_name != read.end() ? *same_name : run / input.path;
    std::error_code unknown;
    const bool there = fs::is_regular_file(found, unknown);
    files.push_back({input.path, there, there && sha256_file(found) == input.sha256, same_name != read.end()});
  }
  for (const fs::path& file : read) {
    const std::string path = manifest_path(file, run), hash = sha256_file(file);
    if (std::none_of(manifest.inputs.begin(), manifest.inputs.end(),
                     [&](const ManifestFile& input) { return input.path == path || input.sha256 == hash; }))
      files.push_back({.path = path, .found = true, .is_new = true});
  }
  return files;
}

std::vector<RepeatedFile> repeated_results(const Manifest& manifest, const fs::path& again, const std::string& config) {
  const std::vector<ManifestFile> now = listed_outputs(again).value_or(std::vector<ManifestFile>());
  std::vector<RepeatedFile> files;
  for (const ManifestFile& output : manifest.outputs) {
    if (output.path == "log.txt") continue;
    const auto found =
        std::find_if(now.begin(), now.end(), [&](const ManifestFile& file) { return file.path == output.path; });
    const bool there = found != now.end();
    // Its paths are relative to its folder: what counts is what it would say in the old one.
    const std::string hash = !there ? "" : output.path == "config.toml" ? sha256(config) : found->sha256;
    files.push_back({output.path, there, hash == output.sha256});
  }
  return files;
}

/// Whether every file the manifest lists is in the folder as it was written.
bool outputs_unchanged(const fs::path& run, const Manifest& manifest) {
  return std::all_of(manifest.outputs.begin(), manifest.outputs.end(), [&](const ManifestFile& output) {
    std::error_code unknown;
    const fs::path file = run / output.path;
    return fs::is_regular_file(fs::symlink_status(file, unknown)) && sha256_file(file) == output.sha256;
  });
}

}  // namespace

std::optional<int> kept_exit_code(const fs::path& folder, const Config& config, const RunFolder::Origin& origin) {
  const std::optional<Manifest> manifest = read_manifest(folder);
  if (!manifest || manifest->command != origin.command || manifest->request != origin.request ||
      manifest->program != this_program())
    return std::nullopt;
  std::vector<fs::path> files = input_files(config);
  files.insert(files.end(), origin.files.begin(), origin.files.end());
  for (const fs::path& file : files)
    if (std::none_of(manifest->inputs.begin(), manifest->inputs.end(),
                     [&](const ManifestFile& input) { return input.path == manifest_path(file, folder); }))
      return std::nullopt;  // a sidecar that is new
  for (const RepeatedFile& input : repeated_inputs(*manifest, files, folder))
    if (!input.found || !input.same) return std::nullopt;
  if (!outputs_unchanged(folder, *manifest)) return std::nullopt;
  return manifest->exit_code;
}

bool is_finished_run(const fs::path& folder) {
  std::error_code unknown;
  return fs::is_directory(folder, unknown) && read_manifest(folder).has_value();
}

int repeat_run(const RunArguments& arguments, Console& console) {
  const fs::path run = named_path(arguments.input);
  const Manifest manifest = manifest_to_repeat(arguments);
  check_finished_run(run, arguments.strict, console);
  RunArguments again = arguments;
  again.input = run / "config.toml";
  Config config = config_of(again);
  take_names(manifest, config);
  if (arguments.dry_run) {
    console.result(fmt::format("would repeat {} and compare\n", run.string()));
    return 0;
  }
  std::optional<TemporaryFolder> temporary;
  if (arguments.folder.empty()) again.folder = temporary.emplace().path() / run.filename();
  RunFolder results(folder_apart(again, config, "-run"), arguments.force, origin_of(again, "run", config));
  RunOutcome outcome = run_into(results, config, again, console);
  if (!config.segment_file.empty()) outcome.files.push_back(config.segment_file);
  const RepeatReport report{run.string(),
                            manifest.program,
                            this_program(),
                            repeated_inputs(manifest, outcome.files, run),
                            repeated_results(manifest, results.destination(), to_toml(outcome.config, run)),
                            arguments.folder};
  console.result(console.json() ? repeat_json(report) : repeat_text(report));
  if (!report.inputs_same()) {
    console.error("repeat.inputs", fmt::format("{}: an input has changed since the run", run.string()));
    return 3;
  }
  if (!report.results_same()) {
    console.error("repeat.results", fmt::format("{}: the repeat gives other results", run.string()));
    return 4;
  }
  return arguments.require.empty() ? 0 : outcome.exit_code;
}

}  // namespace apps
