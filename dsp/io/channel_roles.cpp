#include "dsp/io/channel_roles.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string_view>

#include "dsp/io/settings.hpp"

namespace dsp {
namespace {

enum class Quantity { displacement, velocity, acceleration, force, input };

/// A word of a name, or how a longer one begins.
struct Word {
  std::string_view text;
  std::optional<Body> body;
  std::optional<Quantity> quantity;
  bool is_beginning = false;
};

constexpr auto base = Body::base, payload = Body::payload, relative = Body::relative;
constexpr auto none = std::nullopt;

// Without accents and capitals.
constexpr std::array words{
    Word{"base", base, none},
    Word{"ground", base, none},
    Word{"floor", base, none},
    Word{"table", base, none},
    Word{"shaker", base, none},
    Word{"support", base, none},
    Word{"foundation", base, none},
    Word{"bottom", base, none},
    Word{"fuss", base, none},
    Word{"fundament", base, none, true},
    Word{"tisch", base, none, true},
    Word{"boden", base, none},
    Word{"unten", base, none},
    Word{"socle", base, none},
    Word{"sol", base, none},
    Word{"bati", base, none},
    Word{"suelo", base, none},
    Word{"mesa", base, none},
    Word{"bancada", base, none},
    Word{"solo", base, none},
    Word{"payload", payload, none},
    Word{"mass", payload, none},
    Word{"masse", payload, none},
    Word{"masa", payload, none},
    Word{"massa", payload, none},
    Word{"top", payload, none},
    Word{"tip", payload, none},
    Word{"oben", payload, none},
    Word{"nutzlast", payload, none},
    Word{"haut", payload, none},
    Word{"charge", payload, none},
    Word{"carga", payload, none},
    Word{"rel", relative, none},
    Word{"relativ", relative, none, true},
    Word{"disp", none, Quantity::displacement},
    Word{"displ", none, Quantity::displacement},
    Word{"displacement", none, Quantity::displacement, true},
    Word{"pos", none, Quantity::displacement},
    Word{"position", none, Quantity::displacement},
    Word{"laser", none, Quantity::displacement},
    Word{"encoder", none, Quantity::displacement},
    Word{"lvdt", none, Quantity::displacement},
    Word{"angle", none, Quantity::displacement},
    Word{"theta", none, Quantity::displacement},
    Word{"phi", none, Quantity::displacement},
    Word{"deflection", none, Quantity::displacement},
    Word{"weg", none, Quantity::displacement},
    Word{"winkel", none, Quantity::displacement},
    Word{"auslenkung", none, Quantity::displacement},
    Word{"verschieb", none, Quantity::displacement, true},
    Word{"deplacement", none, Quantity::displacement},
    Word{"desplaz", none, Quantity::displacement, true},
    Word{"desloc", none, Quantity::displacement, true},
    Word{"posicion", none, Quantity::displacement},
    Word{"posicao", none, Quantity::displacement},
    Word{"vel", none, Quantity::velocity},
    Word{"veloc", none, Quantity::velocity, true},
    Word{"speed", none, Quantity::velocity},
    Word{"ldv", none, Quantity::velocity},
    Word{"vibrometer", none, Quantity::velocity},
    Word{"omega", none, Quantity::velocity},
    Word{"geschwind", none, Quantity::velocity, true},
    Word{"vitesse", none, Quantity::velocity},
    Word{"acc", none, Quantity::acceleration},
    Word{"accel", none, Quantity::acceleration, true},
    Word{"beschl", none, Quantity::acceleration, true},
    Word{"acel", none, Quantity::acceleration, true},
    Word{"force", none, Quantity::force},
    Word{"load", none, Quantity::force},
    Word{"loadcell", none, Quantity::force},
    Word{"torque", none, Quantity::force},
    Word{"kraft", none, Quantity::force},
    Word{"moment", none, Quantity::force},
    Word{"drehmoment", none, Quantity::force},
    Word{"effort", none, Quantity::force},
    Word{"couple", none, Quantity::force},
    Word{"fuerza", none, Quantity::force},
    Word{"forca", none, Quantity::force},
    Word{"input", none, Quantity::input},
    Word{"excit", none, Quantity::input, true},
    Word{"command", none, Quantity::input},
    Word{"drive", none, Quantity::input},
    Word{"voltage", none, Quantity::input},
    Word{"current", none, Quantity::input},
    Word{"pressure", none, Quantity::input},
    Word{"anregung", none, Quantity::input},
    Word{"spannung", none, Quantity::input},
    Word{"strom", none, Quantity::input},
    Word{"druck", none, Quantity::input},
    Word{"entree", none, Quantity::input},
    Word{"tension", none, Quantity::input},
    Word{"pression", none, Quantity::input},
    Word{"entrada", none, Quantity::input},
    Word{"voltaje", none, Quantity::input},
    Word{"tensao", none, Quantity::input},
    Word{"presion", none, Quantity::input},
    Word{"pressao", none, Quantity::input},
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
  const auto* found = std::find_if(words.begin(), words.end(), [&](const Word& word) {
    return word.is_beginning ? text.starts_with(word.text) : text == word.text;
  });
  return found == words.end() ? nullptr : found;
}

std::optional<Quantity> quantity_in(std::string_view si) {
  static const std::map<std::string_view, Quantity> known{{"m", Quantity::displacement},
                                                          {"rad", Quantity::displacement},
                                                          {"m/s", Quantity::velocity},
                                                          {"rad/s", Quantity::velocity},
                                                          {"m/s^2", Quantity::acceleration},
                                                          {"rad/s^2", Quantity::acceleration},
                                                          {"N", Quantity::force},
                                                          {"N*m", Quantity::force},
                                                          {"Pa", Quantity::input},
                                                          {"V", Quantity::input},
                                                          {"A", Quantity::input}};
  const auto found = known.find(si);
  return found == known.end() ? std::nullopt : std::optional(found->second);
}

/// What a channel measures and of which body.
struct Reading {
  std::optional<Body> body;
  std::optional<Quantity> quantity;
  bool by_name = false, by_unit = false;
  [[nodiscard]] bool is_motion() const { return quantity && *quantity <= Quantity::acceleration; }
};

Reading reading_of(const UnnamedRole& channel) {
  Reading reading;
  std::optional<Quantity> named;
  const std::vector<std::string> texts = words_of(channel.name);
  if (texts.size() == 1 && texts.front() == "f") named = Quantity::force;
  if (texts.size() == 1 && texts.front() == "u") named = Quantity::input;
  for (const std::string& text : texts)
    if (const Word* word = find_word(text)) {
      if (word->body && !reading.body) reading.body = word->body;
      if (word->quantity && !named) named = word->quantity;
    }
  reading.quantity = quantity_in(channel.unit);
  // A sensor's volts are those of what its name says.
  if (named && (!reading.quantity || *reading.quantity == Quantity::input)) reading.quantity = named;
  reading.by_unit = reading.quantity && reading.quantity == quantity_in(channel.unit);
  reading.by_name = named || (reading.body && reading.is_motion());
  return reading;
}

/// The only channel of a quantity, or -1.
std::ptrdiff_t only(const std::vector<Reading>& readings, Quantity quantity) {
  std::ptrdiff_t found = -1;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    if (readings[i].quantity != quantity) continue;
    if (found >= 0) return -1;
    found = static_cast<std::ptrdiff_t>(i);
  }
  return found;
}

}  // namespace

