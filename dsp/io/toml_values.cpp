#include "dsp/io/toml_values.hpp"

#include "dsp/io/settings.hpp"
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
  values[path] = node.is_string() ? toml_quoted(value_text(node)) : value_text(node);
}

}  // namespace

std::map<std::string, std::string> toml_values(std::string_view text, const std::string& name) {
  std::map<std::string, std::string> values;
  gather(parse_toml(text, name), "", values);
  return values;
}

}  // namespace dsp
