#include "apps/config/config.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "dsp/io/settings.hpp"
#include "dsp/names.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

constexpr std::int64_t schema = 1;
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
  for (const std::string& role : use.keys()) {
    try {
      static_cast<void>(dsp::role_from_string(role));
    } catch (const std::invalid_argument& error) {
      throw use.fault(role, "config.unknown_key", error.what());
    }
    result.use[role] = use.need_text(role);
  }
  return result;
}

dsp::AccelerationSource acceleration_source(const std::string& word) {
  if (word == "accelerometer") return dsp::AccelerationSource::accelerometer;
  return word == "displacement" ? dsp::AccelerationSource::displacement : dsp::AccelerationSource::automatic;
}

std::string_view word(dsp::AccelerationSource source) {
  if (source == dsp::AccelerationSource::accelerometer) return "accelerometer";
  return source == dsp::AccelerationSource::displacement ? "displacement" : "automatic";
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
  if (!prepare.is_text("zero")) return {ZeroChoice::Kind::value, prepare.need_number("zero")};
  return {prepare.choice("zero", "none", {"none", "regime-mean"}) == "none" ? ZeroChoice::Kind::none
                                                                            : ZeroChoice::Kind::regime_mean};
}

/// A number that TOML reads back as the same double and as a float.
std::string real(double value) {
  const std::string text = fmt::format("{}", value);
  return text.find_first_of(".einf") == std::string::npos ? text + ".0" : text;
}

/// Keys of [segment] and the options they set.
constexpr std::array<std::pair<std::string_view, double dsp::SegmentOptions::*>, 9> segment_keys{
    {{"stick_speed_m_per_s", &dsp::SegmentOptions::stick_speed_m_per_s},
     {"stick_duration_s", &dsp::SegmentOptions::stick_duration_s},
     {"stick_halt_s", &dsp::SegmentOptions::stick_halt_s},
     {"stick_margin_s", &dsp::SegmentOptions::stick_margin_s},
     {"high_enter_m", &dsp::SegmentOptions::high_enter_m},
     {"high_leave_m", &dsp::SegmentOptions::high_leave_m},
     {"envelope_window_s", &dsp::SegmentOptions::envelope_window_s},
     {"baseline_window_s", &dsp::SegmentOptions::baseline_window_s},
     {"min_duration_s", &dsp::SegmentOptions::min_duration_s}}};

dsp::SegmentOptions read_segment(const dsp::Settings& table) {
  dsp::SegmentOptions result;
  for (const auto& [key, option] : segment_keys) result.*option = table.number(key, result.*option, not_negative);
  if (result.high_enter_m > 0.0 && result.high_leave_m > result.high_enter_m)
    throw table.fault("high_leave_m", "config.range",
                      fmt::format("got {}, want at most high_enter_m = {}", result.high_leave_m, result.high_enter_m));
  return result;
}

ident::LibraryOptions read_library(const dsp::Settings& table) {
  ident::LibraryOptions result;
  result.order = static_cast<int>(table.integer("order", result.order, {.from = 0, .to = 1000}));
  if (table.has("variables")) result.variables = table.texts("variables");
  result.terms = table.texts("terms");
  result.constant = table.flag("constant", result.constant);
  result.max_terms = static_cast<int>(table.integer("max_terms", result.max_terms, {.from = 1, .to = 10000}));
  if (result.order == 0 && result.terms.empty())
    throw table.fault("order", "config.missing",
                      "order = 0 without terms leaves no candidates. Give terms = [...] or a higher order");
  return result;
}

double read_method_setting(const dsp::Settings& table, const ident::MethodSetting& setting) {
  if (setting.words.empty()) return table.need_number(setting.name, setting.may_be_zero ? not_negative : positive);
  return setting.index_of(table.choice(setting.name, "", {setting.words.begin(), setting.words.end()}));
}

FitConfig read_fit(const dsp::Settings& table) {
  FitConfig result;
  result.target = table.text("target", result.target);
  result.place = table.place("target");
  if (table.has("methods")) {
    result.methods.clear();
    for (const std::string& name : table.texts("methods")) {
      try {
        result.methods.push_back(ident::method_named(name).method);
      } catch (const std::invalid_argument& error) {
        throw table.fault("methods", "config.range", error.what());
      }
    }
    if (result.methods.empty())
      throw table.fault("methods", "config.range", "no method. Name at least one: [\"fast_rvm\"]");
  }
  for (const ident::MethodSetting& setting : ident::method_settings())
    if (table.has(setting.name)) result.settings.set(setting.name, read_method_setting(table, setting));
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
  for (const std::string& key : table.keys()) {
    const std::string full = study_key(key);
    if (full == key) {
      std::vector<std::string_view> known;
      for (const auto& [name, path] : study_keys) known.push_back(name);
      for (const ident::MethodSetting& setting : ident::method_settings()) known.push_back(setting.name);
      throw table.fault(key, "config.unknown_key", fmt::format("want one of {}", fmt::join(known, ", ")));
    }
    StudyAxis axis{full, {}};
    const ident::MethodSetting* setting = ident::find_method_setting(key);
    if (key == "recipe" || key == "target" || (setting != nullptr && !setting->words.empty()))
      axis.values = table.texts(key);
    else
      for (const double value : table.numbers(key)) axis.values.push_back(fmt::format("{}", value));
    if (axis.values.empty()) throw table.fault(key, "config.missing", "no value. Give at least one");
    result.push_back(std::move(axis));
  }
  return result;
}

