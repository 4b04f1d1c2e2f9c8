#include "apps/cli/method_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <stdexcept>

#include "dsp/values/fault.hpp"

namespace apps {
namespace {

/// --ridge-lambda for the setting ridge_lambda.
Option setting_option(const ident::MethodSetting& setting, ident::MethodSettings& settings) {
  std::string name = fmt::format("--{}", setting.name);
  std::replace(name.begin(), name.end(), '_', '-');
  const double preset = settings.value(setting.name);
  const auto take = [&setting, &settings](const std::string& text) {
    settings.set(setting.name, setting.words.empty() ? std::stod(text) : setting.index_of(text));
  };
  Option option{std::move(name), take, std::string(setting.help)};
  OptionValue& value = option.value;
  value.words.assign(setting.words.begin(), setting.words.end());
  if (!setting.words.empty()) {
    value.preset = value.words[static_cast<std::size_t>(preset)];
    return option;
  }
  value.name = "NUMBER";
  value.check = setting.may_be_zero ? non_negative_number() : positive_number();
  if (preset >= 0.0) value.preset = fmt::format("{}", preset);
  return option;
}

}  // namespace

std::vector<Option> method_options(MethodArguments& typed) {
  std::vector<std::string_view> names;
  for (const ident::MethodDescription& method : ident::methods()) names.push_back(method.name);
  std::vector<Option> options{{"--methods",
                               &typed.names,
                               fmt::format("One or several, commas between: {}", fmt::join(names, ",")),
                               {.name = "NAME[,NAME]", .by_commas = true}}};
  for (const ident::MethodSetting& setting : ident::method_settings())
    options.push_back(setting_option(setting, typed.settings));
  options.push_back({"--raw-threshold", &typed.raw_threshold, "The same as --threshold-on raw"});
  return options;
}

std::vector<std::string> methods_help() {
  std::vector<std::string> lines{"Methods:"};
  for (const ident::MethodDescription& method : ident::methods())
    lines.push_back(fmt::format("  {:<10} {}", method.name, method.help));
  return lines;
}

std::vector<ident::MethodOptions> options_of(const MethodArguments& arguments) {
  std::vector<ident::Method> methods;
  for (const std::string& name : arguments.names) {
    try {
      methods.push_back(ident::method_named(name).method);
    } catch (const std::invalid_argument& error) {
      throw dsp::Fault(dsp::FaultKind::usage, "fit.method", fmt::format("--methods: {}.", error.what()));
    }
  }
  ident::MethodSettings settings = arguments.settings;
  if (arguments.raw_threshold)
    settings.set("threshold_on", ident::find_method_setting("threshold_on")->index_of("raw"));
  return settings.options_of(methods.empty() ? ident::default_methods() : methods);
}

}  // namespace apps
