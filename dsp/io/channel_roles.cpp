#include "dsp/io/channel_roles.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "dsp/filter/strongest_line.hpp"
#include "dsp/io/settings.hpp"
#include "dsp/io/units.hpp"
#include "dsp/samples/sample_checks.hpp"

namespace dsp {
namespace {

enum class Kind { displacement, velocity, acceleration, force, input };

/// A word of a name, or how a longer one begins.
struct Word {
  std::string_view text;
  std::optional<Body> body;
  std::optional<Kind> quantity;
  bool is_beginning = false, is_angular = false;
};

constexpr auto none = std::nullopt;

// Without accents and capitals.
constexpr std::array role_words{
    Word{"base", Body::base, none},
    Word{"ground", Body::base, none},
    Word{"floor", Body::base, none},
    Word{"table", Body::base, none},
    Word{"shaker", Body::base, none},
    Word{"support", Body::base, none},
    Word{"foundation", Body::base, none},
    Word{"bottom", Body::base, none},
    Word{"fuss", Body::base, none, true},
    Word{"erreger", Body::base, none},
    Word{"exciter", Body::base, none},
    Word{"plattform", Body::base, none},
    Word{"platform", Body::base, none},
    Word{"embase", Body::base, none},
    Word{"plateau", Body::base, none},
    Word{"vibrador", Body::base, none},
    Word{"plataforma", Body::base, none},
    Word{"fundament", Body::base, none, true},
    Word{"tisch", Body::base, none, true},
    Word{"boden", Body::base, none},
    Word{"unten", Body::base, none},
    Word{"socle", Body::base, none},
    Word{"sol", Body::base, none},
    Word{"bati", Body::base, none},
    Word{"suelo", Body::base, none},
    Word{"mesa", Body::base, none},
    Word{"bancada", Body::base, none},
    Word{"solo", Body::base, none},
    Word{"payload", Body::payload, none},
    Word{"mass", Body::payload, none},
    Word{"masse", Body::payload, none},
    Word{"masa", Body::payload, none},
    Word{"massa", Body::payload, none},
    Word{"top", Body::payload, none},
    Word{"tip", Body::payload, none},
    Word{"arm", Body::payload, none},
    Word{"beam", Body::payload, none},
    Word{"bras", Body::payload, none},
    Word{"brazo", Body::payload, none},
    Word{"braco", Body::payload, none},
    Word{"oben", Body::payload, none},
    Word{"nutzlast", Body::payload, none},
    Word{"haut", Body::payload, none},
    Word{"charge", Body::payload, none},
    Word{"carga", Body::payload, none},
    Word{"rel", Body::relative, none},
    Word{"relativ", Body::relative, none, true},
    Word{"disp", none, Kind::displacement},
    Word{"displ", none, Kind::displacement},
    Word{"displacement", none, Kind::displacement, true},
    Word{"pos", none, Kind::displacement},
    Word{"position", none, Kind::displacement},
    Word{"laser", none, Kind::displacement},
    Word{"encoder", none, Kind::displacement},
    Word{"lvdt", none, Kind::displacement},
    Word{"angle", none, Kind::displacement, false, true},
    Word{"theta", none, Kind::displacement, false, true},
    Word{"phi", none, Kind::displacement, false, true},
    Word{"deflection", none, Kind::displacement},
    Word{"distance", none, Kind::displacement},
    Word{"abstand", none, Kind::displacement},
    Word{"distancia", none, Kind::displacement},
    Word{"weg", none, Kind::displacement},
    Word{"winkel", none, Kind::displacement, false, true},
    Word{"drehwinkel", none, Kind::displacement, false, true},
    Word{"angulo", none, Kind::displacement, false, true},
    Word{"rotation", none, Kind::displacement, false, true},
    Word{"auslenkung", none, Kind::displacement},
    Word{"verschieb", none, Kind::displacement, true},
    Word{"deplacement", none, Kind::displacement},
    Word{"desplaz", none, Kind::displacement, true},
    Word{"desloc", none, Kind::displacement, true},
    Word{"posicion", none, Kind::displacement},
    Word{"posicao", none, Kind::displacement},
    Word{"vel", none, Kind::velocity},
    Word{"veloc", none, Kind::velocity, true},
    Word{"speed", none, Kind::velocity},
    Word{"ldv", none, Kind::velocity},
    Word{"vibrometer", none, Kind::velocity},
    Word{"omega", none, Kind::velocity, false, true},
    Word{"gyro", none, Kind::velocity, true, true},
    Word{"winkelgeschwind", none, Kind::velocity, true, true},
    Word{"alpha", none, Kind::acceleration, false, true},
    Word{"winkelbeschl", none, Kind::acceleration, true, true},
    Word{"geschwind", none, Kind::velocity, true},
    Word{"vitesse", none, Kind::velocity},
    Word{"acc", none, Kind::acceleration},
    Word{"accel", none, Kind::acceleration, true},
    Word{"ax", none, Kind::acceleration},
    Word{"ay", none, Kind::acceleration},
    Word{"az", none, Kind::acceleration},
    Word{"beschl", none, Kind::acceleration, true},
    Word{"acel", none, Kind::acceleration, true},
    Word{"force", none, Kind::force},
    Word{"load", none, Kind::force},
    Word{"loadcell", none, Kind::force},
    Word{"torque", none, Kind::force},
    Word{"kraft", none, Kind::force},
    Word{"moment", none, Kind::force},
    Word{"drehmoment", none, Kind::force},
    Word{"effort", none, Kind::force},
    Word{"couple", none, Kind::force},
    Word{"fuerza", none, Kind::force},
    Word{"forca", none, Kind::force},
    Word{"input", none, Kind::input},
    Word{"excit", none, Kind::input, true},
    Word{"command", none, Kind::input},
    Word{"drive", none, Kind::input},
    Word{"antrieb", none, Kind::input},
    Word{"voltage", none, Kind::input},
    Word{"current", none, Kind::input},
    Word{"pressure", none, Kind::input},
    Word{"anregung", none, Kind::input},
    Word{"spannung", none, Kind::input},
    Word{"strom", none, Kind::input},
    Word{"druck", none, Kind::input},
    Word{"entree", none, Kind::input},
    Word{"tension", none, Kind::input},
    Word{"pression", none, Kind::input},
    Word{"entrada", none, Kind::input},
    Word{"voltaje", none, Kind::input},
    Word{"tensao", none, Kind::input},
    Word{"presion", none, Kind::input},
    Word{"pressao", none, Kind::input},
};

/// Letters of Latin-1 without their accents, ss for a sharp s; anything else beyond ASCII parts words.
std::string_view plain(unsigned char second_byte) {
  constexpr std::string_view from_a0 = "aaaaaaaceeeeiiiidnooooo ouuuuypy";
  if (second_byte == 0x9f) return "ss";
  const unsigned char lower = second_byte < 0xa0 ? second_byte + 0x20 : second_byte;
  return lower < 0xa0 || lower > 0xbf ? std::string_view(" ") : from_a0.substr(lower - 0xa0u, 1);
}

/// "payloadAcc_1" is "payload", "acc".
std::vector<std::string> words_of(std::string_view name) {
  std::vector<std::string> result{""};
  bool was_lower = false;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const char c = name[i];
    const bool upper = c >= 'A' && c <= 'Z', lower = c >= 'a' && c <= 'z';
    if (upper && was_lower) result.emplace_back();
    if (upper || lower)
      result.back() += upper ? static_cast<char>(c - 'A' + 'a') : c;
    else if (c == '\xc3' && i + 1 < name.size() && plain(static_cast<unsigned char>(name[i + 1])) != " ")
      result.back() += plain(static_cast<unsigned char>(name[++i]));
    else
      result.emplace_back();
    was_lower = lower || c == '\xc3';
  }
  std::erase(result, "");
  return result;
}

const Word* find_word(std::string_view text) {
  const auto* found = std::find_if(role_words.begin(), role_words.end(), [&](const Word& word) {
    return word.is_beginning ? text.starts_with(word.text) : text == word.text;
  });
  return found == role_words.end() ? nullptr : found;
}

template <class Test>
bool any_word(std::string_view name, Test&& test) {
  const std::vector<std::string> texts = words_of(name);
  return std::any_of(texts.begin(), texts.end(), [&](const std::string& text) {
    const Word* word = find_word(text);
    return word != nullptr && test(*word);
  });
}

std::optional<Kind> quantity_in(std::string_view si) {
  static const std::map<std::string_view, Kind> known{{"m", Kind::displacement},
                                                      {"rad", Kind::displacement},
                                                      {"m/s", Kind::velocity},
                                                      {"rad/s", Kind::velocity},
                                                      {"m/s^2", Kind::acceleration},
                                                      {"rad/s^2", Kind::acceleration},
                                                      {"N", Kind::force},
                                                      {"N*m", Kind::force},
                                                      {"Pa", Kind::input},
                                                      {"V", Kind::input},
                                                      {"A", Kind::input}};
  const auto found = known.find(si);
  return found == known.end() ? std::nullopt : std::optional(found->second);
}

/// What a channel measures and of which body.
struct Reading {
  std::optional<Body> body;
  std::optional<Kind> quantity;
  bool by_name = false, by_unit = false;
  [[nodiscard]] bool is_motion() const { return quantity && *quantity <= Kind::acceleration; }
};

Reading reading_of(const UnnamedRole& channel) {
  Reading reading;
  std::optional<Kind> named;
  const std::vector<std::string> texts = words_of(channel.name);
  if (texts.size() == 1 && texts.front() == "f") named = Kind::force;
  if (texts.size() == 1 && texts.front() == "u") named = Kind::input;
  for (const std::string& text : texts)
    if (const Word* word = find_word(text)) {
      if (word->body && !reading.body) reading.body = word->body;
      // What moves outranks what drives: load_pos, drive_acceleration.
      if (word->quantity && (!named || (*named > Kind::acceleration && *word->quantity <= Kind::acceleration)))
        named = word->quantity;
    }
  reading.quantity = quantity_in(channel.unit);
  // A sensor's volts are those of what its name says.
  if (named && (!reading.quantity || *reading.quantity == Kind::input)) reading.quantity = named;
  reading.by_unit = reading.quantity && reading.quantity == quantity_in(channel.unit);
  reading.by_name = named || (reading.body && reading.is_motion());
  return reading;
}

/// The only channel of a quantity, or -1.
std::ptrdiff_t only(const std::vector<Reading>& readings, Kind quantity) {
  std::ptrdiff_t found = -1;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    if (readings[i].quantity != quantity) continue;
    if (found >= 0) return -1;
    found = static_cast<std::ptrdiff_t>(i);
  }
  return found;
}

