#include "apps/config/config.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <utility>

#include "apps/config/config_rows.hpp"
#include "apps/config/recording_name.hpp"
#include "apps/config/recording_runs.hpp"
#include "apps/process/path.hpp"
#include "dsp/io/sidecar_rows.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

fs::path from_folder(const fs::path& folder, const fs::path& file) {
  return file.empty() ? file : (folder / file).lexically_normal();
}

RecordingConfig read_recording_table(const dsp::Settings& table, const fs::path& folder) {
  RecordingConfig result;
  dsp::read_rows(recording_rows(), table, result);
  if (result.file.empty()) throw table.fault("file", "config.range", "is empty, want the name of a recording");
  result.file = from_folder(folder, result.file);
  result.sidecar = from_folder(folder, result.sidecar);
  return result;
}

/// Cut-offs that do not lie in their order.
void check_bands(const dsp::Settings& table, const dsp::PrepareOptions& prepare) {
  const auto below = [&](std::string_view low_key, double low, std::string_view high_key, double high) {
    if (low > 0.0 && high > 0.0 && !(low < high))
      throw table.fault(low_key, "config.range",
                        fmt::format("got {}, want less than {} = {}. Lower it or leave it out", low, high_key, high));
  };
  below("rolloff_hz", prepare.rolloff_hz, "cutoff_hz", prepare.cutoff_hz);
  below("state_rolloff_hz", prepare.state_rolloff_hz, "state_cutoff_hz", prepare.state_cutoff_hz);
  below("cutoff_hz", prepare.cutoff_hz, "rate_hz / 2", prepare.rate_hz / 2);
  below("state_cutoff_hz", prepare.state_cutoff_hz, "bus_rate_hz / 2", prepare.intermediate_rate_hz / 2);
}

void check_library(const dsp::Settings& table, const ident::LibraryOptions& library) {
  table.exclusive("only", "terms");
  table.exclusive("only", "order");
  if (library.order == 0 && library.terms.empty())
    throw table.fault("order", "config.missing",
                      "order = 0 without terms leaves no candidates. Give terms = [...] or a higher order");
}

int recording_number(const dsp::Settings& range, const std::vector<RecordingConfig>& recordings) {
  if (!range.has("recording")) return recordings.size() == 1 ? 1 : 0;
  const auto number = range.number("recording");
  if (number && *number > static_cast<double>(recordings.size()))
    throw range.fault("recording", "config.range",
                      fmt::format("got {}, want a number, 1 to {}", *number, recordings.size()));
  if (!range.is_text("recording")) return static_cast<int>(number.value_or(0.0));
  const std::string name = *range.text("recording");
  const std::vector<std::size_t> meant = recordings_called(name, recordings);
  if (meant.size() == 1) return static_cast<int>(meant.front()) + 1;
  std::vector<std::string> known;
  for (const RecordingConfig& recording : recordings) known.push_back(recording.name);
  throw range.fault("recording", "range.recording",
                    fmt::format("{} '{}', want one of {} or a number from 1 to {}",
                                meant.empty() ? "no recording" : "several recordings are called", name,
                                fmt::join(known, ", "), known.size()));
}

std::vector<ident::Range> read_range_tables(const dsp::Settings& document,
                                            const std::vector<RecordingConfig>& recordings) {
  std::vector<ident::Range> result;
  const std::vector<dsp::Settings> tables = document.tables("range");
  for (dsp::RangeSpec& spec : dsp::read_ranges(document)) result.push_back({std::move(spec), 0, {}});
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i].recording = recording_number(tables[i], recordings);
    dsp::read_rows(range_rows(), tables[i], result[i]);
  }
  return result;
}