int recording_number(const dsp::Settings& range, const std::vector<RecordingConfig>& recordings) {
  if (!range.has("recording")) return recordings.size() == 1 ? 1 : 0;
  if (!range.is_text("recording"))
    return static_cast<int>(range.integer("recording", 0, {.from = 1, .to = static_cast<double>(recordings.size())}));
  const std::string name = range.need_text("recording");
  std::vector<std::string> known;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    known.push_back(recordings[i].file.stem().string());
    if (name == known.back() || name == recordings[i].file.filename().string()) return static_cast<int>(i) + 1;
  }
  throw range.fault("recording", "range.recording",
                    fmt::format("no recording '{}', want one of {} or a number from 1 to {}", name,
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

std::string relative_to(const fs::path& file, const fs::path& folder) {
  return fs::weakly_canonical(fs::absolute(file))
      .lexically_relative(fs::weakly_canonical(fs::absolute(folder)))
      .generic_string();
}

std::string text_array(const std::vector<std::string>& texts) {
  std::vector<std::string> quoted;
  for (const std::string& text : texts) quoted.push_back(dsp::toml_quoted(text));
  return fmt::format("[{}]", fmt::join(quoted, ", "));
}

std::string segment_text(const Config& config, const fs::path& folder) {
  std::string text = fmt::format("[segment]\nfind = {}\n", config.segment);
  if (!config.segment_file.empty())
    text += fmt::format("file = {}\n", dsp::toml_quoted(relative_to(config.segment_file, folder)));
  if (config.split_by_direction) text += "split = \"sgn(v)\"\n";
  for (const auto& [key, option] : segment_keys)
    if (config.segment_options.*option > 0.0)
      text += fmt::format("{} = {}\n", key, real(config.segment_options.*option));
  return text + "\n";
}

std::string recording_text(const RecordingConfig& recording, const fs::path& folder) {
  std::string text = fmt::format("[[recording]]\nfile = {}\n", dsp::toml_quoted(relative_to(recording.file, folder)));
  if (!recording.sidecar.empty())
    text += fmt::format("sidecar = {}\n", dsp::toml_quoted(relative_to(recording.sidecar, folder)));
  text += fmt::format("salvage = {}\nuncalibrated = {}\n", recording.salvage, recording.uncalibrated);
  std::vector<std::string> pairs;
  for (const auto& [role, channel] : recording.use)
    pairs.push_back(fmt::format("{} = {}", role, dsp::toml_quoted(channel)));
  if (recording.test) text += "use = \"test\"\n";
  if (!pairs.empty()) text += fmt::format("use = {{ {} }}\n", fmt::join(pairs, ", "));
  return text + "\n";
}

std::string prepare_text(const Config& config) {
  const dsp::PrepareOptions& prepare = config.prepare;
  const ZeroChoice& zero = config.zero;
  std::string text =
      fmt::format("[prepare]\nrecipe = \"{}\"\n", prepare.recipe == dsp::Recipe::paper ? "paper" : "matched");
  const auto known = [&](std::string_view key, double value) {
    if (value > 0.0) text += fmt::format("{} = {}\n", key, real(value));
  };
  known("rate_hz", prepare.rate_hz);
  known("cutoff_hz", prepare.cutoff_hz);
  known("rolloff_hz", prepare.rolloff_hz);
  known("state_cutoff_hz", prepare.state_cutoff_hz);
  known("state_rolloff_hz", prepare.state_rolloff_hz);
  known("bus_rate_hz", prepare.intermediate_rate_hz);
  text += fmt::format("acceleration = \"{}\"\nequalise = {}\nscale = \"{}\"\n", word(prepare.acceleration),
                      prepare.equalise,
                      prepare.scale == dsp::ScaleReference::accelerometer ? "accelerometer" : "displacement");
  if (zero.kind == ZeroChoice::Kind::value) text += fmt::format("zero = {}\n", real(zero.value_m));
  if (zero.kind == ZeroChoice::Kind::none) text += "zero = \"none\"\n";
  if (zero.kind == ZeroChoice::Kind::regime_mean) text += "zero = \"regime-mean\"\n";
  return text + fmt::format("max_clipped = {}\n\n", real(config.max_clipped));
}

std::string fit_text(const FitConfig& fit) {
  std::vector<std::string> methods;
  for (const ident::Method method : fit.methods) methods.emplace_back(to_string(method));
  std::string text = fmt::format("[fit]\ntarget = {}\nmethods = {}\ntrain_share = {}\n", dsp::toml_quoted(fit.target),
                                 text_array(methods), real(fit.train_fraction));
  for (const ident::MethodSetting& setting : ident::method_settings()) {
    const double value = fit.settings.value(setting.name);
    if (!setting.words.empty())
      text += fmt::format("{} = \"{}\"\n", setting.name, setting.words[static_cast<std::size_t>(value)]);
    else if (value >= 0.0)
      text += fmt::format("{} = {}\n", setting.name, real(value));
  }
  return text + "\n";
}

std::string range_text(const ident::Range& range) {
  std::string text = fmt::format("[[range]]\nname = {}\n", dsp::toml_quoted(range.spec.name));
  if (range.recording > 0) text += fmt::format("recording = {}\n", range.recording);
  if (!range.regime.any()) text += fmt::format("regime = \"{}\"\n", range.regime.name());
  text += fmt::format("from = {}\n", real(range.spec.from_s));
  if (std::isfinite(range.spec.to_s)) text += fmt::format("to = {}\n", real(range.spec.to_s));
  if (range.spec.train_to_s) text += fmt::format("train_to = {}\n", real(*range.spec.train_to_s));
  if (!range.spec.where.empty()) text += fmt::format("where = {}\n", dsp::toml_quoted(range.spec.where));
  return text + "\n";
}

}  // namespace

std::string study_key(const std::string& name) {
  if (ident::find_method_setting(name) != nullptr) return "fit." + name;
  const auto known =
      std::find_if(study_keys.begin(), study_keys.end(), [&](const auto& key) { return key.first == name; });
  return known == study_keys.end() ? name : std::string(known->second);
}

Config read_config(const fs::path& input, const std::vector<std::string>& overrides) {
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
  document.check_schema(schema);
  Config config;
  for (const dsp::Settings& table : document.tables("recording")) {
    RecordingConfig recording = read_recording_table(table, input.parent_path());
    (recording.test ? config.test_recordings : config.recordings).push_back(std::move(recording));
  }
  const dsp::Settings prepare = document.table("prepare"), library = document.table("library");
  config.prepare = read_prepare(prepare);
  config.zero = read_zero(prepare);
  config.max_clipped = prepare.number("max_clipped", config.max_clipped, {.from = 0.0, .to = 1.0});
  const dsp::Settings segment = document.table("segment");
  config.segment = segment.flag("find", config.segment);
  config.segment_options = read_segment(segment);
  config.segment_file = from_folder(input.parent_path(), segment.text("file", ""));
  config.split_by_direction = segment.choice("split", "none", {"none", "sgn(v)"}) == "sgn(v)";
  config.library = read_library(library);
  config.default_terms = !library.has("terms") && config.library.order > 0;
  config.library_place = library.place(library.has("terms") ? "terms" : "order");
  config.fit = read_fit(document.table("fit"));
  config.study = read_study(document.table("study"));
  config.ranges = read_range_tables(document, config.recordings);
  if (config.recordings.empty() && document.has("channel"))
    throw document.fault("", "config.missing", "this is a sidecar, not a config. Name the recording beside it");
  document.finish();
  if (config.recordings.empty())
    throw document.fault("", "config.missing",
                         config.test_recordings.empty()
                             ? "no [[recording]]. Add one: [[recording]] and file = \"...\""
                             : "every [[recording]] is for testing. Add one to fit, without use = \"test\"");
  return config;
}

std::string to_toml(const Config& config, const fs::path& folder) {
  std::string text = fmt::format("schema = {}\n\n", schema);
  for (const auto* recordings : {&config.recordings, &config.test_recordings})
    for (const RecordingConfig& recording : *recordings) text += recording_text(recording, folder);
  text += prepare_text(config);
  text += segment_text(config, folder);
  text += fmt::format("[library]\norder = {}\nvariables = {}\nconstant = {}\nterms = {}\nmax_terms = {}\n\n",
                      config.library.order, text_array(config.library.variables), config.library.constant,
                      text_array(config.library.terms), config.library.max_terms);
  text += fit_text(config.fit);
  for (const ident::Range& range : config.ranges) text += range_text(range);
  text.pop_back();
  return text;
}

}  // namespace apps
