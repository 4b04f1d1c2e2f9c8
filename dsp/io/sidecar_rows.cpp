#include "dsp/io/sidecar_rows.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "dsp/values/names.hpp"
#include "dsp/values/signals.hpp"

namespace dsp {
namespace {

using ChannelRow = BoundSetting<ChannelSpec>;
using Key = const std::string&;
constexpr double highest_hz = 1e9;

// Runs `parse` and puts the key's place before the message of whatever it throws.
template <typename Parse>
auto placed(const Settings& table, std::string_view key, Parse parse) {
  try {
    return parse();
  } catch (const Fault& fault) {
    throw table.fault(key, fault.name(), fault.what());
  }
}

std::optional<Quantity> read_quantity(const Settings& table, std::string_view key) {
  const auto text = table.text(key);
  if (!text) return std::nullopt;
  return placed(table, key, [&] { return parse_quantity(*text); });
}

// "0.23 ms", or a plain number in SI.
double read_in(const Settings& table, std::string_view key, std::string_view si) {
  if (!table.is_text(key)) return table.number(key).value_or(0.0);
  const auto quantity = *read_quantity(table, key);
  if (quantity.si != si)
    throw table.fault(key, "unit.kind", fmt::format("got a quantity in {}, want {}", quantity.si, si));
  return quantity.value;
}

void read_cutoffs(const Settings& table, Key key, ChannelSpec& channel) {
  const bool one = table.is_text(key);
  channel.highpass_hz = one ? std::vector{read_in(table, key, "Hz")} : table.numbers(key);
  if (one && !(channel.highpass_hz.front() > 0)) throw table.fault(key, "config.range", "want a frequency above 0 Hz");
}

// full_scale and offset are said at the plug or after calibration; nothing else can be converted. Volts without a
// sensitivity want one: whoever reads the recording says so.
void check_kind(const Settings& table, std::string_view key, const std::optional<Quantity>& quantity,
                const ChannelSpec& channel) {
  if (!quantity || (!channel.sensitivity && is_electrical(quantity->si))) return;
  const std::string measured = channel.sensitivity    ? channel.sensitivity->measured
                               : channel.unit.empty() ? quantity->si
                                                      : find_unit(channel.unit).si;
  if (quantity->si == measured || (channel.sensitivity && quantity->si == channel.sensitivity->electrical)) return;
  throw table.fault(
      key, "unit.kind",
      fmt::format("got a quantity in {}, want {}{}", quantity->si, measured,
                  channel.sensitivity ? " or " + channel.sensitivity->electrical : " (or give a sensitivity)"));
}

// "0.5 %" or a number, positive.
void read_uncertainty(const Settings& table, Key key, ChannelSpec& channel) {
  double& fraction = channel.sensitivity_uncertainty;
  fraction = table.number(key).value_or(fraction);
  if (!table.is_text(key)) return;
  const std::string text = *table.text(key);
  char* rest = nullptr;
  const double percent = std::strtod(text.c_str(), &rest);
  while (*rest == ' ') ++rest;
  if (rest == text.c_str() || std::string_view(rest) != "%" || !(percent > 0.0 && percent <= 100.0))
    throw table.fault(key, "config.range", fmt::format("got '{}', want a fraction or a text like \"0.5 %\"", text));
  fraction = 0.01 * percent;
}

// A positive number or a ratio of two.
void read_rate(const Settings& table, Key key, Sidecar& sidecar) {
  sidecar.rate_hz = table.number(key);
  if (!table.is_text(key)) return;
  const std::string text = *table.text(key);
  const auto parse = [](std::string_view part) {
    double value = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    return error == std::errc() && end == part.data() + part.size() ? value : std::nan("");
  };
  const auto slash = text.find('/');
  sidecar.rate_hz =
      slash == std::string::npos ? parse(text) : parse(text.substr(0, slash)) / parse(text.substr(slash + 1));
  if (!(*sidecar.rate_hz > 0) || !(*sidecar.rate_hz <= highest_hz))
    throw table.fault(
        key, "config.range",
        fmt::format("got '{}', want Hz as a positive number or a ratio such as \"51200/3\"", clean_name(text)));
}

void read_delay(const Settings& table, Key key, ChannelSpec& channel) {
  channel.delay_s = read_in(table, key, "s");
}

void read_notes(const Settings& table, Key key, ChannelSpec& channel) {
  channel.sensor = table.notes(key);
}

std::string roles() {
  std::string text;
  for (const SignalInfo& signal : signal_table())
    if (signal.role != Role::other) text += (text.empty() ? "" : ", ") + std::string(signal.name);
  return text;
}

void read_role(const Settings& table, Key key, ChannelSpec& channel) {
  const auto role = table.text(key);
  if (!role) return;
  try {
    channel.role = role_from_string(*role);
    channel.role_is_known = true;
  } catch (const std::invalid_argument& error) {
    throw table.fault(key, "config.range", error.what());
  }
}

void read_sensitivity(const Settings& table, Key key, ChannelSpec& channel) {
  if (const auto text = table.text(key))
    channel.sensitivity = placed(table, key, [&] { return parse_sensitivity(*text); });
}

void read_unit(const Settings& table, Key key, ChannelSpec& channel) {
  const auto text = table.text(key);
  if (!text) return;
  const Unit unit = placed(table, key, [&] { return find_unit(*text); });
  channel.unit = unit.name;
  if (channel.sensitivity && channel.sensitivity->measured != unit.si)
    throw table.fault(key, "unit.kind",
                      fmt::format("got {}, but the sensitivity measures {}", unit.name, channel.sensitivity->measured));
}

/// A quantity that goes with unit and sensitivity, whose rows are before; `refusal` of what is not positive, if any.
ChannelRow quantity(std::string key, const char* example, std::optional<Quantity> ChannelSpec::*member,
                    std::string meaning, std::string left_out, const char* refusal) {
  const auto read = [=](const Settings& table, Key name, ChannelSpec& channel) {
    auto& value = channel.*member = read_quantity(table, name);
    if (value && *refusal != 0 && !(value->value > 0)) throw table.fault(name, "calibration.value", refusal);
    check_kind(table, name, value, channel);
  };
  return ChannelRow::custom(std::move(key), {.text = true, .example = example}, std::move(meaning), "",
                            std::move(left_out), read);
}

SettingRows<ChannelSpec> channel_rows_in_order() {
  using Row = ChannelRow;
  constexpr auto positive = "want a positive quantity";
  return {
      {{.key = "channel",
        .type = {.elements = true},
        .meaning = "A channel. Without any, the file's own columns with the names and units of its header."}},
      Row::of("name", &ChannelSpec::name, {}, "Its name in terms and outputs. Names must differ.").needed(),
      Row::of("file", &ChannelSpec::file, {}, "Another file on the same clock that holds this channel.", "",
              "the recording itself"),
      Row::of("index", &ChannelSpec::index, {.range = {.from = 1, .to = 100'000}},
              "Its column or track in the file, counted from 1.", "", "found by `column` or by its name"),
      Row::of("column", &ChannelSpec::column, {}, "Its name in the file.", "", "as `name`"),
      Row::custom("role", {.text = true},
                  fmt::format("What it measures: {}. `ardent help terms` explains them.", roles()), "",
                  "\"other\": usable in terms by its name", read_role),
      Row::of("body", &ChannelSpec::body, {.range = {.from = 1, .to = 99}},
              "Where several bodies move, which of them it is of, from 1: x and body = 2 is x2 in terms. Neighbours "
              "have numbers that follow.",
              "", "by numbered names (x1, mass_2, floor 3), else there is one body"),
      Row::custom("sensitivity", {.text = true, .example = "\"100 mV/g\""},
                  "What the sensor gives per measured unit: \"100.1 mV/g\", \"250 mV/mm\".", "",
                  "the numbers are measured values already", read_sensitivity),
      Row::custom("unit", {.text = true},
                  "Unit after calibration, or of the numbers in the file where there is no sensitivity.", "",
                  "SI of the sensitivity, else as the file says", read_unit),
      quantity("full_scale", "\"10 V\"", &ChannelSpec::full_scale, "What 1.0 in a sound file stands for: \"10 V\".",
               "the numbers are volts or units", "want a positive quantity (turn a channel round with sign = -1)"),
      quantity("offset", "\"2.5 V\"", &ChannelSpec::offset,
               "Subtracted before or after calibration, according to its unit: \"0.2 mV\", \"1 mm\".", "0", ""),
      quantity("range", "\"35 mm\"", &ChannelSpec::range,
               "Largest reading of the sensor; its zero is known to 1 % of it: \"35 mm\".",
               "what the record spans, of two sensors", positive),
      quantity("drift", "\"40 um\"", &ChannelSpec::drift,
               "Standard deviation of its zero in the course of a record: \"40 um\".",
               "from the slow motion of x, of two sensors", positive),
      Row::custom("sensitivity_uncertainty",
                  {.number = true, .text = true, .range = {.from = 0, .to = 1, .above = true}},
                  "Standard deviation of the sensitivity as a fraction, or as a text \"0.5 %\". It enters the standard "
                  "deviations of coefficients.",
                  "", "0.01", read_uncertainty),
      Row::of("sign", &ChannelSpec::sign, {}, "-1 for a sensor that was mounted the other way round."),
      Row::custom("delay", {.number = true, .text = true},
                  "By how much the channel lags, in seconds or as a text \"0.23 ms\". The lag is corrected.", "s", "0",
                  read_delay),
      Row::of("coupling", &ChannelSpec::coupling, {.words = {"AC", "DC", "IEPE"}}, "Coupling of its amplifier.", "",
              "not known"),
      Row::custom("highpass", {.number = true, .text = true, .several = true, .range = {.from = 0, .above = true}},
                  "Cut-off of its AC coupling, one number for each pole, or \"0.5 Hz\".", "Hz", "none known",
                  read_cutoffs),
      Row::custom("sensor", {.table = true, .example = "{ model = \"352C33\" }"},
                  "Notes: { model = \"352C33\", serial = \"A1234\" }. Not used in computations.", "", "", read_notes)};
}

}  // namespace

const SettingRows<Sidecar>& sidecar_rows() {
  using Row = BoundSetting<Sidecar>;
  static const SettingRows<Sidecar> rows{
      Row::of("title", &Sidecar::title, {}, "Title of the recording."),
      Row::of("start", &Sidecar::start, {.date = true}, "When it began: 2023-05-04T10:12:30Z."),
      Row::choice(
          "clock", &Sidecar::clock,
          {{"regular", ClockKind::regular}, {"interpolate", ClockKind::interpolate}, {"events", ClockKind::events}},
          "\"interpolate\": a time column with uneven steps is interpolated onto `rate`, which must be given. "
          "\"events\": the same where a row was written whenever something moved, so that a long step is no "
          "gap. \"regular\": uneven steps above 10 % of a step are refused."),
      Row::of("header_row", &Sidecar::header_row, {.range = {.from = 1, .to = 1e6}},
              "Of a table: the line that holds the names, from 1.", "", "the last line of words above the rows"),
      Row::of("skip_rows", &Sidecar::skip_rows, {.range = {.from = 0, .to = 1e6}},
              "Of a table: how many lines at its beginning are not looked at.", "", "none"),
      run_row(&Sidecar::run, "asked for"),
      Row::custom("rate", {.number = true, .text = true, .range = {.from = 0, .to = highest_hz, .above = true}},
                  "Samples per second, as a number or a ratio: \"51200/3\". It must agree with the file where that has "
                  "one. A time column is read as seconds or in its unit, as 10:00:00.123 with or without a date "
                  "(2026-11-20T10:00:00.123+01:00, 20.11.2026 10:00:00,123) and as 00:12.3, minutes and seconds.",
                  "Hz", "the file's own", read_rate)};
  return rows;
}

const SettingRows<ChannelSpec>& channel_rows() {
  static const SettingRows<ChannelSpec> rows = channel_rows_in_order();
  return rows;
}

const SettingRows<RangeSpec>& range_rows() {
  using Row = BoundSetting<RangeSpec>;
  static const SettingRows<RangeSpec> rows{
      Row::of("name", &RangeSpec::name, {}, "Its name in all outputs.", "", "range1, range2, ..."),
      Row::of("from", &RangeSpec::from_s, {.range = {.from = 0}}, "Where it begins, from the start of the recording.",
              "s"),
      Row::of("to", &RangeSpec::to_s, {}, "Where it ends.", "s", "the end of the recording"),
      Row::of("train_to", &RangeSpec::train_to_s, {}, "Rows up to here are fitted, the later ones tested.", "s",
              "the first fit.train_share of its rows"),
      Row::of("where", &RangeSpec::where, {},
              "Condition on rows: \"abs(v) > 0.004 && t < 830\". It drops rows after all filtering.", "", "all rows")};
  return rows;
}

const SettingRows<Interval>& bad_rows() {
  using Row = BoundSetting<Interval>;
  static const SettingRows<Interval> rows{
      {{.key = "bad",
        .type = {.elements = true},
        .meaning = "An interval that is left out of every fit and figure, with the filters' reach on either side."}},
      Row::of("from", &Interval::from_s, {}, "Where it begins, from the start of the recording.", "s").needed(),
      Row::of("to", &Interval::to_s, {}, "Where it ends.", "s").needed(),
      Row::of("why", &Interval::why, {}, "The reason, for segments.json.", "", "\"annotated\"")};
  return rows;
}

const std::vector<Setting>& sidecar_settings() {
  static const std::vector<Setting> all = [] {
    std::vector<Setting> settings{schema_setting(sidecar_schema)};
    add_rows(settings, sidecar_rows());
    add_rows(settings, channel_rows());
    settings.push_back({.key = "range",
                        .type = {.elements = true},
                        .meaning = "A part of the recording with an equation of its own, as in a config, whose ranges "
                                   "replace these."});
    add_rows(settings, range_rows(), "range");
    add_rows(settings, bad_rows());
    return settings;
  }();
  return all;
}

}  // namespace dsp
