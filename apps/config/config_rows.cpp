#include "apps/config/config_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "dsp/io/sample_source.hpp"
#include "dsp/io/sidecar_rows.hpp"
#include "dsp/values/names.hpp"
#include "dsp/values/signals.hpp"

namespace apps {
namespace {

using dsp::Settings;
using Key = const std::string&;
using Rows = dsp::SettingRows<Config>;
using Row = dsp::BoundSetting<Config>;

constexpr dsp::NumberRange above_zero{.from = 0.0, .above = true};
constexpr dsp::NumberRange not_negative{.from = 0.0};

/// The member of a member.
template <class Outer, class Inner>
auto in(Outer outer, Inner inner) {
  return [=](auto& target) -> auto& {
    return target.*outer.*inner;
  };
}

Row section(std::string table, std::string meaning) {
  return {{.key = std::move(table), .type = {.section = true}, .meaning = std::move(meaning)}};
}

void read_use(const Settings& table, Key key, RecordingConfig& recording) {
  recording.test = table.is_text(key);
  recording.use = table.notes(key);
}

std::string written_use(const RecordingConfig& recording) {
  if (recording.test) return "\"test\"";
  std::string pairs;
  for (const auto& [role, channel] : recording.use)
    pairs += fmt::format("{}{} = {}", pairs.empty() ? "" : ", ", role, dsp::toml_quoted(channel));
  return pairs.empty() ? "" : fmt::format("{{ {} }}", pairs);
}

constexpr std::array<std::pair<const char*, ZeroChoice::Kind>, 4> zero_words{{{"fit", ZeroChoice::Kind::fit},
                                                                              {"mean", ZeroChoice::Kind::mean},
                                                                              {"none", ZeroChoice::Kind::none},
                                                                              {"regime-mean", ZeroChoice::Kind::fit}}};

void read_zero(const Settings& table, Key key, Config& config) {
  if (const auto value = table.number(key)) config.zero = {ZeroChoice::Kind::value, *value};
  for (const auto& [word, kind] : zero_words)
    if (table.text(key) == word) config.zero = {kind};
}

std::string written_zero(const Config& config) {
  if (config.zero.kind == ZeroChoice::Kind::value) return dsp::toml_value(config.zero.value_m);
  for (const auto& [word, kind] : zero_words)
    if (config.zero.kind == kind) return dsp::toml_quoted(word);
  return "";
}

Rows prepare_rows() {
  using Options = dsp::PrepareOptions;
  using Source = dsp::AccelerationSource;
  using Scale = dsp::ScaleReference;
  const auto prepare = [](auto member) { return in(&Config::prepare, member); };
  const auto hz = [&](const char* key, double Options::*member, const char* meaning, const char* left_out) {
    return Row::of(key, prepare(member), {.range = above_zero}, meaning, "Hz", left_out);
  };
  return {
      section("prepare", "From the recording to signals on one clock, in SI units."),
      Row::choice("recipe", prepare(&Options::recipe),
                  {{"matched", dsp::Recipe::matched}, {"paper", dsp::Recipe::paper}},
                  "\"matched\": candidate terms are formed from wide-band signals and pass the filter that the target "
                  "passed. \"paper\": signals are filtered first and terms formed from them; sensors stay as they are.")
          .varied(),
      hz("rate_hz", &Options::rate_hz, "Rate of the rows of the regression; the recording is decimated to it.",
         "2.5 times cutoff_hz at least, a whole part of the record's own"),
      hz("cutoff_hz", &Options::cutoff_hz,
         "Above this frequency signals and terms are zero. Keep the harmonics of the motion below it.",
         "where the motion falls below its noise, and printed; 0.4 of rate_hz where that is given")
          .varied(),
      hz("rolloff_hz", &Options::rolloff_hz, "Where the taper towards cutoff_hz begins.", "0.78125 of cutoff_hz")
          .varied(),
      hz("state_cutoff_hz", &Options::state_cutoff_hz,
         "Upper end of the band in which x and v are formed before terms are made of them.",
         "twice cutoff_hz, or what the intermediate rate allows"),
      hz("state_rolloff_hz", &Options::state_rolloff_hz, "Where the taper towards state_cutoff_hz begins.",
         "0.64 of state_cutoff_hz; at the record's own rate 0.75 of it"),
      hz("bus_rate_hz", &Options::intermediate_rate_hz,
         "Intermediate rate at which terms are formed before they are decimated to rate_hz.", "about 10 times rate_hz"),
      hz("integrate_from_hz", &Options::integrate_from_hz,
         "Where no displacement was recorded, x is integrated from a velocity or an acceleration above this frequency; "
         "slower motion and the zero of x are not known then.",
         "where the drift of the sensor ends, and printed"),
      Row::choice("acceleration", prepare(&Options::acceleration),
                  {{"automatic", Source::automatic},
                   {"accelerometer", Source::accelerometer},
                   {"displacement", Source::displacement}},
                  "Where accelerations come from: the accelerometers, the second derivative of the displacements, or "
                  "\"automatic\": accelerometers where base and payload have one."),
      Row::of("equalise", prepare(&Options::equalise), {},
              "Correct displacement and accelerometer of one body against each other (gain, lag, AC coupling) where "
              "both are recorded. Only with recipe \"matched\"."),
      Row::choice("scale", prepare(&Options::scale),
                  {{"displacement", Scale::displacement}, {"accelerometer", Scale::accelerometer}},
                  "Which of the two sensors of a body sets the scale where their gains differ."),
      Row::custom(
          "zero", {.number = true, .text = true, .words = {"fit", "mean", "none", "regime-mean"}},
          "What is subtracted from x: no value (\"none\"), the mean of the first range (\"mean\"), this number, "
          "or that mean and what the equation finds beyond it (\"fit\", formerly \"regime-mean\"). The equation "
          "is about the zero that is printed.",
          "m",
          "\"fit\" where x is the difference of two displacements, whose zeros are arbitrary; a single sensor "
          "keeps its own",
          read_zero, written_zero),
      Row::of("max_clipped", &Config::max_clipped, {.range = {.from = 0.0, .to = 1.0}},
              "Fraction of a training interval that a channel may have clipped. More ends the run with exit code 3.")};
}

Rows library_rows() {
  using Options = ident::LibraryOptions;
  const auto library = [](auto member) { return in(&Config::library, member); };
  const auto read_only = [](const Settings& table, Key key, Config& config) {
    const auto only = table.texts(key);
    if (only) config.library.order = 0, config.library.terms = *only;
  };
  return {
      section("library", "Candidate terms of the equation. `ardent help terms` says what a term may be."),
      Row::of("order", library(&Options::order), {.range = {.from = 0, .to = 24}},
              "All products of the variables up to this degree are candidates; 0: none but `terms`.")
          .varied(),
      Row::of("variables", library(&Options::variables), {}, "Signals of which products are formed."),
      Row::custom("only", {.text = true, .several = true},
                  "These candidates and no others, instead of order and terms: [\"x\", \"v\", \"ddr\"].", "",
                  "order and terms count", read_only),
      Row::of("terms", library(&Options::terms), {},
              "Further candidates: [\"abs(x)*x\", \"sin(x)\"]. With order above 0, sgn(v) and every recorded input "
              "(ddr, f and other channels in N, N*m, Pa, V or A) are candidates in any case."),
      Row::of("constant", library(&Options::constant), {},
              "Whether the constant \"1\" is a candidate beside the products."),
      Row::choice("inner", &Config::inner,
                  {{"none", ident::Inner::none}, {"hysteresis", ident::Inner::hysteresis}, {"lag", ident::Inner::lag}},
                  "A state z that nothing recorded, sought from the motion of one body whose displacement was; it "
                  "is kept where the samples ask for it. \"hysteresis\": a force with a memory; the equation of the "
                  "acceleration has -z, and z has one of its own. \"lag\": z follows a recorded input as an "
                  "actuator of first order does, and acts in its place; or it follows x, and is what a slow "
                  "displacement sensor shows. With fit.target = \"f\" the motion was imposed and f, the force that it "
                  "took, has z as a part. Beside it order, constant, terms and only count.",
                  "\"none\""),
      Row::of("max_terms", library(&Options::max_terms), {.range = {.from = 1, .to = 10000}},
              "A larger library is refused before anything is computed.")};
}

Rows segment_rows() {
  using Options = dsp::SegmentOptions;
  Rows rows{
      section("segment", "Regimes of motion: stick, low and high amplitude. Thresholds used are in quality.json."),
      Row::of("find", &Config::segment, {}, "Look for regimes. If false, the whole recording is one."),
      Row::of("stick_speed_m_per_s", in(&Config::segment_options, &Options::stick_speed_m_per_s),
              {.range = not_negative}, "Motion slower than this is a stop, unless it only reverses.", "m/s",
              "chosen from the record"),
      Row::of("high_amplitude_m", in(&Config::segment_options, &Options::high_amplitude_m), {.range = not_negative},
              "Amplitudes of x above this are high, below it low. Left out: low is the lower branch of a resonance, "
              "where x moves against the base (or force) that drives it, high the upper one, where it moves in phase.",
              "m", "branches are seen in the phase"),
      Row::of("file", &Config::segment_file, {},
              "segments.json of an earlier run, edited or not: its labels are used; rows that the filters mix with a "
              "stop are of the stop.",
              "", "regimes are found in the record"),
      Row::choice("split", &Config::split_by_direction, {{"none", false}, {"sgn(v)", true}},
                  "\"sgn(v)\" makes two of every range: v > 0 (\"low+\") and v < 0 (\"low-\").", "\"none\"")};
  // Of versions before.
  for (const char* key : {"high_enter_m", "high_leave_m"})
    rows.push_back({{.key = key,
                     .former = "Low and high are distinguished by the phase of x: remove the line, or set "
                               "high_amplitude_m, one amplitude between them"}});
  for (const char* key : {"envelope_window_s", "baseline_window_s", "min_duration_s", "stick_duration_s",
                          "stick_halt_s", "stick_acceleration_share", "stick_margin_s"})
    rows.push_back({{.key = key, .former = "It follows from the record now: remove the line"}});
  return rows;
}

/// A setting of methods, whose name and words are in their table.
Row method_row(const ident::MethodSetting& setting) {
  const bool number = setting.words.empty();
  const auto written = [&setting, number](const Config& config) {
    const double value = config.fit.settings.value(setting.name);
    if (!number) return dsp::toml_quoted(setting.words[static_cast<std::size_t>(value)]);
    return value >= 0.0 ? dsp::toml_value(value) : std::string();
  };
  const auto read = [&setting, number](const Settings& table, Key key, Config& config) {
    const auto word = table.text(key);
    if (word) config.fit.settings.set(key, number ? *table.number(key) : setting.index_of(*word));
  };
  Row row = Row::custom(std::string(setting.name),
                        {.number = number,
                         .text = !number,
                         .range = setting.may_be_zero ? not_negative : above_zero,
                         .words = {setting.words.begin(), setting.words.end()}},
                        std::string(setting.help) + ".", "", "", read, written);
  row.fallback = written(Config{});
  if (row.fallback.empty()) row.left_out = "chosen by its rule";
  return std::move(row).varied();
}

ident::Method method_of(const std::string& name, const Settings& fit, Key key) {
  try {
    return ident::method_named(name).method;
  } catch (const std::invalid_argument& error) {
    std::vector<std::string> known;
    for (const ident::MethodDescription& method : ident::methods()) known.emplace_back(method.name);
    const std::string near = dsp::nearest(name, known);
    throw fit.fault(key, "config.range",
                    error.what() + (near.empty() ? "" : fmt::format(". Did you mean '{}'?", near)));
  }
}

void read_methods(const Settings& table, Key key, Config& config) {
  const auto names = table.texts(key);
  if (!names) return;
  config.fit.methods.clear();
  for (const std::string& name : *names)
    table.attempt([&] { config.fit.methods.push_back(method_of(name, table, key)); });
  if (names->empty()) throw table.fault(key, "config.range", "no method. Name at least one: [\"fast_rvm\"]");
}

std::string written_methods(const Config& config) {
  std::vector<std::string> names;
  for (const ident::Method method : config.fit.methods) names.emplace_back(to_string(method));
  return dsp::toml_value(names);
}

Rows fit_rows() {
  Rows rows{section("fit", "Regression. `ardent help methods` describes the methods."),
            Row::of("target", in(&Config::fit, &FitConfig::target), {},
                    "The signal that the equation explains: a, ddy, or another signal of the recording; with "
                    "library.inner = \"hysteresis\" f is the force on an imposed motion.")
                .varied(),
            Row::custom("methods", {.text = true, .several = true},
                        "Which methods fit the equation. The first that is named is listed first; fast_rvm speaks for "
                        "a range where it has an equation.",
                        "", "fast_rvm, slow_rvm, sindy", read_methods, written_methods)};
  for (const ident::MethodSetting& setting : ident::method_settings()) rows.push_back(method_row(setting));
  rows.push_back(
      Row::choice(
          "stage", in(&Config::fit, &FitConfig::stage),
          {{"likelihood", ident::Stage::likelihood}, {"regression", ident::Stage::regression}},
          "\"likelihood\": where it applies, terms and coefficients come from the samples as they were recorded, "
          "in their whole band. \"regression\": always from the filtered rows, below prepare.cutoff_hz.")
          .varied());
  rows.push_back(
      Row::of("train_share", in(&Config::fit, &FitConfig::train_fraction),
              {.range = {.from = 0.0, .to = 1.0, .above = true}},
              "Fraction of a range's rows that is fitted, where it has no train_to. The rest is for testing.")
          .varied());
  return rows;
}

Rows report_rows() {
  const auto said = [](const char* key, std::string ReportHeader::*member, const char* meaning) {
    return Row::of(key, in(&Config::report, member), {}, meaning, "", "not said");
  };
  return {
      section("report", "What the top of report.html says beside the result, as it is written here."),
      Row::of("title", in(&Config::report, &ReportHeader::title), {}, "Its title.", "", "named after the recordings"),
      said("object", &ReportHeader::object, "What was tested."),
      said("test", &ReportHeader::test, "Which test it was."),
      said("operator", &ReportHeader::operator_name, "Who made it."),
      Row::of("date", in(&Config::report, &ReportHeader::date), {.date = true}, "When it was made: 2023-05-04.", "",
              "not said")};
}

/// Values for each setting that a study may call by its key alone.
Rows study_rows(const Rows& others) {
  Rows rows;
  for (const Row& row : others) {
    if (!row.is_varied) continue;
    const std::string full = row.table + "." + row.key;
    const bool number = row.type.number || row.type.whole_number;
    const auto read = [full](const Settings& table, Key key, Config& config) {
      const auto values = table.texts(key);
      if (values && values->empty()) throw table.fault(key, "config.missing", "no value. Give at least one");
      if (values) config.study.push_back({full, *values});
    };
    rows.push_back(Row::custom(row.key, {.number = number, .text = !number, .several = true},
                               fmt::format("Values for {}.", full), "", "not varied", read));
  }
  std::sort(rows.begin(), rows.end(), [](const Row& one, const Row& other) { return one.key < other.key; });
  rows.insert(rows.begin(),
              section("study",
                      "Values that `ardent study` gives to settings, one setting at a time. The option --over replaces "
                      "them and takes any key of a config. `ardent run` ignores this table."));
  return rows;
}

}  // namespace

const dsp::SettingRows<RecordingConfig>& recording_rows() {
  using Recording = dsp::BoundSetting<RecordingConfig>;
  static const dsp::SettingRows<RecordingConfig> rows{
      {{.key = "recording",
        .type = {.elements = true},
        .meaning =
            "A recording. Several are fitted together: one equation for each range, from the rows of all of them. "
            "Terms whose coefficient differs between recordings are found, and have one for each. Without any range, "
            "each recording has an equation of its own, and all together have one."}},
      Recording::of("file", &RecordingConfig::file, {}, fmt::format("The recording: {}.", dsp::readable_formats))
          .needed(),
      Recording::of("sidecar", &RecordingConfig::sidecar, {}, "Its sidecar. Several recordings may name the same one.",
                    "", "NAME.ext.toml beside the recording, if there is one"),
      dsp::run_row(&RecordingConfig::run, "as the sidecar says"),
      Recording::of("salvage", &RecordingConfig::salvage, {},
                    "Read a recording that was cut short, as far as it goes."),
      Recording::of("uncalibrated", &RecordingConfig::uncalibrated, {},
                    "Take channels without a sensitivity as raw numbers. Every output then says that they are raw."),
      Recording::custom("use", {.text = true, .table = true, .words = {"test"}, .example = "{ x = \"laser 2\" }"},
                        "Which channel plays a role that several could play: use = { x = \"laser 2\" }. Or use = "
                        "\"test\": the recording is never fitted, the equation is run free on it and judged there.",
                        "", "the only channel of each role", read_use, written_use)};
  return rows;
}

const dsp::SettingRows<ident::Range>& range_rows() {
  using Range = dsp::BoundSetting<ident::Range>;
  static const dsp::SettingRows<ident::Range> rows = [] {
    std::vector<std::pair<std::string, dsp::RegimeSet>> regimes;
    for (const std::string& name : dsp::regime_set_names())
      regimes.emplace_back(name, dsp::regime_set_from_string(name));
    return dsp::SettingRows<ident::Range>{
        Range::custom(
            "recording", {.whole_number = true, .text = true, .range = {.from = 1}},
            "Number (from 1) or name of the recording it is about, as outputs call it: its file's name, or the end of "
            "its path where several have one name, \"tue/drive.csv\".",
            "", "the only one, else all of them", {},
            [](const ident::Range& range) { return range.recording > 0 ? dsp::toml_value(range.recording) : ""; }),
        Range::choice("regime", &ident::Range::regime, regimes, "Only rows of this regime.",
                      "all but stick and excluded")};
  }();
  return rows;
}

const Rows& config_rows() {
  static const Rows rows = [] {
    Rows all;
    for (const Rows& part : {prepare_rows(), library_rows(), segment_rows(), fit_rows()}) dsp::add_rows(all, part);
    dsp::add_rows(
        all,
        Rows{
            section("output", "What a run folder holds. `ardent help files` lists the files."),
            Row::of("rows", &Config::rows, {},
                    "Whether it has the tables with a row for each sample: prepared.csv, predictions.csv, "
                    "predict-N-NAME.csv. The option --no-rows leaves them out."),
            Row::of("figures", &Config::figures, {},
                    "Whether it has figures/; report.html has them in either case. The option --no-figures leaves "
                    "it out."),
            Row::custom("full", {.flag = true},
                        "Of earlier versions, without effect: tables have every row and all digits.", "", "true", {})});
    dsp::add_rows(all, report_rows());
    dsp::add_rows(all, study_rows(all));
    return all;
  }();
  return rows;
}

const std::vector<dsp::Setting>& config_settings() {
  static const std::vector<dsp::Setting> settings = [] {
    std::vector<dsp::Setting> all{dsp::schema_setting(config_schema)};
    dsp::add_rows(all, recording_rows());
    for (const dsp::SignalInfo& signal : dsp::signal_table())
      all.push_back({.table = "recording.use", .key = std::string(signal.name), .type = {.text = true}});
    all.insert(all.end(), config_rows().begin(), config_rows().end());
    all.push_back(
        {.key = "range",
         .type = {.elements = true},
         .meaning =
             "A part of the recording with an equation of its own. Without any: those of the sidecar; else low, high "
             "and mixed where these regimes are found, else all. Of several recordings each has its own, named after "
             "it (run1, or run1 low), and one range of the name all recordings holds every row of all of them."});
    dsp::add_rows(all, dsp::range_rows(), "range");
    dsp::add_rows(all, range_rows(), "range");
    return all;
  }();
  return settings;
}

std::vector<std::string> override_keys() {
  std::vector<std::string> keys;
  std::string heading, path;
  for (const dsp::Setting& setting : config_settings()) {
    if (setting.is_heading()) {
      heading = setting.key;
      path = heading + (setting.type.elements ? ".0." : ".");
    } else if (setting.table == heading && setting.former.empty()) {
      keys.push_back(path + setting.key);
    }
  }
  return keys;
}

std::string study_key(const std::string& name) {
  for (const Row& row : config_rows())
    if (row.is_varied && row.key == name) return row.table + "." + row.key;
  return name;
}

std::vector<std::string> study_names() {
  std::vector<std::string> names;
  for (const Row& row : config_rows())
    if (row.is_varied) names.push_back(row.key);
  return names;
}

}  // namespace apps
