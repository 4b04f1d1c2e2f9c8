#pragma once
#include <algorithm>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "dsp/io/settings.hpp"

namespace dsp {

/// A setting and where a Target keeps its value: a row of the table by which documents are checked, read, written and
/// explained. Its default is what Target{} has. A heading, whose type is a section or elements, goes before its rows.
template <class Target>
struct BoundSetting : Setting {
  using Read = std::function<void(const Settings& table, const std::string& key, Target&)>;
  using Write = std::function<std::string(const Target&)>;
  Read read = {};    ///< none: read together with others
  Write write = {};  ///< as TOML; none, or empty: it is not written

  static BoundSetting custom(std::string key, SettingType type, std::string meaning, std::string unit,
                             std::string left_out, Read read, Write write = {}) {
    return {{.key = std::move(key),
             .type = std::move(type),
             .meaning = std::move(meaning),
             .unit = std::move(unit),
             .left_out = std::move(left_out)},
            std::move(read),
            std::move(write)};
  }

  template <class Member>
  using ValueOf = std::remove_cvref_t<std::invoke_result_t<Member, Target&>>;

  /// A member, or what gives a reference to a part of one, that is a double, an int, a bool, a text, a path, texts, or
  /// an optional number. It is written unless it has its default, of which `left_out` says what it means.
  template <class Member>
  static BoundSetting of(std::string key, Member member, SettingType type, std::string meaning, std::string unit = "",
                         std::string left_out = "") {
    using Value = ValueOf<Member>;
    type.several = std::is_same_v<Value, std::vector<std::string>>;
    type.number = std::is_same_v<Value, double> || std::is_same_v<Value, std::optional<double>>;
    type.whole_number = std::is_same_v<Value, int>;
    type.flag = std::is_same_v<Value, bool>;
    type.text = !(type.number || type.whole_number || type.flag || type.date);
    const auto read = [member](const Settings& table, const std::string& name, Target& target) {
      Value& value = std::invoke(member, target);
      if constexpr (std::is_same_v<Value, std::vector<std::string>>)
        value = table.texts(name).value_or(value);
      else if constexpr (std::is_same_v<Value, bool>)
        value = table.text(name).value_or(value ? "true" : "") == "true";
      else if constexpr (std::is_arithmetic_v<Value> || std::is_same_v<Value, std::optional<double>>)
        value = table.number(name) ? static_cast<Value>(*table.number(name)) : value;
      else
        value = table.text(name) ? Value(*table.text(name)) : value;
    };
    return custom(std::move(key), std::move(type), std::move(meaning), std::move(unit), std::move(left_out), read)
        .kept(member, [](const Value& value) { return toml_value(value); });
  }

  /// The same of a member that has a word for each of its values.
  template <class Member>
  static BoundSetting choice(std::string key, Member member,
                             const std::vector<std::pair<std::string, ValueOf<Member>>>& values, std::string meaning,
                             std::string left_out = "") {
    SettingType type{.text = true};
    for (const auto& [word, value] : values) type.words.push_back(word);
    const auto read = [=](const Settings& table, const std::string& name, Target& target) {
      for (const auto& [word, value] : values)
        if (table.text(name) == word) std::invoke(member, target) = value;
    };
    return custom(std::move(key), std::move(type), std::move(meaning), "", std::move(left_out), read)
        .kept(member, [values](const ValueOf<Member>& value) {
          const auto is = [&](const auto& known) { return known.second == value; };
          return toml_value(std::find_if(values.begin(), values.end(), is)->first);
        });
  }

  BoundSetting needed() && {
    required = true;
    fallback.clear();
    return std::move(*this);
  }
  BoundSetting varied() && {
    is_varied = true;
    return std::move(*this);
  }

 private:
  template <class Member, class Text>
  BoundSetting kept(Member member, const Text& text) && {
    Target preset{};
    const bool stated = left_out.empty();
    if (stated) fallback = text(std::invoke(member, preset));
    write = [=](const Target& target) {
      const auto& value = std::invoke(member, target);
      return stated || value != std::invoke(member, preset) ? text(value) : std::string();
    };
    return std::move(*this);
  }
};

template <class Target>
using SettingRows = std::vector<BoundSetting<Target>>;

/// Adds rows, each to the table of the heading before it, or to `table`.
template <class Row, class Rows>
void add_rows(std::vector<Row>& all, const Rows& rows, std::string table = "") {
  for (const auto& row : rows) {
    if (row.is_heading()) table = row.key;
    all.emplace_back(row).table = row.is_heading() ? "" : table;
  }
}

/// From a table, or an element, that has these keys. What is wrong is kept for Settings::finish.
template <class Target>
void read_rows(const SettingRows<Target>& rows, const Settings& table, Target& target) {
  for (const BoundSetting<Target>& row : rows)
    if (row.read) table.attempt([&] { row.read(table, row.key, target); });
}

/// Headings with lines `key = value` below, where there are any.
template <class Target>
std::string written(const SettingRows<Target>& rows, const Target& target) {
  std::string text, heading;
  for (const BoundSetting<Target>& row : rows) {
    if (row.is_heading()) heading = (row.type.elements ? "\n[[" + row.key + "]]\n" : "\n[" + row.key + "]\n");
    const std::string value = row.write ? row.write(target) : "";
    if (!value.empty()) text += std::exchange(heading, "") + row.key + " = " + value + "\n";
  }
  return text;
}

}  // namespace dsp
