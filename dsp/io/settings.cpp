#include "dsp/io/settings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "dsp/io/settings_document.hpp"
#include "dsp/io/small_file.hpp"
#include "dsp/values/names.hpp"

namespace dsp {

struct Settings::State {
  std::shared_ptr<SettingsDocument> document;
  SettingsTable table;

  /// Nothing where it is absent or wrong.
  const toml::node* find(std::string_view key) const {
    const bool wrong = !document->wrong.empty() && document->wrong.contains(key_path(table.path, key));
    return wrong ? nullptr : table.node->get(key);
  }
  std::shared_ptr<const State> of(SettingsTable other) const {
    return std::make_shared<const State>(State{document, std::move(other)});
  }
};

Settings Settings::from_text(std::string_view text, const std::string& name,
                             const std::vector<std::string>& overrides) {
  auto document = std::make_shared<SettingsDocument>();
  document->name = name;
  document->root = parse_toml(text, name);
  for (const auto& text_override : overrides) apply_override(*document, text_override);
  return Settings(std::make_shared<const State>(State{document, {&document->root}}));
}

Settings Settings::from_file(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  return from_text(read_small_file(file, {.kind = FaultKind::usage, .fault = "config.file"}), clean_name(file.string()),
                   overrides);
}

void Settings::check(const std::vector<Setting>& layout, int schema) const {
  check_document(*state_->document, layout, schema);
}

void Settings::attempt(const std::function<void()>& read) const {
  state_->document->faults.attempt(read);
}

void Settings::finish() const {
  for (const Fault& fault : state_->document->unknown.all()) state_->document->faults.add(fault);
  state_->document->faults.raise();
}

std::optional<double> Settings::number(std::string_view key) const {
  const toml::node* node = state_->find(key);
  return node != nullptr ? node->value<double>() : std::nullopt;
}

std::optional<std::string> Settings::text(std::string_view key) const {
  const toml::node* node = state_->find(key);
  return node != nullptr ? std::optional(value_text(*node)) : std::nullopt;
}

std::optional<std::vector<std::string>> Settings::texts(std::string_view key) const {
  const toml::node* node = state_->find(key);
  if (node == nullptr) return std::nullopt;
  std::vector<std::string> values;
  for_each_value(*node, [&](const toml::node& value) { values.push_back(value_text(value)); });
  return values;
}

std::vector<double> Settings::numbers(std::string_view key) const {
  const toml::node* node = state_->find(key);
  std::vector<double> values;
  if (node != nullptr) for_each_value(*node, [&](const toml::node& value) { values.push_back(value.value_or(0.0)); });
  return values;
}

std::map<std::string, std::string> Settings::notes(std::string_view key) const {
  const toml::node* node = state_->find(key);
  std::map<std::string, std::string> values;
  if (node != nullptr && node->is_table())
    for (const auto& [name, value] : *node->as_table()) values[std::string(name.str())] = value_text(value);
  return values;
}

Settings Settings::table(std::string_view key) const {
  static const toml::table nothing;
  const toml::node* node = state_->find(key);
  const bool there = node != nullptr && node->is_table();
  return Settings(state_->of(state_->table.inner(key, there ? node->as_table() : &nothing)));
}

std::vector<Settings> Settings::tables(std::string_view key) const {
  const toml::node* node = state_->find(key);
  std::vector<Settings> children;
  if (node == nullptr || !node->is_array()) return children;
  for (std::size_t i = 0; i < node->as_array()->size(); ++i) {
    const SettingsTable element = state_->table.element(key, i, node->as_array()->get(i)->as_table());
    if (!state_->document->wrong.contains(element.path)) children.push_back(Settings(state_->of(element)));
  }
  return children;
}

bool Settings::has(std::string_view key) const {
  return state_->table.node->get(key) != nullptr;
}

bool Settings::is_text(std::string_view key) const {
  const toml::node* node = state_->find(key);
  return node != nullptr && node->is_string();
}

void Settings::exclusive(std::string_view key, std::string_view other) const {
  if (has(key) && has(other))
    throw fault(other, "config.range", fmt::format("cannot be given beside '{}': give one", key));
}

std::string Settings::place(std::string_view key) const {
  return state_->document->place(state_->table, key);
}

Fault Settings::fault(std::string_view key, std::string name, std::string_view what) const {
  return state_->document->fault(state_->table, key, std::move(name), what);
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

std::string toml_value(double value) {
  const std::string text = fmt::format("{}", value);
  return text.find_first_of(".einf") == std::string::npos ? text + ".0" : text;
}

std::string toml_value(int value) {
  return fmt::format("{}", value);
}

std::string toml_value(bool value) {
  return value ? "true" : "false";
}

std::string toml_value(const std::string& text) {
  return toml_quoted(text);
}

std::string toml_value(const std::filesystem::path& path) {
  return toml_quoted(path.generic_string());
}

std::string toml_value(const std::vector<std::string>& texts) {
  std::vector<std::string> quoted;
  for (const std::string& text : texts) quoted.push_back(toml_quoted(text));
  return fmt::format("[{}]", fmt::join(quoted, ", "));
}

std::string toml_value(const std::optional<double>& value) {
  return value ? toml_value(*value) : "";
}

}  // namespace dsp
