#include "dsp/io/settings.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <set>
#include <sstream>
#include <tuple>

#include "dsp/io/small_file.hpp"
#include "dsp/io/toml_text.hpp"
#include "dsp/names.hpp"

namespace dsp {
namespace {

struct Document {
  std::string name;
  toml::table root;
  std::map<std::string, std::string> overrides;        // path of the key -> the override as typed
  std::map<std::string, std::set<std::string>> asked;  // path of a table -> keys asked for in it
  std::set<std::string> free;                          // paths of tables that may hold anything
};

std::string join(const std::string& path, std::string_view key) {
  return path.empty() ? std::string(key) : fmt::format("{}.{}", path, key);
}

[[noreturn]] void raise(std::string name, const std::string& message) {
  throw Fault(FaultKind::usage, std::move(name), message);
}

std::string describe(const toml::node& node) {
  if (const auto* value = node.as_string()) return fmt::format("the text '{}'", clean_name(value->get()));
  if (node.is_array()) return "an array";
  if (node.is_table()) return "a table";
  std::ostringstream out;
  node.visit([&](const auto& value) { out << value; });
  return out.str();
}

std::string describe(const NumberRange& range) {
  const bool low = std::isfinite(range.from), high = std::isfinite(range.to);
  if (low && high) return fmt::format("{}{} to {}", range.above ? "above " : "", range.from, range.to);
  if (low) return fmt::format("{} {}", range.above ? "above" : "at least", range.from);
  if (high) return fmt::format("at most {}", range.to);
  return "finite";
}

bool contains(const NumberRange& range, double value) {
  return std::isfinite(value) && value <= range.to && (range.above ? value > range.from : value >= range.from);
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

void apply_override(Document& document, const std::string& text) {
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

}  // namespace

struct Settings::State {
  std::shared_ptr<Document> document;
  const toml::table* table = nullptr;
  std::string path;

  const toml::node* find(std::string_view key) const {
    document->asked[path].insert(std::string(key));
    return table->get(key);
  }
  std::shared_ptr<const State> child(const toml::table* node, std::string child_path) const {
    document->asked[child_path];
    return std::make_shared<const State>(State{document, node, std::move(child_path)});
  }
  [[noreturn]] void wrong_type(const Settings& settings, std::string_view key, const toml::node& node,
                               std::string_view want) const {
    throw settings.fault(key, "config.type", fmt::format("got {}, want {}", describe(node), want));
  }
  double number(const Settings& settings, std::string_view key, const toml::node& node,
                const NumberRange& range) const {
    const auto value = node.is_number() ? node.value<double>() : std::nullopt;
    if (!value) wrong_type(settings, key, node, fmt::format("a number, {}", describe(range)));
    if (!contains(range, *value))
      throw settings.fault(key, "config.range", fmt::format("got {}, want a number, {}", *value, describe(range)));
    return *value;
  }
};

Settings Settings::from_text(std::string_view text, const std::string& name,
                             const std::vector<std::string>& overrides) {
  auto document = std::make_shared<Document>();
  document->name = name;
  document->root = parse_toml(text, name);
  for (const auto& text_override : overrides) apply_override(*document, text_override);
  document->asked[""];
  const toml::table* root = &document->root;
  return Settings(std::make_shared<const State>(State{std::move(document), root, ""}));
}

Settings Settings::from_file(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  return from_text(read_small_file(file, {.kind = FaultKind::usage, .fault = "config.file"}), clean_name(file.string()),
                   overrides);
}

std::optional<double> Settings::find_number(std::string_view key, const NumberRange& range) const {
  const auto* node = state_->find(key);
  if (node == nullptr) return std::nullopt;
  return state_->number(*this, key, *node, range);
}

double Settings::number(std::string_view key, double fallback, const NumberRange& range) const {
  return find_number(key, range).value_or(fallback);
}

double Settings::need_number(std::string_view key, const NumberRange& range) const {
  const auto value = find_number(key, range);
  if (!value) throw fault(key, "config.missing", fmt::format("missing; want a number, {}", describe(range)));
  return *value;
}

std::optional<std::int64_t> Settings::find_integer(std::string_view key, const NumberRange& range) const {
  const auto* node = state_->find(key);
  if (node == nullptr) return std::nullopt;
  if (!node->is_integer()) state_->wrong_type(*this, key, *node, fmt::format("a whole number, {}", describe(range)));
  std::ignore = state_->number(*this, key, *node, range);
  return node->value<std::int64_t>();
}

std::int64_t Settings::integer(std::string_view key, std::int64_t fallback, const NumberRange& range) const {
  return find_integer(key, range).value_or(fallback);
}

std::optional<bool> Settings::find_flag(std::string_view key) const {
  const auto* node = state_->find(key);
  if (node == nullptr) return std::nullopt;
  if (!node->is_boolean()) state_->wrong_type(*this, key, *node, "true or false");
  return node->value<bool>();
}

bool Settings::flag(std::string_view key, bool fallback) const {
  return find_flag(key).value_or(fallback);
}

std::optional<std::string> Settings::find_text(std::string_view key) const {
  const auto* node = state_->find(key);
  if (node == nullptr) return std::nullopt;
  if (!node->is_string()) state_->wrong_type(*this, key, *node, "a text in quotes");
  return node->value<std::string>();
}

std::string Settings::text(std::string_view key, std::string_view fallback) const {
  return find_text(key).value_or(std::string(fallback));
}

std::string Settings::need_text(std::string_view key) const {
  const auto value = find_text(key);
  if (!value) throw fault(key, "config.missing", "missing; want a text in quotes");
  return *value;
}

std::string Settings::choice(std::string_view key, std::string_view fallback,
                             const std::vector<std::string>& allowed) const {
  const std::string value = text(key, fallback);
  for (const auto& word : allowed)
    if (value == word) return value;
  const std::string near = nearest(value, allowed);
  throw fault(key, "config.range",
              fmt::format("got '{}', want one of {}{}", clean_name(value), fmt::join(allowed, ", "),
                          near.empty() ? "" : fmt::format(". Did you mean '{}'?", near)));
}

std::vector<double> Settings::numbers(std::string_view key, const NumberRange& range) const {
  const auto* node = state_->find(key);
  if (node == nullptr) return {};
  const auto* array = node->as_array();
  if (array == nullptr) return {state_->number(*this, key, *node, range)};
  std::vector<double> values;
  for (const auto& element : *array) values.push_back(state_->number(*this, key, element, range));
  return values;
}

std::vector<std::string> Settings::texts(std::string_view key) const {
  const auto* node = state_->find(key);
  if (node == nullptr) return {};
  std::vector<std::string> values;
  const auto take = [&](const toml::node& element) {
    if (!element.is_string()) state_->wrong_type(*this, key, element, "a text in quotes, or an array of them");
    values.push_back(*element.value<std::string>());
  };
  if (const auto* array = node->as_array())
    for (const auto& element : *array) take(element);
  else
    take(*node);
  return values;
}

std::string Settings::moment(std::string_view key) const {
  const auto* node = state_->find(key);
  if (node == nullptr) return {};
  if (const auto* value = node->as_string()) return value->get();
  if (!node->is_date() && !node->is_time() && !node->is_date_time())
    state_->wrong_type(*this, key, *node, "a date such as 2023-05-04T10:12:30Z");
  return describe(*node);
}

std::map<std::string, std::string> Settings::notes(std::string_view key) const {
  const auto* node = state_->find(key);
  if (node == nullptr) return {};
  const auto* table = node->as_table();
  if (table == nullptr) state_->wrong_type(*this, key, *node, "a table such as { model = \"352C33\" }");
  state_->document->free.insert(join(state_->path, key));
  std::map<std::string, std::string> values;
  for (const auto& [name, value] : *table) {
    const auto* text_value = value.as_string();
    values[std::string(name.str())] = text_value != nullptr ? text_value->get() : describe(value);
  }
  return values;
}

Settings Settings::table(std::string_view key) const {
  static const toml::table nothing;
  const auto* node = state_->find(key);
  const auto path = join(state_->path, key);
  if (node == nullptr) return Settings(state_->child(&nothing, path));
  if (!node->is_table()) state_->wrong_type(*this, key, *node, fmt::format("a table [{}]", path));
  return Settings(state_->child(node->as_table(), path));
}

std::vector<Settings> Settings::tables(std::string_view key) const {
  const auto* node = state_->find(key);
  if (node == nullptr) return {};
  const auto path = join(state_->path, key);
  const auto want = fmt::format("tables, each under [[{}]]", path);
  const auto* array = node->as_array();
  if (array == nullptr) state_->wrong_type(*this, key, *node, want);
  std::vector<Settings> children;
  for (std::size_t i = 0; i < array->size(); ++i) {
    const auto* element = array->get(i);
    if (!element->is_table()) state_->wrong_type(*this, key, *element, want);
    children.push_back(Settings(state_->child(element->as_table(), fmt::format("{}.{}", path, i))));
  }
  return children;
}

bool Settings::has(std::string_view key) const {
  return state_->find(key) != nullptr;
}

bool Settings::is_text(std::string_view key) const {
  const auto* node = state_->find(key);
  return node != nullptr && node->is_string();
}

std::vector<std::string> Settings::keys() const {
  std::vector<std::string> names;
  for (const auto& [name, value] : *state_->table) names.emplace_back(name.str());
  return names;
}

void Settings::exclusive(std::string_view key, std::string_view other) const {
  if (has(key) && has(other))
    throw fault(other, "config.range", fmt::format("cannot be given beside '{}': give one", key));
}

void Settings::check_schema(std::int64_t ours) const {
  const auto version = find_integer("schema", {.from = 1});
  if (!version || *version == ours) return;
  throw fault("schema", "config.schema",
              fmt::format("got {}, this program reads {}. {}", *version, ours,
                          *version > ours ? fmt::format("A newer version of ardent reads schema {}", *version)
                                          : fmt::format("Write it again for schema {}", ours)));
}

namespace {
void check_keys(const Document& document, const toml::table& table, const std::string& path) {
  const auto found = document.asked.find(path);
  static const std::set<std::string> none;
  const auto& asked = found == document.asked.end() ? none : found->second;
  for (const auto& [name, node] : table) {
    const std::string key(name.str()), child = join(path, key);
    if (!asked.contains(key)) {
      const std::vector<std::string> known(asked.begin(), asked.end());
      const std::string near = nearest(key, known);
      const auto line = node.source().begin.line;
      std::string place = line > 0 ? fmt::format("{}:{}", document.name, line) : document.name;
      for (const auto& [set_path, text] : document.overrides)
        if (set_path == child || set_path.starts_with(child + ".") || child.starts_with(set_path + ".")) place = text;
      raise("config.unknown_key", fmt::format("{}: unknown key '{}'. {}", place, clean_name(child),
                                              near.empty() ? fmt::format("Known here: {}", fmt::join(known, ", "))
                                                           : fmt::format("Did you mean '{}'?", near)));
    }
    if (document.free.contains(child)) continue;
    if (const auto* inner = node.as_table()) check_keys(document, *inner, child);
    if (const auto* array = node.as_array())
      for (std::size_t i = 0; i < array->size(); ++i)
        if (const auto* element = array->get(i)->as_table())
          check_keys(document, *element, fmt::format("{}.{}", child, i));
  }
}
}  // namespace

void Settings::finish() const {
  check_keys(*state_->document, *state_->table, state_->path);
}

std::string Settings::place(std::string_view key) const {
  const std::string path = key.empty() ? state_->path : join(state_->path, key);
  for (const auto& [set_path, text] : state_->document->overrides)
    if (path == set_path || path.starts_with(set_path + ".")) return text;
  const auto* node = key.empty() ? nullptr : state_->table->get(key);
  const auto line = (node != nullptr ? node->source() : state_->table->source()).begin.line;
  return line > 0 ? fmt::format("{}:{}", state_->document->name, line) : state_->document->name;
}

Fault Settings::fault(std::string_view key, std::string name, std::string_view what) const {
  const std::string path = clean_name(join(state_->path, key));
  return Fault(FaultKind::usage, std::move(name),
               fmt::format("{}: {}{}{}", place(key), path, path.empty() ? "" : ": ", what));
}

std::string toml_quoted(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (code < 0x20 || code == 0x7f) {
      quoted += fmt::format("\\u{:04X}", code);
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

}  // namespace dsp