std::string in_words(const std::vector<Channel>& channels, const std::vector<ChannelLook>& looks) {
  std::vector<std::string> found;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const Channel& channel = channels[i];
    std::string text = fmt::format("{} ({}", channel.name, to_string(channel.role));
    if (i < looks.size())
      text += fmt::format(", {:.4g} to {:.4g} {}, most of it at {:.3g} Hz", looks[i].least, looks[i].most,
                          channel.unit.empty() ? "without a unit" : channel.unit, looks[i].peak_hz);
    found.push_back(text + ")");
  }
  return found.empty() ? "no channels" : fmt::format("{}", fmt::join(found, ", "));
}

/// The line that says a unit where the means of the channels without one make gravity together; else empty.
std::string line_by_gravity(const std::vector<Channel>& channels, const std::vector<ChannelLook>& looks) {
  double square = 0.0;
  for (std::size_t i = 0; i < looks.size(); ++i)
    if (channels[i].unit.empty()) square += looks[i].mean * looks[i].mean;
  return line_of_gravity(std::sqrt(square));
}

/// The only unit for a role among texts that a file has beside its numbers, "displacement units ('in')"; else empty.
std::string stated_unit(const std::vector<Check>& checks, Role role) {
  std::set<std::string> found;
  for (const Check& check : checks) {
    if (!check.name.ends_with(".left_out")) continue;
    const std::string& text = check.message;
    for (auto at = text.find("('"); at != text.npos; at = text.find("('", at + 2)) {
      const std::string unit = text.substr(at + 2, text.find("')", at) - at - 2);
      if (is_unit(unit) && find_unit(unit).si == si_unit(role)) found.insert(unit);
    }
  }
  return found.size() == 1 ? *found.begin() : "";
}

