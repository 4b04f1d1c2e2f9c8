#include "apps/output/run_folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <system_error>

#include "apps/output/results_json.hpp"
#include "apps/output/segments_file.hpp"
#include "apps/output/steps_table.hpp"
#include "apps/process/interrupt.hpp"

namespace apps {
namespace {

constexpr double least_folder_bytes = 10e6;  // a smaller recording's run folder may be as large as this
constexpr double reserved_bytes = 100e3;     // for the manifest and the last lines of the log
constexpr double estimate_margin = 0.96;     // sizes of tables are estimated from some of their rows
constexpr std::size_t pieces_between_polls = 4096;

std::vector<const dsp::Prepared*> prepared_of(const std::vector<Input>& inputs) {
  std::vector<const dsp::Prepared*> prepared;
  for (const Input& input : inputs) prepared.push_back(&input.prepared);
  return prepared;
}

/// Of the recordings that are stepped sines.
std::vector<RecordingSteps> steady_steps(const std::vector<Input>& inputs) {
  std::vector<RecordingSteps> all;
  for (const Input& input : inputs)
    if (auto steps = dsp::find_steady_steps(input.prepared.signals); !steps.empty())
      all.emplace_back(input.prepared.name, std::move(steps));
  return all;
}

}  // namespace

RunFolder::RunFolder(const std::filesystem::path& destination, bool force, const Origin& origin)
    : folder_(destination, force),
      manifest_(begin_manifest(origin.command, origin.command_line, origin.seed, folder_.destination())) {
  for (const std::filesystem::path& file : origin.files) add_input(manifest_, file, folder_.destination());
}

void RunFolder::add_files(const std::vector<Input>& inputs) {
  for (const Input& input : inputs)
    for (const std::filesystem::path& file : input.files) {
      add_input(manifest_, file, folder_.destination());
      std::error_code unknown;
      const auto size = std::filesystem::file_size(file, unknown);
      if (!unknown) recorded_bytes_ += static_cast<double>(size);
    }
}

void RunFolder::write(const std::string& name, std::string_view bytes) {
  folder_.write(name, bytes);
  bytes_ += static_cast<double>(bytes.size());
  check_interrupted();
}

void RunFolder::add_table(CsvTable table) {
  tables_.push_back(std::move(table));
}

void RunFolder::write_tables(double most_bytes, Console& console) {
  std::vector<TableForm> forms = table_forms();
  const auto needed = [&](const TableForm& form) {
    double bytes = 0.0;
    for (const CsvTable& table : tables_) bytes += estimated_bytes(table, form);
    return bytes;
  };
  std::size_t chosen = 0;
  while (chosen + 1 < forms.size() && needed(forms[chosen]) > most_bytes) ++chosen, check_interrupted();
  const TableForm& form = forms[chosen];
  for (const CsvTable& table : tables_) {
    OutputFile file = folder_.file(file_name(table, form));
    std::size_t pieces = 0;
    write_table(table, form, [&](std::string_view bytes) {
      file.write(bytes);
      if (++pieces % pieces_between_polls == 0) check_interrupted();
    });
    file.close();
    check_interrupted();
    if (form.compressed)
      console.note(fmt::format("{}: {}; --full writes all of it", file_name(table, form), form.sentence()));
  }
}

void RunFolder::finish(const Config& config, const std::vector<Input>& inputs, Console& console) {
  write("quality.json", quality_json(inputs));
  write("segments.json", segments_json(inputs));
  if (const auto steps = steady_steps(inputs); !steps.empty()) write("steps.csv", steps_csv(steps));
  write("config.toml", to_toml(config, folder_.destination()));
  add_table(prepared_table(prepared_of(inputs)));
  const double most = config.full_tables ? std::numeric_limits<double>::infinity()
                                         : std::max(least_folder_bytes, recorded_bytes_) - reserved_bytes -
                                               static_cast<double>(console.log().size()) - bytes_;
  write_tables(estimate_margin * most, console);
  write("log.txt", console.log());
  manifest_.warnings = console.warnings();
  manifest_.calibrated = std::all_of(inputs.begin(), inputs.end(),
                                     [](const Input& input) { return input.prepared.signals.uncalibrated.empty(); });
  folder_.commit(std::move(manifest_));
}

}  // namespace apps
