#include "dsp/io/channel_bodies.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include "dsp/io/settings.hpp"
#include "dsp/io/sidecar.hpp"
#include "dsp/io/units.hpp"

namespace dsp {
namespace {

/// A word of a numbered channel, how often its motion is differentiated, and whether it says that it is absolute.
struct NumberedWord {
  std::string_view text;
  int order;
  bool is_absolute = false;
};
constexpr std::array numbered_words{
    NumberedWord{"x", 0},         NumberedWord{"y", 0, true},     NumberedWord{"disp", 0},
    NumberedWord{"displ", 0},     NumberedWord{"position", 0},    NumberedWord{"pos", 0},
    NumberedWord{"mass", 0},      NumberedWord{"masse", 0},       NumberedWord{"masa", 0},
    NumberedWord{"massa", 0},     NumberedWord{"floor", 0},       NumberedWord{"storey", 0},
    NumberedWord{"story", 0},     NumberedWord{"body", 0},        NumberedWord{"dof", 0},
    NumberedWord{"weg", 0},       NumberedWord{"auslenkung", 0},  NumberedWord{"displacement", 0},
    NumberedWord{"v", 1},         NumberedWord{"vel", 1},         NumberedWord{"velocity", 1},
    NumberedWord{"dx", 1},        NumberedWord{"dy", 1, true},    NumberedWord{"a", 2},
    NumberedWord{"acc", 2},       NumberedWord{"accel", 2},       NumberedWord{"ddx", 2},
    NumberedWord{"ddy", 2, true}, NumberedWord{"acceleration", 2}};

struct Numbered {
  int number = 0, order = 0;
  bool is_absolute = false;
};

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

/// Words in lower case and whole numbers, whatever is between them.
std::vector<std::string> parts_of(std::string_view name) {
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const char c = name[i];
    const bool is_digit = c >= '0' && c <= '9';
    if (!is_letter(c) && !is_digit) continue;
    const char before = i > 0 ? name[i - 1] : ' ';
    const bool goes_on = is_digit ? before >= '0' && before <= '9' : is_letter(before);
    if (!goes_on) parts.emplace_back();
    parts.back() += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return parts;
}

std::optional<int> order_of_unit(const std::string& unit) {
  if (unit == "m" || unit == "rad") return 0;
  if (unit == "m/s" || unit == "rad/s") return 1;
  if (unit == "m/s^2" || unit == "rad/s^2") return 2;
  return std::nullopt;
}

/// Known words and one number of two digits at most.
std::optional<Numbered> numbered(const Channel& channel) {
  Numbered found{.number = -1};
  bool has_word = false;
  for (const std::string& part : parts_of(channel.name)) {
    if (part.front() >= '0' && part.front() <= '9') {
      if (found.number >= 0 || part.size() > 2) return std::nullopt;
      found.number = std::stoi(part);
      continue;
    }
    const auto* word = std::find_if(numbered_words.begin(), numbered_words.end(),
                                    [&](const NumberedWord& one) { return one.text == part; });
    if (word == numbered_words.end()) return std::nullopt;
    found.order = std::max(found.order, word->order);
    found.is_absolute = found.is_absolute || word->is_absolute;
    has_word = true;
  }
  if (found.number < 0 || !has_word) return std::nullopt;
  if (!channel.unit.empty() && !order_of_unit(channel.unit) && !is_electrical(channel.unit)) return std::nullopt;
  found.order = order_of_unit(channel.unit).value_or(found.order);
  return found;
}

/// The bodies that displacements among these are numbered by; nothing where that is not 1 to n, each once.
std::optional<int> bodies_of(const std::vector<std::optional<Numbered>>& found) {
  std::vector<int> numbers;
  for (const auto& one : found)
    if (one && one->order == 0 && one->number > 0) numbers.push_back(one->number);
  std::sort(numbers.begin(), numbers.end());
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (numbers[i] != static_cast<int>(i) + 1) return std::nullopt;
  return numbers.size() > 1 ? std::optional(static_cast<int>(numbers.size())) : std::nullopt;
}

}  // namespace

std::vector<Check> assume_bodies(std::vector<Channel>& channels, std::vector<bool>& is_known) {
  std::vector<std::optional<Numbered>> found(channels.size());
  for (std::size_t i = 0; i < channels.size(); ++i)
    if (!is_known[i] && channels[i].body == 0) found[i] = numbered(channels[i]);
  const std::optional<int> bodies = bodies_of(found);
  std::vector<Check> checks;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    Channel& channel = channels[i];
    const bool is_stated = !is_known[i] && channel.body > 0;
    if (!is_stated && (!bodies || !found[i] || found[i]->number > *bodies)) continue;
    const Numbered one = is_stated ? Numbered{channel.body, order_of_unit(channel.unit).value_or(0)} : *found[i];
    if (one.number == 0 && one.order > 0) continue;
    channel.role = motion_signal(one.number == 0   ? Body::base
                                 : one.is_absolute ? Body::payload
                                                   : Body::relative,
                                 one.order)
                       .role;
    channel.body = one.number;
    channel.role_is_assumed = !one.is_absolute;
    is_known[i] = true;
    std::string message = one.number == 0 ? "taken for the displacement of the base (r), by its number"
                                          : fmt::format("taken for {} of body {}, by its {}", to_string(channel.role),
                                                        one.number, is_stated ? "key `body`" : "name");
    if (channel.unit.empty() && channel.calibrated) {
      channel.unit = si_unit(channel.role);
      channel.unit_is_assumed = true;
      message += fmt::format("; no unit is given, taken as {}", channel.unit);
    }
    checks.push_back({"channel.role", channel.name, CheckStatus::note, 0.0, 0.0, std::move(message)});
  }
  return checks;
}

std::optional<Fault> bodies_question(const std::string& recording, const std::vector<Channel>& channels) {
  std::vector<std::string> names;
  std::string lines;
  for (const Channel& channel : channels) {
    const auto one = numbered(channel);
    if (channel.role != Role::other || channel.body > 0 || !one || one->order > 0) continue;
    names.push_back(channel.name);
    lines += fmt::format("[[channel]]\nname = {}\nrole = \"x\"\nbody = {}\n{}", toml_quoted(channel.name), names.size(),
                         channel.unit.empty() ? "unit = \"m\"  # or what its numbers are in\n" : "");
  }
  if (names.size() < 2) return std::nullopt;
  return Fault(FaultKind::input, "channel.body",
               fmt::format("{}: displacements {} are numbered, but not from 1 on, each number once. Which body is each "
                           "of? Say it in {}, role = \"y\" where they are absolute and the base moves:",
                           recording, fmt::join(names, ", "), sidecar_path(recording).string()),
               std::move(lines));
}

bool has_bodies(const Recording& recording) {
  return std::any_of(recording.channels.begin(), recording.channels.end(),
                     [](const Channel& channel) { return channel.body > 0; });
}

void require_one_body(const Recording& recording) {
  if (!has_bodies(recording)) return;
  throw Fault(FaultKind::input, "recording.bodies",
              fmt::format("{0}: channels of several bodies, want one. Try ardent run {0}, or a sidecar that leaves the "
                          "channels of the other bodies out",
                          recording.name));
}

}  // namespace dsp
