#include "apps/config/config.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <utility>

#include "apps/config/config_keys.hpp"
#include "apps/config/recording_name.hpp"
#include "dsp/io/settings.hpp"
#include "dsp/io/sidecar.hpp"
#include "dsp/names.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

constexpr dsp::NumberRange positive{.from = 0.0, .above = true};
constexpr dsp::NumberRange not_negative{.from = 0.0};

fs::path from_folder(const fs::path& folder, const std::string& text) {
  return text.empty() ? fs::path() : (folder / text).lexically_normal();
}

RecordingConfig read_recording_table(const dsp::Settings& table, const fs::path& folder) {
  RecordingConfig result;
  const std::string file = table.need_text("file");
  if (file.empty()) throw table.fault("file", "config.range", "is empty, want the name of a recording");
  result.file = from_folder(folder, file);
  result.sidecar = from_folder(folder, table.text("sidecar", ""));
  result.salvage = table.flag("salvage", false);
  result.uncalibrated = table.flag("uncalibrated", false);
  if (table.has("use") && table.is_text("use")) {
    result.test = table.choice("use", "", {"test"}) == "test";
    return result;
  }
  const dsp::Settings use = table.table("use");
  for (const std::string& role : use.keys())
    use.attempt([&] {
      try {
        static_cast<void>(dsp::role_from_string(role));
      } catch (const std::invalid_argument& error) {
        throw use.fault(role, "config.unknown_key", error.what());
      }
      result.use[role] = use.need_text(role);
    });
  return result;
}

dsp::AccelerationSource acceleration_source(const std::string& word) {
  if (word == "accelerometer") return dsp::AccelerationSource::accelerometer;
  return word == "displacement" ? dsp::AccelerationSource::displacement : dsp::AccelerationSource::automatic;
}

dsp::PrepareOptions read_prepare(const dsp::Settings& table) {
  dsp::PrepareOptions result;
  result.recipe =
      table.choice("recipe", "matched", {"matched", "paper"}) == "paper" ? dsp::Recipe::paper : dsp::Recipe::matched;
  result.rate_hz = table.number("rate_hz", 0.0, positive);
  result.cutoff_hz = table.number("cutoff_hz", 0.0, positive);
  result.rolloff_hz = table.number("rolloff_hz", 0.0, positive);
  result.state_cutoff_hz = table.number("state_cutoff_hz", 0.0, positive);
  result.state_rolloff_hz = table.number("state_rolloff_hz", 0.0, positive);
  result.intermediate_rate_hz = table.number("bus_rate_hz", 0.0, positive);
  result.integrate_from_hz = table.number("integrate_from_hz", 0.0, positive);
  result.acceleration =
      acceleration_source(table.choice("acceleration", "automatic", {"automatic", "accelerometer", "displacement"}));
  result.equalise = table.flag("equalise", result.equalise);
  result.scale = table.choice("scale", "displacement", {"displacement", "accelerometer"}) == "accelerometer"
                     ? dsp::ScaleReference::accelerometer
                     : dsp::ScaleReference::displacement;
  const auto below = [&](std::string_view low_key, double low, std::string_view high_key, double high) {
    if (low > 0.0 && high > 0.0 && !(low < high))
      throw table.fault(low_key, "config.range",
                        fmt::format("got {}, want less than {} = {}. Lower it or leave it out", low, high_key, high));
  };
  below("rolloff_hz", result.rolloff_hz, "cutoff_hz", result.cutoff_hz);
  below("state_rolloff_hz", result.state_rolloff_hz, "state_cutoff_hz", result.state_cutoff_hz);
  below("cutoff_hz", result.cutoff_hz, "rate_hz / 2", result.rate_hz / 2);
  below("state_cutoff_hz", result.state_cutoff_hz, "bus_rate_hz / 2", result.intermediate_rate_hz / 2);
  return result;
}

ZeroChoice read_zero(const dsp::Settings& prepare) {
  if (!prepare.has("zero")) return {};
  if (!prepare.is_text("zero")) return {ZeroChoice::Kind::value, *prepare.find_number("zero")};
  return {prepare.choice("zero", "none", {"none", "regime-mean"}) == "none" ? ZeroChoice::Kind::none
                                                                            : ZeroChoice::Kind::regime_mean};
}

