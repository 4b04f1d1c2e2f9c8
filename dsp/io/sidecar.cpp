#include "dsp/io/sidecar.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <map>
#include <tuple>
#include <unordered_map>

#include "dsp/names.hpp"

namespace dsp {
namespace {

// Runs `parse` and puts the key's place before the message of whatever it throws.
template <typename Parse>
auto placed(const Settings& table, std::string_view key, Parse parse) {
  try {
    return parse();
  } catch (const Fault& fault) {
    throw table.fault(key, fault.name(), fault.what());
  }
}

std::optional<Quantity> read_quantity(const Settings& table, std::string_view key, std::string_view example = {}) {
  const auto text = table.find_text(key, example);
  if (!text) return std::nullopt;
  return placed(table, key, [&] { return parse_quantity(*text); });
}

// "0.23 ms", or a plain number in SI.
double read_in(const Settings& table, std::string_view key, std::string_view si, double fallback) {
  if (!table.is_text(key)) return table.number(key, fallback);
  const auto quantity = *read_quantity(table, key);
  if (quantity.si != si)
    throw table.fault(key, "unit.kind", fmt::format("got a quantity in {}, want {}", quantity.si, si));
  return quantity.value;
}

std::vector<double> read_cutoffs(const Settings& channel) {
  if (!channel.is_text("highpass")) return channel.numbers("highpass", {.from = 0, .above = true});
  const double cutoff_hz = read_in(channel, "highpass", "Hz", 0);
  if (!(cutoff_hz > 0)) throw channel.fault("highpass", "config.range", "want a frequency above 0 Hz");
  return {cutoff_hz};
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
double read_fraction(const Settings& table, std::string_view key, double fallback) {
  constexpr NumberRange fraction{.from = 0, .to = 1, .above = true};
  if (!table.is_text(key)) return table.number(key, fallback, fraction);
  const std::string text = table.text(key, "");
  char* rest = nullptr;
  const double percent = std::strtod(text.c_str(), &rest);
  while (*rest == ' ') ++rest;
  if (rest == text.c_str() || std::string_view(rest) != "%" || !(percent > 0.0 && percent <= 100.0))
    throw table.fault(key, "config.range", fmt::format("got '{}', want a fraction or a text like \"0.5 %\"", text));
  return 0.01 * percent;
}

void read_calibration(const Settings& table, ChannelSpec& channel) {
  table.attempt([&] {
    if (const auto text = table.find_text("sensitivity", "100 mV/g"))
      channel.sensitivity = placed(table, "sensitivity", [&] { return parse_sensitivity(*text); });
  });
  table.attempt([&] {
    const auto text = table.find_text("unit");
    if (!text) return;
    const auto unit = placed(table, "unit", [&] { return find_unit(*text); });
    channel.unit = unit.name;
    if (channel.sensitivity && channel.sensitivity->measured != unit.si)
      throw table.fault(
          "unit", "unit.kind",
          fmt::format("got {}, but the sensitivity measures {}", unit.name, channel.sensitivity->measured));
  });
  for (const auto& [key, example, value, positive] :
       {std::tuple{"full_scale", "10 V", &channel.full_scale,
                   "want a positive quantity (turn a channel round with sign = -1)"},
        std::tuple{"offset", "2.5 V", &channel.offset, ""},
        std::tuple{"range", "35 mm", &channel.range, "want a positive quantity"},
        std::tuple{"drift", "40 um", &channel.drift, "want a positive quantity"}})
    table.attempt([&, key = key, example = example, value = value, positive = positive] {
      *value = read_quantity(table, key, example);
      if (*value && *positive != 0 && !((*value)->value > 0)) throw table.fault(key, "calibration.value", positive);
      check_kind(table, key, *value, channel);
    });
  table.attempt([&] {
    channel.sensitivity_uncertainty = read_fraction(table, "sensitivity_uncertainty", channel.sensitivity_uncertainty);
  });
  channel.sign = table.number("sign", 1.0);
  if (std::abs(channel.sign) != 1.0)
    table.attempt(
        [&] { throw table.fault("sign", "config.range", fmt::format("got {}, want 1 or -1", channel.sign)); });
}

void check_role(const Settings& table, const ChannelSpec& channel) {
  const std::string si = channel.sensitivity     ? channel.sensitivity->measured
                         : !channel.unit.empty() ? find_unit(channel.unit).si
                                                 : si_unit(channel.role);
  if (!fits(channel.role, si))
    throw table.fault("role", "unit.role",
                      fmt::format("role {} is measured in {}, but this channel's unit is {}, which fits role {}. "
                                  "Correct the one that is wrong",
                                  to_string(channel.role), si_unit(channel.role), si, roles_in(si)));
}

ChannelSpec read_channel(const Settings& table) {
  ChannelSpec channel;
  channel.place = table.place();
  channel.name = clean_name(table.need_text("name"));
  if (channel.name.empty()) throw table.fault("name", "config.range", "want a name that is not blank");
  channel.file = table.text("file", "");
  table.exclusive("index", "column");
  constexpr double most_columns = 100'000;
  channel.index = static_cast<int>(table.integer("index", 0, {.from = 1, .to = most_columns}));
  channel.column = clean_name(table.text("column", ""));
  table.attempt([&] {
    const auto role = table.find_text("role");
    if (!role) return;
    try {
      channel.role = role_from_string(*role);
      channel.role_is_known = true;
    } catch (const std::invalid_argument& error) {
      throw table.fault("role", "config.range", error.what());
    }
  });
  read_calibration(table, channel);
  table.attempt([&] { check_role(table, channel); });
  table.attempt([&] { channel.delay_s = read_in(table, "delay", "s", 0.0); });
  channel.coupling = table.has("coupling") ? table.choice("coupling", "", {"AC", "DC", "IEPE"}) : "";
  table.attempt([&] { channel.highpass_hz = read_cutoffs(table); });
  channel.sensor = table.notes("sensor");
  return channel;
}

void check_distinct(const std::vector<ChannelSpec>& channels) {
  std::unordered_map<std::string_view, std::string_view> places;
  for (const auto& channel : channels)
    if (const auto [other, is_new] = places.emplace(channel.name, channel.place); !is_new)
      throw Fault(FaultKind::usage, "channel.name",
                  fmt::format("{}: channel '{}' has been described already ({}); names must differ", channel.place,
                              channel.name, other->second));
}

std::vector<Interval> read_bad(const Settings& document) {
  std::vector<Interval> bad;
  for (const auto& table : document.tables("bad")) {
    const double from_s = table.need_number("from"), to_s = table.need_number("to");
    if (!(from_s < to_s))
      throw table.fault("to", "config.range", fmt::format("got from = {}, to = {}: want from below to", from_s, to_s));
    bad.push_back({from_s, to_s, clean_name(table.text("why", "annotated"))});
  }
  return bad;
}

void read_clock(const Settings& document, Sidecar& sidecar) {
  sidecar.interpolate = document.choice("clock", "regular", {"regular", "interpolate"}) == "interpolate";
  sidecar.rate_hz = read_rate(document, "rate");
  if (sidecar.interpolate && !document.has("rate"))
    throw document.fault("clock", "config.missing",
                         "interpolate needs a rate to interpolate onto, for example rate = 100");
}

Sidecar read_document(const Settings& document) {
  document.check_schema(1);
  Sidecar sidecar;
  sidecar.title = clean_name(document.text("title", ""));
  document.attempt([&] { sidecar.start = clean_name(document.moment("start")); });
  document.attempt([&] { read_clock(document, sidecar); });
  for (const auto& table : document.tables("channel"))
    document.attempt([&] { sidecar.channels.push_back(read_channel(table)); });
  document.attempt([&] { check_distinct(sidecar.channels); });
  document.attempt([&] { sidecar.ranges = read_ranges(document); });
  document.attempt([&] { sidecar.bad = read_bad(document); });
  document.finish(sidecar_settings);
  return sidecar;
}

}  // namespace

std::vector<AskedSetting> sidecar_settings() {
  std::vector<AskedSetting> all;
  // What may be written as a number and as a text is written both ways.
  for (const char* text :
       {"rate = 1\n[[channel]]\nname = \"x\"\ncoupling = \"AC\"\n[[range]]\n[[bad]]\nfrom = 0\nto = 1\n",
        "rate = \"1\"\n[[channel]]\nname = \"x\"\ndelay = \"1 s\"\nhighpass = \"1 Hz\"\n"
        "sensitivity_uncertainty = \"1 %\"\n"}) {
    const Settings document = Settings::from_text(text, "");
    (void)read_document(document);
    add_asked(all, document.asked());
  }
  return all;
}

std::filesystem::path sidecar_path(const std::filesystem::path& recording) {
  auto path = recording;
  path += ".toml";
  return path;
}

std::optional<double> read_rate(const Settings& table, std::string_view key) {
  constexpr double highest_hz = 1e9;
  if (!table.is_text(key)) return table.find_number(key, {.from = 0, .to = highest_hz, .above = true});
  const std::string text = *table.find_text(key);
  const auto parse = [](std::string_view part) {
    double value = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    return error == std::errc() && end == part.data() + part.size() ? value : std::nan("");
  };
  const auto slash = text.find('/');
  const double rate_hz = slash == std::string::npos ? parse(text)
                                                    : parse(std::string_view(text).substr(0, slash)) /
                                                          parse(std::string_view(text).substr(slash + 1));
  if (!(rate_hz > 0) || !(rate_hz <= highest_hz))
    throw table.fault(
        key, "config.range",
        fmt::format("got '{}', want Hz as a positive number or a ratio such as \"51200/3\"", clean_name(text)));
  return rate_hz;
}

std::vector<RangeSpec> read_ranges(const Settings& document) {
  std::vector<RangeSpec> ranges;
  std::map<std::string, std::string> places;  // of the names
  for (const auto& table : document.tables("range")) {
    RangeSpec range;
    range.place = table.place();
    range.name = clean_name(table.text("name", fmt::format("range{}", ranges.size() + 1)));
    range.from_s = table.number("from", 0.0, {.from = 0});
    range.to_s = table.number("to", std::numeric_limits<double>::infinity());
    range.train_to_s = table.find_number("train_to");
    range.where = table.text("where", "");
    if (!(range.from_s < range.to_s))
      throw table.fault("to", "config.range",
                        fmt::format("got from = {}, to = {}: want from below to", range.from_s, range.to_s));
    if (range.train_to_s && !(*range.train_to_s > range.from_s && *range.train_to_s <= range.to_s))
      throw table.fault(
          "train_to", "config.range",
          fmt::format("got {}, want above {} and at most {}", *range.train_to_s, range.from_s, range.to_s));
    if (const auto [found, added] = places.try_emplace(range.name, range.place); !added)
      throw table.fault("name", "config.range",
                        fmt::format("range '{}' exists already ({})", range.name, found->second));
    ranges.push_back(std::move(range));
  }
  return ranges;
}

Sidecar read_sidecar(const std::filesystem::path& file) {
  auto sidecar = read_document(Settings::from_file(file));
  sidecar.file = file;
  return sidecar;
}

Sidecar parse_sidecar(std::string_view text, const std::string& name) {
  return read_document(Settings::from_text(text, name));
}

}  // namespace dsp