std::string unit_line(Role role, const std::vector<Check>& checks, bool is_derivative = false) {
  std::string unit = stated_unit(checks, role);
  const int order = info_of(role).order;
  if (unit.empty() && is_derivative)  // of the displacement
    unit = stated_unit(checks, Role::x) + (order == 1 ? "/s" : "/s^2");
  const bool is_stated = is_unit(unit);
  return fmt::format("unit = \"{}\"  # {}\n", is_stated ? unit : si_unit(role),
                     is_stated ? "as the file says beside it" : "or what its numbers are in");
}

/// The channel that moves most and what it would be, as lines of its [[channel]]; -1 without looks.
struct Proposal {
  std::ptrdiff_t channel = -1;
  std::string lines;
};
Proposal proposal_by_looks(const std::vector<Channel>& channels, const std::vector<ChannelLook>& looks,
                           const std::vector<Check>& checks) {
  Proposal proposal;
  double widest = 0.0;
  for (std::size_t i = 0; i < looks.size(); ++i) {
    auto quantity = quantity_in(channels[i].unit);
    const auto named = reading_of({channels[i].name, ""}).quantity;  // its unit may be none that is known
    if (!quantity && named && *named != Kind::input) quantity = named;
    const double span = looks[i].most - looks[i].least;
    if (info_of(channels[i].role).order >= 0 || quantity == Kind::force || !(span > widest)) continue;
    widest = span;
    proposal.channel = static_cast<std::ptrdiff_t>(i);
    std::string gravity = line_by_gravity(channels, looks);
    // Counts about the middle of a converter's range look like gravity's where no name says that they are.
    if (named != Kind::acceleration && !gravity.starts_with("unit = \"g") && !gravity.starts_with("unit = \"m/"))
      gravity.clear();
    const Role role = quantity == Kind::input ? Role::x  // a sensor's volts
                      : quantity              ? motion_signal(Body::relative, static_cast<int>(*quantity)).role
                      : gravity.empty()       ? Role::x
                                              : Role::a;
    proposal.lines = fmt::format("role = \"{}\"  # it moves most\n", to_string(role));
    if (channels[i].unit.empty())
      proposal.lines +=
          role == Role::a && !gravity.empty() ? gravity + "  # the means are gravity\n" : unit_line(role, checks);
  }
  return proposal;
}

