#include "apps/output/run_changes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "apps/output/manifest.hpp"
#include "apps/output/run_json.hpp"
#include "dsp/io/toml_values.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t hash_characters = 8;

std::map<std::string, std::string> inputs_of(const Manifest& manifest) {
  std::map<std::string, std::string> inputs;
  std::map<std::string, int> count;
  for (const ManifestFile& input : manifest.inputs) {
    const std::string name = input.recording.empty() ? fs::path(input.path).filename().string() : input.recording;
    const int number = ++count[name];  // several of one name come in their order
    inputs[number == 1 ? name : fmt::format("{} ({})", name, number)] = input.sha256.substr(0, hash_characters);
  }
  return inputs;
}

std::map<std::string, std::string> settings_of(const fs::path& run) {
  std::error_code unknown;
  if (!fs::exists(run / "config.toml", unknown)) return {};
  std::map<std::string, std::string> values =
      dsp::toml_values(read_run_file(run / "config.toml"), (run / "config.toml").string());
  std::erase_if(values,
                [](const auto& pair) { return pair.first.ends_with(".file") || pair.first.ends_with(".sidecar"); });
  return values;
}

void add_differences(std::vector<Change>& changes, Change::Kind kind,
                     const std::vector<std::map<std::string, std::string>>& runs) {
  std::set<std::string> names;
  for (const auto& run : runs)
    for (const auto& [name, value] : run) names.insert(name);
  for (const std::string& name : names) {
    Change change{kind, name, {}};
    for (const auto& run : runs) change.values.push_back(run.contains(name) ? run.at(name) : "");
    if (std::any_of(change.values.begin(), change.values.end(),
                    [&](const std::string& value) { return value != change.values.front(); }))
      changes.push_back(std::move(change));
  }
}

}  // namespace

std::vector<Change> changes_between(const std::vector<fs::path>& run_folders) {
  std::vector<std::map<std::string, std::string>> programs, inputs, settings;
  for (const fs::path& run : run_folders) {
    const Manifest manifest = read_manifest(run).value_or(Manifest());
    programs.push_back({{"program", manifest.program}});
    inputs.push_back(inputs_of(manifest));
    settings.push_back(settings_of(run));
  }
  std::vector<Change> changes;
  add_differences(changes, Change::Kind::input, inputs);
  add_differences(changes, Change::Kind::setting, settings);
  add_differences(changes, Change::Kind::program, programs);
  return changes;
}

}  // namespace apps