/// Keys of versions before, and what is in their place.
void refuse_former_keys(const dsp::Settings& segment) {
  for (const char* key : {"high_enter_m", "high_leave_m"})
    segment.refuse_former(
        key,
        "Low and high are distinguished by the phase of x: remove the line, or set high_amplitude_m, one "
        "amplitude between them");
  for (const char* key : {"envelope_window_s", "baseline_window_s", "min_duration_s", "stick_duration_s",
                          "stick_halt_s", "stick_acceleration_share", "stick_margin_s"})
    segment.refuse_former(key, "It follows from the record now: remove the line");
}

dsp::SegmentOptions read_segment(const dsp::Settings& table) {
  refuse_former_keys(table);
  dsp::SegmentOptions result;
  for (const auto& [key, option] : segment_keys) result.*option = table.number(key, result.*option, not_negative);
  return result;
}

ident::LibraryOptions read_library(const dsp::Settings& table) {
  ident::LibraryOptions result;
  result.order = static_cast<int>(table.integer("order", result.order, {.from = 0, .to = 1000}));
  if (table.has("variables")) result.variables = table.texts("variables");
  table.exclusive("only", "terms");
  table.exclusive("only", "order");
  result.terms = table.texts(table.has("only") ? "only" : "terms");
  if (table.has("only")) result.order = 0;
  result.constant = table.flag("constant", result.constant);
  result.max_terms = static_cast<int>(table.integer("max_terms", result.max_terms, {.from = 1, .to = 10000}));
  if (result.order == 0 && result.terms.empty())
    throw table.fault("order", "config.missing",
                      "order = 0 without terms leaves no candidates. Give terms = [...] or a higher order");
  return result;
}

void read_method_setting(const dsp::Settings& table, const ident::MethodSetting& setting,
                         ident::MethodSettings& settings) {
  const double preset = settings.value(setting.name);
  double value = 0.0;
  if (setting.words.empty())
    value = table.number(setting.name, preset, setting.may_be_zero ? not_negative : positive);
  else
    value = setting.index_of(table.choice(setting.name, setting.words[static_cast<std::size_t>(preset)],
                                          {setting.words.begin(), setting.words.end()}));
  if (table.has(setting.name)) settings.set(setting.name, value);  // to all methods, whose presets may differ
}

ident::Method method_of(const std::string& name, const dsp::Settings& fit) {
  try {
    return ident::method_named(name).method;
  } catch (const std::invalid_argument& error) {
    std::vector<std::string> known;
    for (const ident::MethodDescription& method : ident::methods()) known.emplace_back(method.name);
    const std::string near = dsp::nearest(name, known);
    throw fit.fault("methods", "config.range",
                    error.what() + (near.empty() ? "" : fmt::format(". Did you mean '{}'?", near)));
  }
}

FitConfig read_fit(const dsp::Settings& table) {
  FitConfig result;
  result.target = table.text("target", result.target);
  result.place = table.place("target");
  if (table.has("methods")) {
    result.methods.clear();
    const std::vector<std::string> names = table.texts("methods");
    for (const std::string& name : names) table.attempt([&] { result.methods.push_back(method_of(name, table)); });
    if (names.empty()) throw table.fault("methods", "config.range", "no method. Name at least one: [\"fast_rvm\"]");
  }
  for (const ident::MethodSetting& setting : ident::method_settings())
    read_method_setting(table, setting, result.settings);
  result.train_fraction = table.number("train_share", result.train_fraction, {.from = 0.0, .to = 1.0, .above = true});
  return result;
}

/// Short names of what is worth varying beside the settings of methods; other keys are written in full.
constexpr std::array<std::pair<std::string_view, std::string_view>, 6> study_keys{{{"order", "library.order"},
                                                                                   {"cutoff_hz", "prepare.cutoff_hz"},
                                                                                   {"rolloff_hz", "prepare.rolloff_hz"},
                                                                                   {"recipe", "prepare.recipe"},
                                                                                   {"train_share", "fit.train_share"},
                                                                                   {"target", "fit.target"}}};