/// The roles that channels have, and x, v, a along the only chain of derivatives that begins with none of them.
std::vector<RoleGuess> along_derivatives(const std::vector<Channel>& channels,
                                         const std::vector<FoundDerivative>& derivatives) {
  std::vector<RoleGuess> roles;
  for (const Channel& channel : channels) roles.push_back({channel.role, ""});
  const auto is_derived = [&](Eigen::Index column) {
    return std::any_of(derivatives.begin(), derivatives.end(), [&](const auto& pair) { return pair.is == column; });
  };
  std::vector<Eigen::Index> beginnings;
  for (const FoundDerivative& pair : derivatives)
    if (!is_derived(pair.of) && std::find(beginnings.begin(), beginnings.end(), pair.of) == beginnings.end())
      beginnings.push_back(pair.of);
  if (beginnings.size() != 1) return roles;
  Eigen::Index at = beginnings.front();
  roles[static_cast<std::size_t>(at)].role = Role::x;
  for (const Role role : {Role::v, Role::a}) {
    const auto next =
        std::find_if(derivatives.begin(), derivatives.end(), [&](const auto& pair) { return pair.of == at; });
    if (next == derivatives.end()) break;
    roles[static_cast<std::size_t>(next->is)] = {role, "derivative of " + channels[static_cast<std::size_t>(at)].name};
    at = next->is;
  }
  return roles;
}

}  // namespace

