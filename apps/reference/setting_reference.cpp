#include "apps/reference/setting_reference.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cctype>
#include <cmath>

#include "apps/config/config.hpp"
#include "dsp/io/sidecar.hpp"
#include "dsp/io/units.hpp"

namespace apps {
namespace {

std::string number_facts(const dsp::SettingType& type) {
  const std::string kind = type.number ? "number" : "whole number";
  const auto [from, to, above] = type.range;
  const bool low = std::isfinite(from), high = std::isfinite(to);
  if (low && high) return fmt::format("{} {} {} to {}", kind, above ? "above" : "from", from, to);
  if (low) return fmt::format("{}{} {}", kind, above ? " above" : ", at least", from);
  return high ? fmt::format("{}, at most {}", kind, to) : kind;
}

/// "number above 0 or text", "one of \"matched\", \"paper\"".
std::string in_words(const dsp::SettingType& type) {
  std::vector<std::string> kinds;
  if (type.number || type.whole_number) kinds.push_back(number_facts(type));
  std::vector<std::string> words;
  for (const std::string& word : type.words)
    if (!word.empty()) words.push_back(fmt::format("\"{}\"", word));
  if (!words.empty())
    kinds.push_back(fmt::format("{}{}", words.size() > 1 ? "one of " : "", fmt::join(words, ", ")));
  else if (type.text)
    kinds.emplace_back("text");
  if (type.flag) kinds.emplace_back("true or false");
  if (type.date) kinds.emplace_back("date, time or text");
  if (type.table) kinds.emplace_back("table { ... }");
  return fmt::format("{}{}", fmt::join(kinds, ", or "), type.several ? ", or an array of such" : "");
}

/// What holds where a key is left out; empty: nothing in its place.
std::string left_out(const dsp::Setting& setting) {
  if (!setting.left_out.empty()) return setting.left_out;
  if (setting.fallback == "[]") return "none";
  std::string fallback = setting.fallback == "\"\"" ? "" : setting.fallback;
  if (fallback.ends_with(".0")) fallback.resize(fallback.size() - 2);
  return fallback;
}

std::string facts_of(const dsp::Setting& setting) {
  std::string facts = in_words(setting.type);
  facts[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(facts[0])));
  if (!setting.unit.empty()) facts += fmt::format("; in {}", setting.unit);
  const std::string otherwise = left_out(setting);
  if (!otherwise.empty()) return fmt::format("{}; left out: {}.", facts, otherwise);
  return facts + (setting.required ? "; must be given." : ".");
}

/// A section for each table, headed as a person writes it.
std::vector<Section> sections_of(const std::vector<dsp::Setting>& settings) {
  std::vector<Section> sections{{"At the top", "", {}, {}}};
  std::string table;
  for (const dsp::Setting& setting : settings) {
    if (setting.is_heading()) {
      table = setting.key;
      sections.push_back({setting.type.elements ? "[[" + table + "]]" : "[" + table + "]", setting.meaning, {}, {}});
    } else if (setting.table == table && setting.former.empty()) {
      sections.back().entries.push_back({setting.key, setting.meaning, facts_of(setting)});
    }
  }
  return sections;
}

void prepend(Page& page, std::vector<Section> sections) {
  page.sections.insert(page.sections.begin(), std::make_move_iterator(sections.begin()),
                       std::make_move_iterator(sections.end()));
}

}  // namespace

Page config_page() {
  Page page{"config", "Settings of a run, in TOML", "", sections_of(config_settings())};
  prepend(page,
          {{"",
            "A config says what differs from the defaults; only [[recording]] with its file is needed. Paths count "
            "from the config's own folder. Any key can be given on the command line instead: --set "
            "prepare.cutoff_hz=10.24, --set range.0.to=830, --set 'library.terms=[\"sgn(v)\"]'. Lines, rows, columns, "
            "channels, recordings and ranges are counted from 1, also in "
            "messages ([[range]] 1 is the first); only --set counts the elements of lists from 0, as programs do: "
            "range.0 is the first. A run folder's "
            "config.toml has every setting that was used."}});
  page.sections.push_back(
      {"Example",
       "",
       {},
       {"schema = 1", "[[recording]]", "file = \"drive.wav\"", "[prepare]", "rate_hz = 25.6", "cutoff_hz = 10.24",
        "[[range]]", "name = \"low\"", "from = 0", "to = 830", "train_to = 500"}});
  return page;
}

Page sidecar_page() {
  Page page{"sidecar", "What is known of a recording and its sensors, in TOML beside it", "",
            sections_of(dsp::sidecar_settings())};
  prepend(
      page,
      {{"",
        "A recording drive.wav is described by drive.wav.toml beside it. `ardent init drive.wav` writes a first one. "
        "A CSV whose header says names and units needs none.\n\n"
        "One sidecar may serve many recordings made with the same set-up: name it on the command line (ardent run "
        "monday.csv --sidecar rig.toml) or in each config ([[recording]] sidecar = \"rig.toml\"). What it says, "
        "[[range]] and [[bad]] included, then holds for each of them.\n\n"
        "Quantities are texts of a number and a unit: \"0.23 ms\", \"10 V\". Sensitivities are electrical per "
        "measured: \"100.1 mV/g\", \"250 mV/mm\"; g is 9.80665 m/s^2."},
       {"Units", fmt::format("{}.", fmt::join(dsp::unit_names(), ", "))}});
  page.sections.push_back({"Example",
                           "",
                           {},
                           {"schema = 1", "rate = 25600", "[[channel]]", "name = \"payload_accelerometer\"",
                            "index = 3", "role = \"ddy\"", "sensitivity = \"100.1 mV/g\"", "full_scale = \"5 V\"",
                            "[[bad]]", "from = 412.1", "to = 412.6", "why = \"cable knocked\""}});
  return page;
}

}  // namespace apps
