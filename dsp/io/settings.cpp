#include "dsp/io/settings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <sstream>
#include <tuple>

#include "dsp/io/settings_document.hpp"
#include "dsp/io/small_file.hpp"
#include "dsp/names.hpp"

namespace dsp {
namespace {

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

}  // namespace

struct Settings::State {
  std::shared_ptr<SettingsDocument> document;
  const toml::table* table = nullptr;
  std::string path;

  const toml::node* find(std::string_view key) const {
    document->asked[path].insert(std::string(key));
    std::ignore = asked(key);
    return table->get(key);
  }
  AskedSetting& asked(std::string_view key) const { return document->setting(path, key); }
  std::shared_ptr<const State> child(const toml::table* node, std::string child_path) const {
    document->asked[child_path];
    return std::make_shared<const State>(State{document, node, std::move(child_path)});
  }
  /// What `read` gives; what it finds wrong is kept, and the key counts as absent.
  template <class Value, class Read>
  std::optional<Value> valid(Read&& read) const {
    std::optional<Value> value;
    document->faults.attempt([&] { value = read(); });
    return value;
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
  auto document = std::make_shared<SettingsDocument>();
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
  AskedSetting& asked = state_->asked(key);
  asked.number = true;
  asked.range = range;
  if (node == nullptr) return std::nullopt;
  return state_->valid<double>([&] { return state_->number(*this, key, *node, range); });
}

double Settings::number(std::string_view key, double fallback, const NumberRange& range) const {
  if (contains(range, fallback)) state_->asked(key).fallback = fmt::format("{}", fallback);
  return find_number(key, range).value_or(fallback);
}

double Settings::need_number(std::string_view key, const NumberRange& range) const {
  const auto* node = state_->find(key);
  AskedSetting& asked = state_->asked(key);
  asked.number = asked.required = true;
  asked.range = range;
  if (node == nullptr) throw fault(key, "config.missing", fmt::format("missing; want a number, {}", describe(range)));
  return state_->number(*this, key, *node, range);
}

std::optional<std::int64_t> Settings::find_integer(std::string_view key, const NumberRange& range) const {
  const auto* node = state_->find(key);
  AskedSetting& asked = state_->asked(key);
  asked.whole_number = true;
  asked.range = range;
  if (node == nullptr) return std::nullopt;
  return state_->valid<std::int64_t>([&] {
    if (!node->is_integer()) state_->wrong_type(*this, key, *node, fmt::format("a whole number, {}", describe(range)));
    std::ignore = state_->number(*this, key, *node, range);
    return *node->value<std::int64_t>();
  });
}

std::int64_t Settings::integer(std::string_view key, std::int64_t fallback, const NumberRange& range) const {
  if (contains(range, static_cast<double>(fallback))) state_->asked(key).fallback = fmt::format("{}", fallback);
  return find_integer(key, range).value_or(fallback);
}

std::optional<bool> Settings::find_flag(std::string_view key) const {
  const auto* node = state_->find(key);
  state_->asked(key).flag = true;
  if (node == nullptr) return std::nullopt;
  return state_->valid<bool>([&] {
    if (!node->is_boolean()) state_->wrong_type(*this, key, *node, "true or false");
    return *node->value<bool>();
  });
}

bool Settings::flag(std::string_view key, bool fallback) const {
  state_->asked(key).fallback = fallback ? "true" : "false";
  return find_flag(key).value_or(fallback);
}

std::optional<std::string> Settings::find_text(std::string_view key, std::string_view example) const {
  const auto* node = state_->find(key);
  state_->asked(key).text = true;
  if (node == nullptr) return std::nullopt;
  return state_->valid<std::string>([&] {
    if (!node->is_string())
      state_->wrong_type(*this, key, *node,
                         "a text in quotes" + (example.empty() ? "" : fmt::format(" such as \"{}\"", example)));
    return *node->value<std::string>();
  });
}

std::string Settings::text(std::string_view key, std::string_view fallback) const {
  if (!fallback.empty()) state_->asked(key).fallback = toml_quoted(fallback);
  return find_text(key).value_or(std::string(fallback));
}

std::string Settings::need_text(std::string_view key) const {
  const auto* node = state_->find(key);
  AskedSetting& asked = state_->asked(key);
  asked.text = asked.required = true;
  if (node == nullptr) throw fault(key, "config.missing", "missing; want a text in quotes");
  if (!node->is_string()) state_->wrong_type(*this, key, *node, "a text in quotes");
  return *node->value<std::string>();
}

std::string Settings::choice(std::string_view key, std::string_view fallback,
                             const std::vector<std::string>& allowed) const {
  const std::string value = text(key, fallback);
  state_->asked(key).words = allowed;
  for (const auto& word : allowed)
    if (value == word) return value;
  const std::string near = nearest(value, allowed);
  state_->document->faults.add(
      fault(key, "config.range",
            fmt::format("got '{}', want one of {}{}", clean_name(value), fmt::join(allowed, ", "),
                        near.empty() ? "" : fmt::format(". Did you mean '{}'?", near))));
  return std::string(fallback);
}

std::vector<double> Settings::numbers(std::string_view key, const NumberRange& range) const {
  const auto* node = state_->find(key);
  AskedSetting& asked = state_->asked(key);
  asked.number = asked.several = true;
  asked.range = range;
  if (node == nullptr) return {};
  const auto* array = node->as_array();
  if (array == nullptr) return {state_->number(*this, key, *node, range)};
  std::vector<double> values;
  for (const auto& element : *array) values.push_back(state_->number(*this, key, element, range));
  return values;
}

std::vector<std::string> Settings::texts(std::string_view key) const {
  const auto* node = state_->find(key);
  AskedSetting& asked = state_->asked(key);
  asked.text = asked.several = true;
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
  state_->asked(key).moment = true;
  if (node == nullptr) return {};
  if (const auto* value = node->as_string()) return value->get();
  if (!node->is_date() && !node->is_time() && !node->is_date_time())
    state_->wrong_type(*this, key, *node, "a date such as 2023-05-04T10:12:30Z");
  return describe(*node);
}

std::map<std::string, std::string> Settings::notes(std::string_view key) const {
  const auto* node = state_->find(key);
  state_->asked(key).notes = true;
  if (node == nullptr) return {};
  const auto* table = node->as_table();
  if (table == nullptr) state_->wrong_type(*this, key, *node, "a table such as { model = \"352C33\" }");
  state_->document->free.insert(key_path(state_->path, key));
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
  state_->asked(key).table_of_its_own = true;
  const auto path = key_path(state_->path, key);
  if (node == nullptr) return Settings(state_->child(&nothing, path));
  if (!node->is_table()) state_->wrong_type(*this, key, *node, fmt::format("a table [{}]", path));
  return Settings(state_->child(node->as_table(), path));
}

std::vector<Settings> Settings::tables(std::string_view key) const {
  const auto* node = state_->find(key);
  state_->asked(key).tables = true;
  if (node == nullptr) return {};
  const auto path = key_path(state_->path, key);
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

void Settings::refuse_former(std::string_view key, std::string_view instead) const {
  if (state_->table->get(key) == nullptr) return;
  state_->document->asked[state_->path].insert(std::string(key));  // said here, not as an unknown key
  state_->document->faults.add(fault(key, "config.former_key", fmt::format("is no key any more. {}", instead)));
}

void Settings::check_schema(std::int64_t ours) const {
  const auto version = find_integer("schema", {.from = 1});
  state_->document->faults.raise();
  if (!version || *version == ours) return;
  throw fault("schema", "config.schema",
              fmt::format("got {}, this program reads {}. {}", *version, ours,
                          *version > ours ? fmt::format("A newer version of ardent reads schema {}", *version)
                                          : fmt::format("Write it again for schema {}", ours)));
}

void Settings::attempt(const std::function<void()>& read) const {
  if (!state_->document->faults.attempt(read)) state_->document->is_interrupted = true;
}

void Settings::finish(const std::function<std::vector<AskedSetting>()>& known) const {
  if (state_->document->is_interrupted && known) state_->document->settings = known();
  check_keys(*state_->document, *state_->table, state_->path);
  state_->document->faults.raise();
}

const std::vector<AskedSetting>& Settings::asked() const& {
  return state_->document->settings;
}

std::string Settings::place(std::string_view key) const {
  const std::string path = key.empty() ? state_->path : key_path(state_->path, key);
  for (const auto& [set_path, text] : state_->document->overrides)
    if (path == set_path || path.starts_with(set_path + ".")) return text;
  const auto* node = key.empty() ? nullptr : state_->table->get(key);
  const auto line = (node != nullptr ? node->source() : state_->table->source()).begin.line;
  return line > 0 ? fmt::format("{}:{}", state_->document->name, line) : state_->document->name;
}

Fault Settings::fault(std::string_view key, std::string name, std::string_view what) const {
  const std::string where = place(key), whole = key_path(state_->path, key);
  const std::string path = clean_name(where.starts_with("--set ") ? whole : shown_path(whole));
  return Fault(FaultKind::usage, std::move(name),
               fmt::format("{}: {}{}{}", where, path, path.empty() ? "" : ": ", what));
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
