#include "dsp/io/toml_values.hpp"

#include <fmt/format.h>

#include <sstream>

#include "dsp/io/settings_document.hpp"

namespace dsp {
namespace {

void gather(const toml::node& node, const std::string& path, std::map<std::string, std::string>& values) {
  if (const auto* table = node.as_table()) {
    for (const auto& [name, inner] : *table) gather(inner, key_path(path, name.str()), values);
    return;
  }
  const auto* array = node.as_array();
  if (array != nullptr && !array->empty() && array->front().is_table()) {
    for (std::size_t i = 0; i < array->size(); ++i) gather(*array->get(i), key_path(path, std::to_string(i)), values);
    return;
  }
  if (const auto* number = node.as_floating_point()) {
    values[path] = fmt::format("{}", number->get());  // to as few digits as give it back
    return;
  }
  std::ostringstream text;
  node.visit([&](const auto& value) { text << value; });
  values[path] = text.str();
}

}  // namespace

std::map<std::string, std::string> toml_values(std::string_view text, const std::string& name) {
  std::map<std::string, std::string> values;
  gather(parse_toml(text, name), "", values);
  return values;
}

}  // namespace dsp