Config read_document(const dsp::Settings& document, const fs::path& folder, const fs::path& recording) {
  if (!document.has("recording") && document.has("channel"))
    throw document.fault("", "config.missing", "this is a sidecar, not a config. Name the recording beside it");
  document.check(config_settings(), config_schema);
  Config config;
  for (const dsp::Settings& table : document.tables("recording"))
    document.attempt([&] {
      RecordingConfig own = read_recording_table(table, folder);
      (own.test ? config.test_recordings : config.recordings).push_back(std::move(own));
    });
  if (!recording.empty()) {
    RecordingConfig given{.file = recording};
    if (!config.recordings.empty()) {
      given.salvage = config.recordings.front().salvage;
      given = completed(std::move(given), config.recordings.front());
    }
    config.recordings = {std::move(given)};
  }
  take_runs_apart(config.recordings);
  take_runs_apart(config.test_recordings);
  name_recordings(config);
  for (const dsp::BoundSetting<Config>& row : config_rows()) {
    const dsp::Settings table = document.table(row.table);
    if (row.read) table.attempt([&] { row.read(table, row.key, config); });
  }
  const dsp::Settings library = document.table("library");
  document.attempt([&] { check_bands(document.table("prepare"), config.prepare); });
  document.attempt([&] { check_library(library, config.library); });
  config.segment_file = from_folder(folder, config.segment_file);
  config.default_terms = config.library.order > 0;
  config.library_place = library.place(library.has("only") ? "only" : library.has("terms") ? "terms" : "order");
  config.fit.place = document.table("fit").place("target");
  document.attempt([&] { config.ranges = read_range_tables(document, config.recordings); });
  document.finish();
  if (config.recordings.empty())
    throw document.fault("", "config.missing",
                         config.test_recordings.empty()
                             ? "no [[recording]]. Add one: [[recording]] and file = \"...\""
                             : "every [[recording]] is for testing. Add one to fit, without use = \"test\"");
  return config;
}

fs::path relative_to(const fs::path& file, const fs::path& folder) {
  if (file.empty()) return file;
  return located_path(file).lexically_relative(fs::weakly_canonical(fs::absolute(folder)));
}

}  // namespace

RecordingConfig completed(RecordingConfig recording, const RecordingConfig& first) {
  std::error_code ignored;
  if (recording.sidecar.empty() && !fs::exists(dsp::sidecar_path(recording.file), ignored)) {
    const fs::path own = first.sidecar.empty() ? dsp::sidecar_path(first.file) : first.sidecar;
    if (fs::exists(own, ignored)) recording.sidecar = own;
  }
  if (recording.use.empty()) recording.use = first.use;
  recording.uncalibrated = recording.uncalibrated || first.uncalibrated;
  return recording;
}

Config read_config(const fs::path& input, const std::vector<std::string>& overrides, const fs::path& recording) {
  const bool is_config = input.extension() == ".toml";
  std::error_code unknown;
  if (!is_config && fs::is_directory(input, unknown))
    throw dsp::Fault(dsp::FaultKind::input, "file.kind",
                     fmt::format("{}: is a directory, want a recording, or a config NAME.toml", input.string()));
  const dsp::Settings document =
      is_config ? dsp::Settings::from_file(input, overrides)
                : dsp::Settings::from_text(
                      fmt::format("[[recording]]\nfile = {}\n", dsp::toml_quoted(input.filename().string())),
                      input.string(), overrides);
  return read_document(document, input.parent_path(), recording);
}

std::string to_toml(const Config& config, const fs::path& folder) {
  std::string text = "schema = " + dsp::toml_value(config_schema) + "\n";
  for (const auto* recordings : {&config.recordings, &config.test_recordings})
    for (RecordingConfig recording : *recordings) {
      recording.file = relative_to(recording.file, folder);
      recording.sidecar = relative_to(recording.sidecar, folder);
      text += dsp::written(recording_rows(), recording);
    }
  Config moved = config;
  moved.segment_file = relative_to(config.segment_file, folder);
  text += dsp::written(config_rows(), moved);
  for (const ident::Range& range : config.ranges)
    text += "\n[[range]]\n" + dsp::written(dsp::range_rows(), range.spec) + dsp::written(range_rows(), range);
  return text;
}

}  // namespace apps
