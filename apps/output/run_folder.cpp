#include "apps/output/run_folder.hpp"

#include <algorithm>

#include "apps/config/segments_file.hpp"
#include "apps/output/results_json.hpp"
#include "apps/process/interrupt.hpp"

namespace apps {
namespace {

std::vector<const dsp::Prepared*> prepared_of(const std::vector<Input>& inputs) {
  std::vector<const dsp::Prepared*> prepared;
  for (const Input& input : inputs) prepared.push_back(&input.prepared);
  return prepared;
}

}  // namespace

RunFolder::RunFolder(const std::filesystem::path& destination, bool force, const Origin& origin)
    : folder_(destination, force, origin.num_threads),
      num_threads_(origin.num_threads),
      manifest_(begin_manifest(origin.command, origin.command_line, origin.seed, folder_.destination())) {
  manifest_.request = origin.request;
  for (const std::filesystem::path& file : origin.files) add_input(manifest_, file, folder_.destination());
}

std::vector<std::vector<ManifestFile>> RunFolder::add_files(const std::vector<Input>& inputs, HashesBeside& hashes) {
  std::vector<std::vector<ManifestFile>> added;
  for (const Input& input : inputs) {
    added.emplace_back();
    for (const std::filesystem::path& file : input.files) {
      add_input(manifest_, file, folder_.destination(), hashes.of(file),
                file == input.files.front() ? input.prepared.name : std::string());
      added.back().push_back(manifest_.inputs.back());
    }
  }
  return added;
}

void RunFolder::write(const std::string& name, std::string_view bytes) {
  folder_.write(name, bytes);
  check_interrupted();
}

void RunFolder::write(const CsvTable& table, Console& console) {
  OutputFile file = folder_.file(table.name);
  write_table(
      table, [&](std::string_view rows) { file.write(rows); }, num_threads_,
      shown_progress(console, "writing " + table.name));
  file.close();
  check_interrupted();
}

void RunFolder::finish(const Config& config, const std::vector<Input>& inputs, const std::vector<RecordingSteps>& steps,
                       Console& console, int exit_code) {
  write("quality.json", quality_json(inputs));
  write("segments.json", segments_json(inputs));
  if (!steps.empty()) write("steps.csv", steps_csv(steps));
  write("config.toml", to_toml(config, folder_.destination()));
  if (config.rows) write(prepared_table(prepared_of(inputs)), console);
  write("log.txt", console.log());
  manifest_.warnings = console.warnings();
  manifest_.errors = console.errors();
  manifest_.exit_code = exit_code;
  manifest_.calibrated = std::all_of(inputs.begin(), inputs.end(),
                                     [](const Input& input) { return input.prepared.signals.uncalibrated.empty(); });
  folder_.commit(std::move(manifest_));
}

}  // namespace apps
