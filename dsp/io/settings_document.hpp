#pragma once
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/faults.hpp"
#include "dsp/io/asked_setting.hpp"
#include "dsp/io/toml_text.hpp"

namespace dsp {

/// The document behind a Settings and all handles on it, with what was asked of it.
struct SettingsDocument {
  std::string name;
  toml::table root;
  std::map<std::string, std::string> overrides;        ///< path of the key -> the override as typed
  std::map<std::string, std::set<std::string>> asked;  ///< path of a table -> keys asked for in it
  std::set<std::string> free;                          ///< paths of tables that may hold anything
  std::vector<AskedSetting> settings;                  ///< the same keys in the order of asking, and how
  Faults faults;                                       ///< found in reading, not yet thrown
  bool is_interrupted = false;                         ///< not all was asked for that would have been

  /// The record of a key in a table called `path`, made where there is none.
  AskedSetting& setting(const std::string& path, std::string_view key) &;
};

/// "a.b" for a key "b" in a table "a"; the key alone at the top.
[[nodiscard]] std::string key_path(const std::string& table, std::string_view key);

/// The same as messages name it: "[[range]] 1: to" for "range.0.to", the first one, as people count.
[[nodiscard]] std::string shown_path(const std::string& path);

/// Sets what `a.b=c` says. Throws Fault (usage, "config.override").
void apply_override(SettingsDocument& document, const std::string& text);

/// Adds a fault "config.unknown_key" for each key of `table` or below that nobody asked for.
void check_keys(SettingsDocument& document, const toml::table& table, const std::string& path);

}  // namespace dsp