std::vector<StudyAxis> read_study(const dsp::Settings& table) {
  std::vector<StudyAxis> result;
  for (const std::string& key : study_names()) {
    StudyAxis axis{study_key(key), {}};
    const ident::MethodSetting* setting = ident::find_method_setting(key);
    if (key == "recipe" || key == "target" || (setting != nullptr && !setting->words.empty()))
      axis.values = table.texts(key);
    else
      for (const double value : table.numbers(key)) axis.values.push_back(fmt::format("{}", value));
    if (!table.has(key)) continue;
    if (axis.values.empty()) throw table.fault(key, "config.missing", "no value. Give at least one");
    result.push_back(std::move(axis));
  }
  return result;
}

int recording_number(const dsp::Settings& range, const std::vector<RecordingConfig>& recordings) {
  if (!range.has("recording")) return recordings.size() == 1 ? 1 : 0;
  if (!range.is_text("recording"))
    return static_cast<int>(range.integer("recording", 0, {.from = 1, .to = static_cast<double>(recordings.size())}));
  const std::string name = *range.find_text("recording");
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
    result[i].regime = dsp::regime_set_from_string(tables[i].choice("regime", "", dsp::regime_set_names()));
  }
  return result;
}

}  // namespace

std::string study_key(const std::string& name) {
  if (ident::find_method_setting(name) != nullptr) return "fit." + name;
  const auto known =
      std::find_if(study_keys.begin(), study_keys.end(), [&](const auto& key) { return key.first == name; });
  return known == study_keys.end() ? name : std::string(known->second);
}

std::set<std::string> study_names() {
  std::set<std::string> names;
  for (const auto& [name, path] : study_keys) names.emplace(name);
  for (const ident::MethodSetting& setting : ident::method_settings()) names.emplace(setting.name);
  return names;
}

namespace {

Config read_document(const dsp::Settings& document, const fs::path& folder, const fs::path& recording = {}) {
  document.check_schema(config_schema);
  if (!document.has("recording") && document.has("channel"))
    throw document.fault("", "config.missing", "this is a sidecar, not a config. Name the recording beside it");
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
  name_recordings(config);
  const dsp::Settings prepare = document.table("prepare"), library = document.table("library"),
                      segment = document.table("segment");
  document.attempt([&] { config.prepare = read_prepare(prepare); });
  config.zero = read_zero(prepare);
  config.max_clipped = prepare.number("max_clipped", config.max_clipped, {.from = 0.0, .to = 1.0});
  config.segment = segment.flag("find", config.segment);
  document.attempt([&] { config.segment_options = read_segment(segment); });
  config.segment_file = from_folder(folder, segment.text("file", ""));
  config.split_by_direction = segment.choice("split", "none", {"none", "sgn(v)"}) == "sgn(v)";
  document.attempt([&] { config.library = read_library(library); });
  config.default_terms = config.library.order > 0;
  config.library_place = library.place(library.has("only") ? "only" : library.has("terms") ? "terms" : "order");
  document.attempt([&] { config.fit = read_fit(document.table("fit")); });
  const dsp::Settings output = document.table("output");
  config.rows = output.flag("rows", config.rows);
  config.figures = output.flag("figures", config.figures);
  (void)output.flag("full", true);  // of earlier versions, whose tables had a form with fewer rows
  document.attempt([&] { config.study = read_study(document.table("study")); });
  document.attempt([&] { config.ranges = read_range_tables(document, config.recordings); });
  document.finish(config_settings);
  if (config.recordings.empty())
    throw document.fault("", "config.missing",
                         config.test_recordings.empty()
                             ? "no [[recording]]. Add one: [[recording]] and file = \"...\""
                             : "every [[recording]] is for testing. Add one to fit, without use = \"test\"");
  return config;
}

}  // namespace

std::vector<dsp::AskedSetting> config_settings() {
  std::vector<dsp::AskedSetting> all;
  // What may be written as a number or a table and as a text is written both ways.
  for (const char* text : {"[[recording]]\nfile = \"a\"\nuse = {}\n[prepare]\nzero = 0\n[[range]]\nrecording = 1\n",
                           "[[recording]]\nfile = \"a\"\n[[recording]]\nfile = \"b\"\nuse = \"test\"\n[prepare]\n"
                           "zero = \"none\"\n[fit]\nmethods = \"ols\"\n[library]\nvariables = \"x\"\n[[range]]\n"
                           "recording = \"a\"\n"}) {
    const dsp::Settings document = dsp::Settings::from_text(text, "");
    (void)read_document(document, "");
    dsp::add_asked(all, document.asked());
  }
  return all;
}

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

}  // namespace apps
