#include "apps/output/run_folder.hpp"

#include <algorithm>

#include "apps/output/results_json.hpp"
#include "apps/output/segments_file.hpp"
#include "apps/output/steps_table.hpp"
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
    : folder_(destination, force),
      manifest_(begin_manifest(origin.command, origin.command_line, origin.seed, folder_.destination())) {
  for (const std::filesystem::path& file : origin.files) add_input(manifest_, file, folder_.destination());
}

void RunFolder::add_files(const std::vector<Input>& inputs) {
  for (const Input& input : inputs)
    for (const std::filesystem::path& file : input.files) add_input(manifest_, file, folder_.destination());
}

void RunFolder::write(const std::string& name, std::string_view bytes) {
  stream(name, [&](const Sink& sink) { sink(bytes); });
}

void RunFolder::stream(const std::string& name, const std::function<void(const Sink&)>& fill) {
  OutputFile file = folder_.file(name);
  fill([&](std::string_view bytes) { file.write(bytes); });
  file.close();
  check_interrupted();
}

void RunFolder::finish(const Config& config, const std::vector<Input>& inputs, const Console& console) {
  stream("prepared.csv", [&](const Sink& sink) { write_prepared(prepared_of(inputs), sink); });
  write("quality.json", quality_json(inputs));
  write("segments.json", segments_json(inputs));
  if (const auto steps = steady_steps(inputs); !steps.empty()) write("steps.csv", steps_csv(steps));
  write("config.toml", to_toml(config, folder_.destination()));
  write("log.txt", console.log());
  manifest_.warnings = console.warnings();
  manifest_.calibrated = std::all_of(inputs.begin(), inputs.end(),
                                     [](const Input& input) { return input.prepared.signals.uncalibrated.empty(); });
  folder_.commit(std::move(manifest_));
}

}  // namespace apps