std::vector<RoleGuess> guess_roles(const std::vector<UnnamedRole>& channels, const std::vector<Role>& given) {
  std::vector<Reading> readings;
  for (const UnnamedRole& channel : channels) readings.push_back(reading_of(channel));
  const bool has_base =
      std::any_of(readings.begin(), readings.end(),
                  [](const Reading& r) { return r.is_motion() && r.body == Body::base; }) ||
      std::any_of(given.begin(), given.end(), [](Role role) { return info_of(role).body == Body::base; });
  std::vector<RoleGuess> guesses(channels.size());
  std::ptrdiff_t input = only(readings, Kind::force);
  if (input < 0 &&
      std::none_of(readings.begin(), readings.end(), [](const Reading& r) { return r.quantity == Kind::force; }))
    input = only(readings, Kind::input);
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const Reading& reading = readings[i];
    if (reading.is_motion())
      guesses[i].role = motion_signal(reading.body.value_or(has_base ? Body::payload : Body::relative),
                                      static_cast<int>(*reading.quantity))
                            .role;
    else if (static_cast<std::ptrdiff_t>(i) == input)
      guesses[i].role = Role::f;
  }
  std::map<Role, int> players;
  for (const Role role : given) ++players[role];
  for (const RoleGuess& guess : guesses) ++players[guess.role];
  for (std::size_t i = 0; i < guesses.size(); ++i) {
    if (guesses[i].role == Role::other) continue;
    if (players[guesses[i].role] > 1)
      guesses[i].role = Role::other;
    else
      guesses[i].why = !readings[i].by_name ? "its unit" : readings[i].by_unit ? "its name and unit" : "its name";
  }
  return guesses;
}

std::vector<Check> assume_roles(std::vector<Channel>& channels, const std::vector<bool>& is_known,
                                const std::map<std::string, std::string>& use) {
  std::vector<Check> checks;
  std::vector<UnnamedRole> open;
  std::vector<std::size_t> places;
  std::vector<Role> given;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const auto used =
        std::find_if(use.begin(), use.end(), [&](const auto& pair) { return pair.second == channels[i].name; });
    if (is_known[i] || used != use.end()) {
      const SignalInfo* role = used == use.end() ? nullptr : find_signal(used->first);
      given.push_back(role == nullptr ? channels[i].role : role->role);
      continue;
    }
    // A unit in brackets that is not known: what it measures is not either.
    if (channels[i].unit.empty() && channels[i].name.find_first_of("[(") != std::string::npos) {
      checks.push_back(
          {"unit.unknown", channels[i].name, CheckStatus::warning, 0.0, 0.0,
           "its unit is not known, so it is not used. Give its role and unit in a [[channel]] of the sidecar"});
      continue;
    }
    open.push_back({channels[i].name, channels[i].unit});
    places.push_back(i);
  }
  const std::vector<RoleGuess> guesses = guess_roles(open, given);
  for (std::size_t k = 0; k < open.size(); ++k) {
    if (guesses[k].role == Role::other) continue;
    Channel& channel = channels[places[k]];
    channel.role = guesses[k].role;
    std::string message =
        fmt::format("taken for {} ({}), by {}", to_string(channel.role), in_words(channel.role), guesses[k].why);
    if (channel.unit.empty() && channel.calibrated && info_of(channel.role).order >= 0) {
      channel.unit = si_unit(channel.role);
      if (any_word(channel.name, [](const Word& word) { return word.is_angular; }))
        channel.unit.replace(0, 1, "rad");  // of m, m/s, m/s^2
      channel.unit_is_assumed = true;
      message += fmt::format("; no unit is given, taken as {}", channel.unit);
    }
    if (is_electrical(channel.unit) && info_of(channel.role).order >= 0)
      message += fmt::format("; it stays in {}, as recorded, until its [[channel]] has a sensitivity", channel.unit);
    checks.push_back({"channel.role", channel.name, CheckStatus::note, 0.0, 0.0, std::move(message)});
  }
  return checks;
}

std::string in_words(const std::vector<Channel>& channels) {
  return in_words(channels, {});
}

std::vector<ChannelLook> look_at(const Eigen::MatrixXd& samples, double sample_rate_hz) {
  std::vector<ChannelLook> looks;
  for (Eigen::Index c = 0; c < samples.cols() && samples.rows() > 1; ++c)
    looks.push_back({samples.col(c).minCoeff(), samples.col(c).maxCoeff(), samples.col(c).mean(),
                     strongest_line(samples.col(c), sample_rate_hz).frequency_hz});
  return looks;
}

