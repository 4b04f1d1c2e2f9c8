#include "dsp/io/sidecar.hpp"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <unordered_map>

#include "dsp/io/sidecar_rows.hpp"
#include "dsp/values/names.hpp"

namespace dsp {
namespace {

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
  read_rows(channel_rows(), table, channel);
  channel.name = clean_name(channel.name);
  channel.column = clean_name(channel.column);
  if (channel.name.empty()) throw table.fault("name", "config.range", "want a name that is not blank");
  table.exclusive("index", "column");
  if (std::abs(channel.sign) != 1.0)
    throw table.fault("sign", "config.range", fmt::format("got {}, want 1 or -1", channel.sign));
  check_role(table, channel);
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
  for (const Settings& table : document.tables("bad")) {
    Interval& interval = bad.emplace_back(Interval{.why = "annotated"});
    read_rows(bad_rows(), table, interval);
    interval.why = clean_name(interval.why);
    if (!(interval.from_s < interval.to_s))
      throw table.fault("to", "config.range",
                        fmt::format("got from = {}, to = {}: want from below to", interval.from_s, interval.to_s));
  }
  return bad;
}

Sidecar read_document(const Settings& document) {
  document.check(sidecar_settings(), sidecar_schema);
  Sidecar sidecar;
  read_rows(sidecar_rows(), document, sidecar);
  sidecar.title = clean_name(sidecar.title);
  sidecar.start = clean_name(sidecar.start);
  document.attempt([&] {
    if (sidecar.clock != ClockKind::regular && !document.has("rate"))
      throw document.fault("clock", "config.missing",
                           "interpolate and events need a rate to interpolate onto, for example rate = 100");
  });
  for (const auto& table : document.tables("channel"))
    document.attempt([&] { sidecar.channels.push_back(read_channel(table)); });
  document.attempt([&] { check_distinct(sidecar.channels); });
  document.attempt([&] { sidecar.ranges = read_ranges(document); });
  document.attempt([&] { sidecar.bad = read_bad(document); });
  document.finish();
  return sidecar;
}

}  // namespace

std::filesystem::path sidecar_path(const std::filesystem::path& recording) {
  auto path = recording.string().starts_with("/dev/") ? recording.filename() : recording;
  path += ".toml";
  return path;
}

std::vector<RangeSpec> read_ranges(const Settings& document) {
  std::vector<RangeSpec> ranges;
  std::map<std::string, std::string> places;  // of the names
  for (const Settings& table : document.tables("range")) {
    RangeSpec range;
    range.place = table.place();
    read_rows(range_rows(), table, range);
    range.name = range.name.empty() ? fmt::format("range{}", ranges.size() + 1) : clean_name(range.name);
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
