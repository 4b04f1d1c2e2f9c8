#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "dsp/io/settings.hpp"
#include "dsp/io/settings_document.hpp"
#include "dsp/values/names.hpp"

namespace dsp {
namespace {

std::string described(const toml::node& node) {
  if (node.is_string()) return fmt::format("the text '{}'", clean_name(value_text(node)));
  if (const auto* number = node.as_floating_point()) return toml_value(number->get());
  return node.is_array() ? "an array" : node.is_table() ? "a table" : value_text(node);
}

std::string described(const NumberRange& range) {
  const bool low = std::isfinite(range.from), high = std::isfinite(range.to);
  if (low && high) return fmt::format("{}{} to {}", range.above ? "above " : "", range.from, range.to);
  if (low) return fmt::format("{} {}", range.above ? "above" : "at least", range.from);
  return high ? fmt::format("at most {}", range.to) : "finite";
}

/// What is wanted of a value that is no text.
std::string wanted(const SettingType& type) {
  if (type.whole_number) return fmt::format("a whole number, {}", described(type.range));
  if (type.number) return fmt::format("a number, {}", described(type.range));
  if (type.flag) return "true or false";
  if (type.date) return "a date such as 2023-05-04T10:12:30Z";
  const std::string example = type.example.empty() ? "" : fmt::format(" such as {}", type.example);
  return type.table ? "a table" + example
                    : fmt::format("a text in quotes{}{}", example, type.several ? ", or an array of them" : "");
}

bool has_type(const toml::node& node, const SettingType& type) {
  if (node.is_string() && (type.text || type.date)) return true;
  if (type.whole_number) return node.is_integer();
  if (type.number) return node.is_number();
  if (type.flag) return node.is_boolean();
  if (type.date) return node.is_date() || node.is_time() || node.is_date_time();
  return type.table && node.is_table();
}

/// A document on its way through its layout.
class LayoutCheck {
 public:
  LayoutCheck(SettingsDocument& document, const std::vector<Setting>& layout) : document_(document) {
    for (const Setting& setting : layout) layout_[setting.table].push_back(&setting);
  }

  void check_table(const SettingsTable& table) {
    const std::vector<const Setting*>& settings = layout_[table.name];
    for (const Setting* setting : settings) {
      if (document_.faults.attempt([&] { check_key(table, *setting); })) continue;
      document_.wrong.insert(key_path(table.path, setting->key));
      if (setting->required) document_.wrong.insert(table.path);
    }
    for (const auto& [name, node] : *table.node) {
      if (document_.unknown.is_full()) return;
      const std::string key(name.str());
      if (std::none_of(settings.begin(), settings.end(), [&](const Setting* one) { return one->key == key; }))
        add_unknown(node, table, key);
    }
  }

  void check_key(const SettingsTable& table, const Setting& setting) {
    const auto refuse = [&](std::string name, const std::string& what) {
      throw document_.fault(table, setting.key, std::move(name), what);
    };
    const SettingType& type = setting.type;
    const std::string path = key_path(table.path, setting.key);
    const toml::node* node = table.node->get(setting.key);
    if (node == nullptr && setting.required) refuse("config.missing", "missing; want " + wanted(type));
    if (node == nullptr) return;
    if (!setting.former.empty()) refuse("config.former_key", "is no key any more. " + setting.former);
    if (type.elements) {
      const std::string want = fmt::format("tables, each under [[{}]]", path);
      if (!node->is_array()) refuse("config.type", fmt::format("got {}, want {}", described(*node), want));
      for_each_value(*node, [&](const toml::node& element) {
        if (!element.is_table()) refuse("config.type", fmt::format("got {}, want {}", described(element), want));
      });
      for (std::size_t i = 0; i < node->as_array()->size(); ++i)
        check_table(table.element(setting.key, i, node->as_array()->get(i)->as_table()));
    } else if (node->is_table() && (type.section || layout_.contains(key_path(table.name, setting.key)))) {
      check_table(table.inner(setting.key, node->as_table()));
    } else if (type.section) {
      refuse("config.type", fmt::format("got {}, want a table [{}]", described(*node), path));
    } else if (node->is_array() && type.several) {
      SettingType of_element = type;
      of_element.text = type.text && !type.number;  // beside numbers, a text stands alone
      for_each_value(*node, [&](const toml::node& element) { check_value(element, of_element, refuse); });
    } else {
      check_value(*node, type, refuse);
    }
  }

