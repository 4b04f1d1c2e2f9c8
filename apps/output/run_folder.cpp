#include "apps/output/run_folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <system_error>

#include "apps/output/results_json.hpp"
#include "apps/output/segments_file.hpp"
#include "apps/process/interrupt.hpp"

namespace apps {
namespace {

constexpr double least_folder_bytes = 10e6;  // a smaller recording's run folder may be as large as this
constexpr double reserved_bytes = 100e3;     // for the manifest and the last lines of the log
constexpr double estimate_margin = 0.96;     // sizes of tables are estimated from some of their rows
constexpr double prepared_share = 0.6;       // of the tables' bytes, at most

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
      std::error_code unknown;
      const auto size = std::filesystem::file_size(file, unknown);
      if (!unknown) recorded_bytes_ += static_cast<double>(size);
    }
  }
  return added;
}

void RunFolder::write(const std::string& name, std::string_view bytes) {
  folder_.write(name, bytes);
  bytes_ += static_cast<double>(bytes.size());
  check_interrupted();
}

void RunFolder::add_table(CsvTable table) {
  tables_.push_back(std::move(table));
}

double RunFolder::write_table_within(const CsvTable& table, double most_bytes, Console& console) {
  const std::vector<TableForm> forms = table_forms();
  std::size_t chosen = 0;
  double expected = estimated_bytes(table, forms.front());
  for (; chosen + 1 < forms.size() && expected > most_bytes; check_interrupted())
    expected = estimated_bytes(table, forms[++chosen]);
  const TableForm& form = forms[chosen];
  OutputFile file = folder_.file(file_name(table, form));
  const auto progress = shown_progress(console, "writing " + file_name(table, form));
  double written = 0.0;
  const auto sink = [&](std::string_view bytes) {
    file.write(bytes);
    written += static_cast<double>(bytes.size());
    progress(written / std::max(written, expected));
  };
  write_table(table, form, sink, num_threads_);
  file.close();
  check_interrupted();
  if (form.compressed)
    console.note(fmt::format("{}: {}; --full writes all of it", file_name(table, form), form.sentence()));
  return written;
}

/// Signals before what follows from them; tables of fits share the rest.
void RunFolder::write_tables(const CsvTable& prepared, double most_bytes, Console& console) {
  const double share = tables_.empty() ? 1.0 : prepared_share;
  double left = most_bytes - write_table_within(prepared, share * most_bytes, console);
  for (std::size_t i = 0; i < tables_.size(); ++i)
    left -= write_table_within(tables_[i], left / static_cast<double>(tables_.size() - i), console);
}

void RunFolder::finish(const Config& config, const std::vector<Input>& inputs, const std::vector<RecordingSteps>& steps,
                       Console& console, int exit_code) {
  write("quality.json", quality_json(inputs));
  write("segments.json", segments_json(inputs));
  if (!steps.empty()) write("steps.csv", steps_csv(steps));
  write("config.toml", to_toml(config, folder_.destination()));
  const double most = config.full_tables ? std::numeric_limits<double>::infinity()
                                         : std::max(least_folder_bytes, recorded_bytes_) - reserved_bytes -
                                               static_cast<double>(console.log().size()) - bytes_;
  write_tables(prepared_table(prepared_of(inputs)), estimate_margin * most, console);
  write("log.txt", console.log());
  manifest_.warnings = console.warnings();
  manifest_.errors = console.errors();
  manifest_.exit_code = exit_code;
  manifest_.calibrated = std::all_of(inputs.begin(), inputs.end(),
                                     [](const Input& input) { return input.prepared.signals.uncalibrated.empty(); });
  folder_.commit(std::move(manifest_));
}

}  // namespace apps
