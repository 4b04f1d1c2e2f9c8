#include "apps/output/manifest.hpp"

#include <fmt/chrono.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>

#include "apps/output/run_json.hpp"
#include "apps/process/path.hpp"
#include "apps/process/printable.hpp"
#include "apps/process/sha256.hpp"
#include "apps/process/version.hpp"
#include "apps/text/json_parts.hpp"
#include "dsp/values/fault.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::ordered_json;
constexpr const char* program_name = "ardent";

std::string text_at(const Json& object, const char* key) {
  const auto member = object.is_object() ? object.find(key) : object.end();
  return member != object.end() && member->is_string() ? member->get<std::string>() : std::string();
}

std::vector<ManifestFile> files_at(const Json& document, const char* key) {
  std::vector<ManifestFile> files;
  if (document.contains(key) && document.at(key).is_array())
    for (const Json& file : document.at(key))
      files.push_back({text_at(file, "path"), text_at(file, "sha256"), text_at(file, "recording")});
  return files;
}

std::vector<std::string> texts_at(const Json& document, const char* key) {
  std::vector<std::string> texts;
  if (document.contains(key) && document.at(key).is_array())
    for (const Json& one : document.at(key))
      if (one.is_string()) texts.push_back(one.get<std::string>());
  return texts;
}

std::string program_of(const Json& document) {
  std::string text = fmt::format("{} ({})", text_at(document, "version"), text_at(document, "build"));
  if (document.contains("libraries") && document.at("libraries").is_object())
    for (const auto& [name, version] : document.at("libraries").items())
      if (version.is_string()) text += fmt::format(", {} {}", name, version.get<std::string>());
  return text;
}

std::optional<Manifest> manifest_of(const Json& document) {
  if (text_at(document, "program") != program_name || !document.contains("outputs")) return std::nullopt;
  if (!document.at("outputs").is_array()) return std::nullopt;
  Manifest manifest;
  manifest.command = text_at(document, "command");
  manifest.arguments = texts_at(document, "arguments");
  manifest.warnings = texts_at(document, "warnings");
  manifest.errors = texts_at(document, "errors");
  manifest.request = text_at(document, "request");
  if (document.contains("exit_code") && document.at("exit_code").is_number_integer())
    manifest.exit_code = document.at("exit_code").get<int>();
  manifest.inputs = files_at(document, "inputs");
  manifest.outputs = files_at(document, "outputs");
  manifest.program = program_of(document);
  for (const ManifestFile& file : manifest.outputs)
    if (!is_plain(file.path)) return std::nullopt;  // what is listed may be deleted
  return manifest;
}

/// One argument, the paths in it as manifest_path says. A path may be the whole of it or a value: -oPATH, key=PATH,
/// key="PATH", key=PATH,PATH.
std::string argument_shown(const std::string& argument, const fs::path& folder) {
  constexpr const char* around_values = "=,\"'";
  std::string text;
  std::size_t begin = argument.starts_with("-o") ? 2 : 0;
  text = argument.substr(0, begin);
  while (begin <= argument.size()) {
    const std::size_t end = std::min(argument.find_first_of(around_values, begin), argument.size());
    const fs::path value = argument.substr(begin, end - begin), normal = value.lexically_normal();
    const bool leads_out = value.is_absolute() || (!normal.empty() && *normal.begin() == "..");
    text += leads_out ? manifest_path(value, folder) : value.string();
    if (end < argument.size()) text += argument[end];
    begin = end + 1;
  }
  return text;
}

}  // namespace

std::string manifest_json(const Manifest& manifest) {
  Json document{{"schema", 1},
                {"program", program_name},
                {"version", version()},
                {"build", build_flags()},
                {"libraries", Json::object()}};
  for (const LibraryVersion& library : library_versions()) document["libraries"][library.name] = library.version;
  document["command"] = manifest.command;
  document["arguments"] = Json::array();
  for (const std::string& argument : manifest.arguments) document["arguments"].push_back(printable(argument));
  document["seed"] = manifest.seed;
  document["started_utc"] = manifest.started_utc;
  document["finished_utc"] = manifest.finished_utc;
  document["calibrated"] = manifest.calibrated;
  document["exit_code"] = manifest.exit_code;
  if (!manifest.request.empty()) document["request"] = manifest.request;
  const auto texts = [](const std::vector<std::string>& list) {
    Json result = Json::array();
    for (const std::string& text : list) result.push_back(printable(text));
    return result;
  };
  document["warnings"] = texts(manifest.warnings);
  document["errors"] = texts(manifest.errors);
  const auto files = [](const std::vector<ManifestFile>& list) {
    Json result = Json::array();
    for (const ManifestFile& file : list) {
      result.push_back({{"path", printable(file.path)}, {"sha256", file.sha256}});
      if (!file.recording.empty()) result.back()["recording"] = printable(file.recording);
    }
    return result;
  };
  document["inputs"] = files(manifest.inputs);
  document["outputs"] = files(manifest.outputs);
  return text_of(document);
}

std::optional<Manifest> read_manifest(const fs::path& folder) {
  std::error_code unknown;
  const fs::path file = folder / manifest_name;
  if (!fs::is_regular_file(fs::symlink_status(file, unknown))) return std::nullopt;
  try {
    return manifest_of(read_run_json(file));
  } catch (const dsp::Fault&) {  // no JSON
    return std::nullopt;
  }
}

std::optional<std::vector<ManifestFile>> listed_outputs(const fs::path& folder) {
  std::optional<Manifest> manifest = read_manifest(folder);
  if (!manifest) return std::nullopt;
  return std::move(manifest->outputs);
}

std::string this_program() {
  return program_of(parsed_json(manifest_json({})));
}

std::string manifest_path(const fs::path& file, const fs::path& folder) {
  const fs::path place = resolved_path(folder), found = resolved_path(file);
  return lies_in(found, place.parent_path()) ? found.lexically_relative(place).generic_string()
                                             : found.filename().string();
}

std::vector<std::string> manifest_arguments(const std::vector<std::string>& command_line, const fs::path& folder) {
  std::vector<std::string> arguments;
  for (const std::string& argument : command_line) arguments.push_back(argument_shown(argument, folder));
  return arguments;
}

Manifest begin_manifest(std::string command, const std::vector<std::string>& command_line, std::uint64_t seed,
                        const fs::path& folder) {
  Manifest manifest;
  manifest.command = std::move(command);
  manifest.started_utc = utc_now();
  manifest.arguments = manifest_arguments(command_line, folder);
  manifest.seed = seed;
  return manifest;
}

void add_input(Manifest& manifest, const fs::path& input, const fs::path& folder) {
  add_input(manifest, input, folder, sha256_file(input));
}

void add_input(Manifest& manifest, const fs::path& input, const fs::path& folder, std::string sha256,
               std::string recording) {
  manifest.inputs.push_back({manifest_path(input, folder), std::move(sha256), std::move(recording)});
}

std::string utc_now() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now())));
}

}  // namespace apps
