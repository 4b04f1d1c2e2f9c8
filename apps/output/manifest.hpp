#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace apps {

struct ManifestFile {
  std::string path, sha256;
  std::string recording = {};  ///< what the outputs call the recording that the file is; empty: another file
};

/// What manifest.json says of a folder of results: how it came about and every file in it but itself.
struct Manifest {
  std::string command, started_utc, finished_utc;
  std::vector<std::string> arguments, warnings;
  std::vector<ManifestFile> inputs;   ///< as manifest_path says; recordings in the order of the config
  std::vector<ManifestFile> outputs;  ///< paths relative to the folder, sorted
  std::uint64_t seed = 1;
  bool calibrated = true;           ///< false: some numbers are raw
  int exit_code = 0;                ///< of the command that wrote it
  std::string request;              ///< SHA-256 of what the command was asked for beside its inputs; empty: not known
  std::vector<std::string> errors;  ///< "[name] text", of exit code 4: results are written all the same
  std::string program;              ///< version, build and libraries of the program that wrote it; empty: this one
};

inline constexpr const char* manifest_name = "manifest.json";  ///< written last

[[nodiscard]] std::string manifest_json(const Manifest& manifest);

/// The outputs listed by the manifest.json of `folder`; nothing if there is none or Ardent did not write it.
[[nodiscard]] std::optional<std::vector<ManifestFile>> listed_outputs(const std::filesystem::path& folder);

/// The manifest.json of `folder`; nothing if there is none or Ardent did not write it.
[[nodiscard]] std::optional<Manifest> read_manifest(const std::filesystem::path& folder);

/// Version, build and libraries of this program, as Manifest::program has them.
[[nodiscard]] std::string this_program();

/// A file as the manifest of the results in `folder` names it: relative to `folder` where it is in it or in the folder
/// that holds it ("../x.wav"), else the name alone, so that no manifest says where a person keeps things.
[[nodiscard]] std::string manifest_path(const std::filesystem::path& file, const std::filesystem::path& folder);

/// A command line with every path in it that is absolute or leads out of the current folder written as manifest_path.
[[nodiscard]] std::vector<std::string> manifest_arguments(const std::vector<std::string>& command_line,
                                                          const std::filesystem::path& folder);

/// The manifest of a command that begins now and writes into `folder`.
[[nodiscard]] Manifest begin_manifest(std::string command, const std::vector<std::string>& command_line,
                                      std::uint64_t seed, const std::filesystem::path& folder);

/// Throws dsp::Fault (input, "file.unreadable").
void add_input(Manifest& manifest, const std::filesystem::path& input, const std::filesystem::path& folder);
/// The same of a file whose hash is known; `recording`: as of ManifestFile.
void add_input(Manifest& manifest, const std::filesystem::path& input, const std::filesystem::path& folder,
               std::string sha256, std::string recording = {});

/// Now, as the manifest writes it: 2026-01-31T12:00:00Z.
[[nodiscard]] std::string utc_now();

}  // namespace apps
