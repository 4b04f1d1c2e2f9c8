#pragma once
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/io/setting.hpp"
#include "dsp/io/toml_text.hpp"
#include "dsp/values/faults.hpp"

namespace dsp {

/// A table of a document, and where it is.
struct SettingsTable {
  const toml::table* node = nullptr;
  std::string path = {};   ///< "range.0", as an override names it
  std::string name = {};   ///< "range": elements share it
  std::string shown = {};  ///< "[[range]] 1: ": before a key in a message, elements counted as people do

  [[nodiscard]] SettingsTable inner(std::string_view key, const toml::table* table) const;
  [[nodiscard]] SettingsTable element(std::string_view key, std::size_t i, const toml::table* table) const;
};

/// The document behind a Settings and all handles on it.
struct SettingsDocument {
  std::string name;
  toml::table root;
  std::map<std::string, std::string> overrides;  ///< path of the key -> the override as typed
  std::set<std::string> wrong;                   ///< paths of values that count as absent
  Faults faults, unknown;                        ///< found in reading, not yet thrown; unknown keys last

  // As Settings has them.
  [[nodiscard]] std::string place(const SettingsTable& table, std::string_view key) const;
  [[nodiscard]] Fault fault(const SettingsTable& table, std::string_view key, std::string name,
                            std::string_view what) const;
};

/// "a.b" for a key "b" in a table "a"; the key alone at the top.
[[nodiscard]] std::string key_path(const std::string& table, std::string_view key);

/// Sets what `a.b=c` says. Throws Fault (usage, "config.override").
void apply_override(SettingsDocument& document, const std::string& text);

/// As Settings::check.
void check_document(SettingsDocument& document, const std::vector<Setting>& layout, int schema);

/// A text as it is, any other value as TOML has it, a number in as few digits as give it back.
[[nodiscard]] std::string value_text(const toml::node& node);

/// Calls `take` with each element of an array, or with what is none.
template <class Take>
void for_each_value(const toml::node& node, Take&& take) {
  const toml::array* array = node.as_array();
  if (array == nullptr) return take(node);
  for (const toml::node& element : *array) take(element);
}

}  // namespace dsp