std::vector<RoleGuess> guess_roles(const std::vector<UnnamedRole>& channels, const std::vector<Role>& given) {
  std::vector<Reading> readings;
  for (const UnnamedRole& channel : channels) readings.push_back(reading_of(channel));
  const bool has_base =
      std::any_of(readings.begin(), readings.end(), [](const Reading& r) { return r.is_motion() && r.body == base; }) ||
      std::any_of(given.begin(), given.end(), [](Role role) { return info_of(role).body == base; });
  std::vector<RoleGuess> guesses(channels.size());
  std::ptrdiff_t input = only(readings, Quantity::force);
  if (input < 0 &&
      std::none_of(readings.begin(), readings.end(), [](const Reading& r) { return r.quantity == Quantity::force; }))
    input = only(readings, Quantity::input);
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const Reading& reading = readings[i];
    if (reading.is_motion())
      guesses[i].role =
          motion_signal(reading.body.value_or(has_base ? payload : relative), static_cast<int>(*reading.quantity)).role;
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

std::string role_lines(const std::vector<Channel>& channels) {
  std::string text = fmt::format("# role: {}; other where it is none of these\n", role_choices);
  for (const Channel& channel : channels)
    text += fmt::format("[[channel]]\nname = {}\nrole = \"{}\"\n", toml_quoted(channel.name), to_string(channel.role));
  return text;
}

bool names_acceleration(std::string_view name) {
  for (const std::string& text : words_of(name))
    if (const Word* word = find_word(text); word != nullptr && word->quantity == Quantity::acceleration) return true;
  return false;
}

}  // namespace dsp
