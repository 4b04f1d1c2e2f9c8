#include "dsp/io/settings_document.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <sstream>

#include "dsp/values/fault.hpp"
#include "dsp/values/names.hpp"

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

SettingsTable SettingsTable::inner(std::string_view key, const toml::table* table) const {
  return {table, key_path(path, key), key_path(name, key), fmt::format("{}{}.", shown, key)};
}

SettingsTable SettingsTable::element(std::string_view key, std::size_t i, const toml::table* table) const {
  return {table, fmt::format("{}.{}", key_path(path, key), i), key_path(name, key),
          fmt::format("{}[[{}]] {}: ", shown, key, i + 1)};
}

std::string value_text(const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* number = node.as_floating_point()) return fmt::format("{}", number->get());
  std::ostringstream text;
  node.visit([&](const auto& value) { text << value; });
  return text.str();
}

std::string SettingsDocument::place(const SettingsTable& table, std::string_view key) const {
  const std::string path = key.empty() ? table.path : key_path(table.path, key);
  for (const auto& [set_path, text] : overrides)
    if (path == set_path || path.starts_with(set_path + ".")) return text;
  const auto* node = key.empty() ? nullptr : table.node->get(key);
  const auto line = (node != nullptr ? node->source() : table.node->source()).begin.line;
  return line > 0 ? fmt::format("{}:{}", name, line) : name;
}

Fault SettingsDocument::fault(const SettingsTable& table, std::string_view key, std::string fault_name,
                              std::string_view what) const {
  const std::string where = place(table, key);
  std::string shown = where.starts_with("--set ") ? key_path(table.path, key) : fmt::format("{}{}", table.shown, key);
  if (shown.ends_with(": ")) shown.resize(shown.size() - 2);
  return Fault(FaultKind::usage, std::move(fault_name),
               fmt::format("{}: {}{}{}", where, clean_name(shown), shown.empty() ? "" : ": ", what));
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

}  // namespace dsp