void leave_axes_open(std::vector<ChannelSpec>& channels, const SourceInfo& info) {
  std::vector<ChannelSpec*> axes;
  std::set<std::string> units;
  for (ChannelSpec& channel : channels) {
    if (!channel.role_is_known) continue;
    if (channel.role != Role::x && channel.role != Role::y && channel.role != Role::z) return;
    axes.push_back(&channel);
    units.insert(info.units[static_cast<std::size_t>(channel.index - 1)]);
  }
  if (axes.size() < 2 || units.size() > 1) return;
  for (ChannelSpec* channel : axes) channel->role = Role::other, channel->role_is_known = false;
}

bool any_motion(const std::vector<Channel>& channels) {
  return std::any_of(channels.begin(), channels.end(),
                     [](const Channel& channel) { return info_of(channel.role).order >= 0; });
}

Fault no_motion(const std::string& recording, const std::vector<Channel>& channels,
                const std::vector<FoundDerivative>& derivatives, const std::vector<ChannelLook>& looks,
                const std::vector<Check>& checks) {
  const std::vector<RoleGuess> proposed = along_derivatives(channels, derivatives);
  const bool is_chain =
      std::any_of(proposed.begin(), proposed.end(), [](const RoleGuess& guess) { return !guess.why.empty(); });
  const Proposal by_looks = is_chain ? Proposal() : proposal_by_looks(channels, looks, checks);
  std::string lines = fmt::format("# role: {}; other where it is none of these\n", role_choices);
  for (const Check& check : checks)
    if (check.name.ends_with(".left_out")) lines += fmt::format("# {}\n", check.message);
  for (std::size_t i = 0; i < channels.size(); ++i) {
    lines += fmt::format("[[channel]]\nname = {}\n", toml_quoted(channels[i].name));
    if (static_cast<std::ptrdiff_t>(i) == by_looks.channel) {
      lines += by_looks.lines;
      continue;
    }
    const RoleGuess& guess = proposed[i];
    lines += fmt::format("role = \"{}\"{}\n", to_string(guess.role), guess.why.empty() ? "" : "  # " + guess.why);
    if (is_chain && channels[i].unit.empty() && info_of(guess.role).order >= 0)
      lines += unit_line(guess.role, checks, !guess.why.empty());
  }
  return Fault(
      FaultKind::input, "motion.none",
      fmt::format("{}: the relative motion cannot be formed: found {}. Want a displacement, velocity or acceleration "
                  "of the payload (y, dy, ddy), with that of the base where it moves (r, dr, ddr), or between "
                  "both (x, v, a). Give channels their roles in {}:",
                  recording, in_words(channels, looks), sidecar_path(recording).string()),
      std::move(lines));
}

std::vector<RoleGuess> guess_roles(const std::vector<ChannelSpec>& channels, const SourceInfo& info) {
  std::vector<RoleGuess> result(channels.size());
  std::vector<UnnamedRole> open;
  std::vector<std::size_t> places;
  std::vector<Role> given;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    result[i].role = channels[i].role;
    if (channels[i].role_is_known) {
      given.push_back(channels[i].role);
      continue;
    }
    const std::string& unit = info.units[static_cast<std::size_t>(channels[i].index - 1)];
    open.push_back({channels[i].name, unit.empty() ? "" : find_unit(unit).si});
    places.push_back(i);
  }
  const std::vector<RoleGuess> guesses = guess_roles(open, given);
  for (std::size_t k = 0; k < places.size(); ++k) result[places[k]] = guesses[k];
  return result;
}

bool names_acceleration(std::string_view name) {
  return any_word(name, [](const Word& word) { return word.quantity == Kind::acceleration; });
}

bool names_position(std::string_view name) {
  return any_word(name, [](const Word& word) { return word.body || word.quantity == Kind::displacement; }) &&
         !any_word(name, [](const Word& word) { return word.quantity && *word.quantity != Kind::displacement; });
}

bool names_signal(std::string_view name) {
  return find_signal(name) != nullptr || any_word(name, [](const Word&) { return true; });
}

}  // namespace dsp
