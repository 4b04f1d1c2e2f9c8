#include "dsp/io/array_labels.hpp"

#include <algorithm>
#include <array>
#include <optional>

#include "dsp/io/table_header.hpp"
#include "dsp/io/units.hpp"
#include "dsp/values/names.hpp"

namespace dsp {
namespace {

template <std::size_t N>
bool is_one_of(std::string_view word, const std::array<std::string_view, N>& words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

// What keys call a unit, a name, the numbers themselves, and what stands about the record.
constexpr std::array<std::string_view, 5> unit_keys{"unit", "units", "einheit", "einheiten", "unidad"};
constexpr std::array<std::string_view, 4> name_keys{"name", "label", "channel", "title"};
constexpr std::array<std::string_view, 18> list_keys{
    "name",    "names", "label",  "labels", "channel", "channels",  "column",   "columns", "header",
    "headers", "field", "fields", "signal", "signals", "variables", "variable", "titles",  "legend"};
constexpr std::array<std::string_view, 4> value_keys{"values", "value", "data", "samples"};
constexpr std::array<std::string_view, 8> about_keys{"meta",  "metadata",   "info",       "header",
                                                     "attrs", "properties", "attributes", "settings"};

bool are_units(const std::vector<std::string>& texts) {
  return std::any_of(texts.begin(), texts.end(), [](const std::string& one) { return is_unit(one); }) &&
         std::all_of(texts.begin(), texts.end(),
                     [](const std::string& one) { return is_unit(one) || is_no_unit(one); });
}

// Of lists of `width` texts that pass, the one in the array's group, else the only one.
template <class Test>
const FileArray* list_beside(const std::vector<const FileArray*>& lists, const FileArray& array, std::size_t width,
                             Test&& test) {
  const FileArray* found = nullptr;
  int num_elsewhere = 0;
  for (const FileArray* one : lists) {
    if (one->texts.size() != width || !test(*one)) continue;
    if (one->group == array.group || one->group == array.group + array.name + "/") return one;
    found = one;
    ++num_elsewhere;
  }
  return num_elsewhere == 1 ? found : nullptr;
}

// The words of a unit's key without those that say that it is one; nothing where it does not.
std::optional<std::vector<std::string>> what_has_unit(const FileArray& text) {
  std::vector<std::string> words = words_of_key(text.group + text.name);
  if (std::erase_if(words, [](const std::string& word) { return is_one_of(word, unit_keys); }) == 0)
    return std::nullopt;
  std::erase_if(words, [](const std::string& word) { return is_one_of(word, about_keys); });
  return words;
}

bool names_values(const FileArray& array) {
  return is_one_of(lower(array.name), value_keys);
}

}  // namespace

bool is_no_unit(std::string_view text) {
  constexpr std::array<std::string_view, 5> none{"", "-", "none", "n/a", "null"};
  return is_one_of(lower(text), none);
}

std::string name_of_values(const FileArray& array) {
  if (!names_values(array) || array.group.empty()) return "";
  const std::string group = array.group.substr(0, array.group.size() - 1);
  return group.substr(group.find_last_of("./") + 1);  // npos + 1 is 0
}

ArrayLabels::ArrayLabels(const std::vector<FileArray>& arrays) {
  for (const FileArray& one : arrays) {
    if (one.texts.size() > 1) lists_.push_back(&one);
    if (one.texts.size() != 1) continue;
    texts_.push_back(&one);
    if (is_no_unit(one.texts.front())) continue;
    if (const auto words = what_has_unit(one)) units_.emplace(*words, &one);
  }
}

const FileArray* ArrayLabels::names_beside(const FileArray& array, std::size_t width) const& {
  const auto names_columns = [](const FileArray& one) {
    const std::vector<std::string> words = words_of_key(one.name);
    return !are_units(one.texts) &&
           std::any_of(words.begin(), words.end(), [](const std::string& word) { return is_one_of(word, list_keys); });
  };
  if (width > 1) return list_beside(lists_, array, width, names_columns);
  if (!names_values(array)) return nullptr;
  const FileArray* found = nullptr;
  for (const FileArray* one : texts_)
    if (one->group == array.group && is_one_of(lower(one->name), name_keys)) {
      if (found != nullptr) return nullptr;
      found = one;
    }
  return found;
}

const FileArray* ArrayLabels::units_beside(const FileArray& array, std::size_t width) const& {
  if (width > 1) return list_beside(lists_, array, width, [](const FileArray& one) { return are_units(one.texts); });
  std::vector<std::string> path = words_of_key(array.group + array.name);
  if (names_values(array)) path.pop_back();
  auto found = units_.find(path);
  if (found == units_.end() && !names_values(array)) found = units_.find(words_of_key(array.name));
  return found == units_.end() ? nullptr : found->second;
}

}  // namespace dsp
