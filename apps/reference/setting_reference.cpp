#include "apps/reference/setting_reference.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "apps/config/config.hpp"
#include "dsp/io/sidecar.hpp"
#include "dsp/io/units.hpp"

namespace apps {
namespace {

using dsp::AskedSetting;

std::string number_facts(const AskedSetting& setting) {
  const std::string kind = setting.number ? "number" : "whole number";
  const auto [from, to, above] = setting.range;
  // A single number follows from what was asked: one of as many recordings as there are.
  const bool low = std::isfinite(from), high = std::isfinite(to) && from < to;
  if (low && high) return fmt::format("{} {} {} to {}", kind, above ? "above" : "from", from, to);
  if (low) return fmt::format("{}{} {}", kind, above ? " above" : ", at least", from);
  return high ? fmt::format("{}, at most {}", kind, to) : kind;
}

/// "number above 0 or text", "one of \"matched\", \"paper\"".
std::string type_of(const AskedSetting& setting) {
  std::vector<std::string> kinds;
  if (setting.number || setting.whole_number) kinds.push_back(number_facts(setting));
  std::vector<std::string> words;
  for (const std::string& word : setting.words)
    if (!word.empty()) words.push_back(fmt::format("\"{}\"", word));
  if (!words.empty())
    kinds.push_back(fmt::format("{}{}", words.size() > 1 ? "one of " : "", fmt::join(words, ", ")));
  else if (setting.text)
    kinds.emplace_back("text");
  if (setting.flag) kinds.emplace_back("true or false");
  if (setting.moment) kinds.emplace_back("date, time or text");
  if (setting.notes || setting.table_of_its_own) kinds.emplace_back("table { ... }");
  return fmt::format("{}{}", fmt::join(kinds, ", or "), setting.several ? ", or an array of such" : "");
}

std::string facts_of(const AskedSetting& setting, const SettingHelp& help) {
  std::string facts = type_of(setting);
  if (!facts.empty()) facts[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(facts[0])));
  if (!help.unit.empty()) facts += fmt::format("; in {}", help.unit);
  if (!help.left_out.empty()) return fmt::format("{}; left out: {}.", facts, help.left_out);
  if (!setting.fallback.empty()) return fmt::format("{}; left out: {}.", facts, setting.fallback);
  return facts + (setting.required ? "; must be given." : ".");
}

const SettingHelp* find_help(const std::vector<SettingHelp>& help, const std::string& table, const std::string& key) {
  const auto found = std::find_if(help.begin(), help.end(),
                                  [&](const SettingHelp& one) { return one.table == table && one.key == key; });
  return found == help.end() ? nullptr : &*found;
}

/// A table's heading as a person writes it.
std::string heading_of(const std::vector<AskedSetting>& asked, const std::string& table) {
  if (table.empty()) return "At the top";
  const bool elements = std::any_of(asked.begin(), asked.end(), [&](const AskedSetting& one) {
    return one.table.empty() && one.key == table && one.tables;
  });
  return elements ? fmt::format("[[{}]]", table) : fmt::format("[{}]", table);
}

bool is_table_at_top(const AskedSetting& setting) {
  return setting.table.empty() && (setting.tables || setting.table_of_its_own);
}

std::vector<Section> sections_of(const std::vector<AskedSetting>& asked, const std::vector<SettingHelp>& help) {
  std::vector<Section> sections;
  std::vector<std::string> tables{""};
  for (const AskedSetting& setting : asked)
    if (is_table_at_top(setting)) tables.push_back(setting.key);
  for (const std::string& table : tables) {
    Section section{heading_of(asked, table), "", {}, {}};
    if (const SettingHelp* whole = table.empty() ? nullptr : find_help(help, "", table)) section.text = whole->meaning;
    for (const AskedSetting& setting : asked) {
      if (setting.table != table || is_table_at_top(setting)) continue;
      const SettingHelp* words = find_help(help, table, setting.key);
      section.entries.push_back({setting.key, words != nullptr ? words->meaning : "",
                                 facts_of(setting, words != nullptr ? *words : SettingHelp{})});
    }
    sections.push_back(std::move(section));
  }
  return sections;
}

void prepend(Page& page, std::vector<Section> sections) {
  page.sections.insert(page.sections.begin(), std::make_move_iterator(sections.begin()),
                       std::make_move_iterator(sections.end()));
}

}  // namespace

std::vector<std::string> undescribed(const std::vector<AskedSetting>& asked, const std::vector<SettingHelp>& help) {
  std::set<std::string> read, described;
  for (const AskedSetting& setting : asked) read.insert(setting.table + "." + setting.key);
  for (const SettingHelp& one : help)
    if (!one.meaning.empty()) described.insert(one.table + "." + one.key);
  std::vector<std::string> apart;
  std::set_symmetric_difference(read.begin(), read.end(), described.begin(), described.end(),
                                std::back_inserter(apart));
  return apart;
}

Page config_page() {
  Page page{"config", "Settings of a run, in TOML", "", sections_of(config_settings(), config_help())};
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
            sections_of(dsp::sidecar_settings(), sidecar_help())};
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
