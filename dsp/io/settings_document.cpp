#include "dsp/io/settings_document.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "dsp/fault.hpp"
#include "dsp/names.hpp"

namespace dsp {
namespace {

[[noreturn]] void raise(std::string name, const std::string& message) {
  throw Fault(FaultKind::usage, std::move(name), message);
}

std::optional<std::size_t> as_index(std::string_view text) {
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// The path without the numbers of elements: "range.0" is "range".
std::string table_of(const std::string& path) {
  std::string table;
  for (std::size_t from = 0; from < path.size();) {
    const auto dot = std::min(path.find('.', from), path.size());
    const std::string part = path.substr(from, dot - from);
    if (!as_index(part)) table = key_path(table, part);
    from = dot + 1;
  }
  return table;
}

// Where a key that is unknown in `table` is known, as a person writes that place; else the nearest of `known`.
std::string advice(const SettingsDocument& document, const std::string& table, const std::string& key,
                   const std::vector<std::string>& known) {
  const std::string near = nearest(key, known);
  for (const AskedSetting& one : document.settings) {
    if (one.key != key || one.table == table) continue;
    const bool elements = std::any_of(document.settings.begin(), document.settings.end(), [&](const AskedSetting& own) {
      return own.tables && own.table.empty() && own.key == one.table;
    });
    const std::string place = one.table.empty() ? "the top of the file, above the first [table]"
                              : elements        ? fmt::format("[[{}]]", one.table)
                                                : fmt::format("[{}]", one.table);
    return fmt::format("It is a key of {}, on a command line --set {}. Known here: {}", place,
                       elements ? fmt::format("{}.0.{}=VALUE", one.table, key) : key_path(one.table, key) + "=VALUE",
                       fmt::join(known, ", "));
  }
  return near.empty() ? fmt::format("Known here: {}", fmt::join(known, ", ")) : fmt::format("Did you mean '{}'?", near);
}

// The value of an override: TOML, or text where it is none.
toml::table parse_override(std::string_view value) {
  try {
    auto parsed = parse_toml(fmt::format("value = {}", value), "");
    if (parsed.size() == 1) return parsed;
  } catch (const Fault&) {
  }
  return toml::table{{"value", std::string(value)}};
}

// Steps from `node` into the element called `key`, making what is missing: a table, or an array before a number.
toml::node* step(toml::node* node, std::string_view key, bool array_next) {
  const auto make = [&](auto&& insert) { array_next ? insert(toml::array{}) : insert(toml::table{}); };
  if (auto* table = node->as_table()) {
    if (table->find(key) == table->end()) make([&](auto&& value) { table->insert(key, value); });
    return table->get(key);
  }
  const auto index = as_index(key);
  auto* array = node->as_array();
  if (array == nullptr || !index || *index > array->size()) return nullptr;
  if (*index == array->size()) make([&](auto&& value) { array->push_back(value); });
  return array->get(*index);
}

}  // namespace

std::string key_path(const std::string& table, std::string_view key) {
  return table.empty() ? std::string(key) : fmt::format("{}.{}", table, key);
}

std::string shown_path(const std::string& path) {
  std::string table, shown;
  for (std::size_t from = 0; from < path.size();) {
    const auto dot = std::min(path.find('.', from), path.size());
    const std::string part = path.substr(from, dot - from);
    if (const auto index = as_index(part); index && !table.empty()) {
      shown += fmt::format("[[{}]] {}: ", table, *index + 1);
      table.clear();
    } else {
      table = key_path(table, part);
    }
    from = dot + 1;
  }
  return table.empty() && shown.ends_with(": ") ? shown.substr(0, shown.size() - 2) : shown + table;
}

AskedSetting& SettingsDocument::setting(const std::string& path, std::string_view key) & {
  const std::string table = table_of(path);
  const auto known = std::find_if(settings.begin(), settings.end(),
                                  [&](const AskedSetting& one) { return one.key == key && one.table == table; });
  if (known != settings.end()) return *known;
  settings.push_back({table, std::string(key)});
  return settings.back();
}

void add_asked(std::vector<AskedSetting>& all, const std::vector<AskedSetting>& further) {
  for (const AskedSetting& one : further) {
    const auto known = std::find_if(all.begin(), all.end(), [&](const AskedSetting& other) {
      return other.key == one.key && other.table == one.table;
    });
    if (known == all.end()) {
      all.push_back(one);
      continue;
    }
    for (const auto kind : {&AskedSetting::number, &AskedSetting::whole_number, &AskedSetting::flag,
                            &AskedSetting::text, &AskedSetting::several, &AskedSetting::moment, &AskedSetting::notes,
                            &AskedSetting::table_of_its_own, &AskedSetting::tables, &AskedSetting::required})
      *known.*kind = *known.*kind || one.*kind;
    if (one.number || one.whole_number) known->range = one.range;
    if (known->words.empty()) known->words = one.words;
    if (known->fallback.empty()) known->fallback = one.fallback;
  }
}

void apply_override(SettingsDocument& document, const std::string& text) {
  const auto equals = text.find('=');
  const std::string path = text.substr(0, equals);
  const auto bad = [&](std::string_view why) {
    raise("config.override", fmt::format("--set {}: {}", clean_name(text), why));
  };
  if (equals == std::string::npos || equals == 0) bad("want key=value, for example range.0.to=5");
  std::vector<std::string> keys;
  for (std::size_t from = 0; from <= path.size();) {
    const auto dot = std::min(path.find('.', from), path.size());
    keys.push_back(path.substr(from, dot - from));
    if (keys.back().empty()) bad("an empty name between the dots");
    if (keys.size() > most_key_parts) bad(fmt::format("a key of more than {} parts", most_key_parts));
    from = dot + 1;
  }
  toml::node* node = &document.root;
  for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
    node = step(node, keys[i], as_index(keys[i + 1]).has_value());
    if (node == nullptr) bad(fmt::format("'{}' is not there to be set into", keys[i]));
  }
  auto value = parse_override(std::string_view(text).substr(equals + 1));
  const auto index = as_index(keys.back());
  if (auto* table = node->as_table()) {
    table->insert_or_assign(keys.back(), std::move(*value.get("value")));
  } else if (auto* array = node->as_array(); array != nullptr && index && *index <= array->size()) {
    if (*index < array->size())
      array->replace(array->cbegin() + static_cast<std::ptrdiff_t>(*index), std::move(*value.get("value")));
    else
      array->push_back(std::move(*value.get("value")));
  } else {
    bad(fmt::format("'{}' is not there to be set", keys.back()));
  }
  document.overrides[path] = fmt::format("--set {}", clean_name(text));
}

void check_keys(SettingsDocument& document, const toml::table& table, const std::string& path) {
  const auto found = document.asked.find(path);
  std::set<std::string> asked = found == document.asked.end() ? std::set<std::string>() : found->second;
  if (document.is_interrupted)
    for (const AskedSetting& one : document.settings)
      if (one.table == table_of(path)) asked.insert(one.key);
  for (const auto& [name, node] : table) {
    if (document.faults.is_full()) return;
    const std::string key(name.str()), child = key_path(path, key);
    if (!asked.contains(key)) {
      const std::vector<std::string> known(asked.begin(), asked.end());
      const auto line = node.source().begin.line;
      std::string place = line > 0 ? fmt::format("{}:{}", document.name, line) : document.name;
      std::string shown = shown_path(child);
      for (const auto& [set_path, text] : document.overrides)
        if (set_path == child || set_path.starts_with(child + ".") || child.starts_with(set_path + "."))
          place = text, shown = child;
      document.faults.add(Fault(FaultKind::usage, "config.unknown_key",
                                fmt::format("{}: unknown key '{}'. {}", place, clean_name(shown),
                                            advice(document, table_of(path), clean_name(key), known))));
      continue;
    }
    if (document.free.contains(child)) continue;
    if (const auto* inner = node.as_table()) check_keys(document, *inner, child);
    if (const auto* array = node.as_array())
      for (std::size_t i = 0; i < array->size(); ++i)
        if (const auto* element = array->get(i)->as_table())
          check_keys(document, *element, fmt::format("{}.{}", child, i));
  }
}

}  // namespace dsp