 private:
  template <class Refuse>
  void check_value(const toml::node& node, const SettingType& type, const Refuse& refuse) {
    if (!has_type(node, type)) refuse("config.type", fmt::format("got {}, want {}", described(node), wanted(type)));
    if (node.is_number() && !contains(type.range, *node.value<double>()))
      refuse("config.range", fmt::format("got {}, want a number, {}", *node.value<double>(), described(type.range)));
    const auto text = node.value_exact<std::string>();
    if (!text || type.words.empty() || std::count(type.words.begin(), type.words.end(), *text) > 0) return;
    const std::string near = nearest(*text, type.words);
    refuse("config.range", fmt::format("got '{}', want one of {}{}", clean_name(*text), fmt::join(type.words, ", "),
                                       near.empty() ? "" : fmt::format(". Did you mean '{}'?", near)));
  }

  void add_unknown(const toml::node& node, const SettingsTable& table, const std::string& key) {
    const std::string path = key_path(table.path, key);
    const auto line = node.source().begin.line;
    std::string place = line > 0 ? fmt::format("{}:{}", document_.name, line) : document_.name;
    std::string shown = table.shown + key;
    for (const auto& [set_path, text] : document_.overrides)
      if (set_path == path || set_path.starts_with(path + ".") || path.starts_with(set_path + "."))
        place = text, shown = path;
    document_.unknown.add(
        Fault(FaultKind::usage, "config.unknown_key",
              fmt::format("{}: unknown key '{}'. {}", place, clean_name(shown), advice(table.name, clean_name(key)))));
  }

  /// Where a key that is unknown in `table` is known, as a person writes that place; else the nearest that is.
  std::string advice(const std::string& table, const std::string& key) {
    std::vector<std::string> known;
    for (const Setting* own : layout_[table])
      if (own->former.empty()) known.push_back(own->key);
    std::sort(known.begin(), known.end());
    const std::string here = fmt::format("Known here: {}", fmt::join(known, ", "));
    for (const auto& [path, settings] : layout_) {
      const std::string& other = path;                     // what clang lets a lambda capture
      if (other.find('.') != std::string::npos) continue;  // of which element is not known
      if (std::none_of(settings.begin(), settings.end(), [&](const Setting* one) { return one->key == key; })) continue;
      const std::vector<const Setting*>& top = layout_[""];
      const bool elements = std::any_of(top.begin(), top.end(),
                                        [&](const Setting* one) { return one->type.elements && one->key == other; });
      const std::string place = other.empty() ? "the top of the file, above the first [table]"
                                : elements    ? fmt::format("[[{}]]", other)
                                              : fmt::format("[{}]", other);
      return fmt::format("It is a key of {}, on a command line --set {}=VALUE. {}", place,
                         elements ? fmt::format("{}.0.{}", other, key) : key_path(other, key), here);
    }
    const std::string near = nearest(key, known);
    return near.empty() ? here : fmt::format("Did you mean '{}'?", near);
  }

  SettingsDocument& document_;
  std::map<std::string, std::vector<const Setting*>> layout_;
};

}  // namespace

bool contains(const NumberRange& range, double value) {
  return std::isfinite(value) && value <= range.to && (range.above ? value > range.from : value >= range.from);
}

Setting schema_setting(int version) {
  return {.key = "schema",
          .type = {.whole_number = true, .range = {.from = 1}},
          .meaning = "Version of this layout of the file.",
          .fallback = std::to_string(version)};
}

void check_document(SettingsDocument& document, const std::vector<Setting>& layout, int schema) {
  const SettingsTable root{&document.root};
  LayoutCheck(document, {}).check_key(root, schema_setting(schema));
  const std::int64_t found = document.root["schema"].value_or(schema);
  if (found != schema)
    throw document.fault(root, "schema", "config.schema",
                         fmt::format("got {}, this program reads {}. {}", found, schema,
                                     found > schema ? fmt::format("A newer version of ardent reads schema {}", found)
                                                    : fmt::format("Write it again for schema {}", schema)));
  LayoutCheck(document, layout).check_table(root);
}

}  // namespace dsp
