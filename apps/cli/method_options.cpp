#include "apps/cli/method_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <stdexcept>

#include "apps/cli/option_values.hpp"
#include "dsp/fault.hpp"

namespace apps {
namespace {

using SharedArguments = std::shared_ptr<MethodArguments>;

/// --ridge-lambda for the setting ridge_lambda.
void add_setting(CLI::App& command, const ident::MethodSetting& setting, const SharedArguments& arguments) {
  std::string name = fmt::format("--{}", setting.name);
  std::replace(name.begin(), name.end(), '_', '-');
  const double preset = arguments->settings.value(setting.name);
  if (setting.words.empty()) {
    auto* option = command.add_option_function<double>(
        name, [&setting, arguments](double value) { arguments->settings.set(setting.name, value); },
        std::string(setting.help));
    option->check(setting.may_be_zero ? not_negative() : CLI::Validator(CLI::PositiveNumber));
    if (preset >= 0.0) option->default_str(fmt::format("{}", preset));
    return;
  }
  command
      .add_option_function<std::string>(
          name,
          [&setting, arguments](const std::string& word) {
            arguments->settings.set(setting.name, setting.index_of(word));
          },
          std::string(setting.help))
      ->check(CLI::IsMember(std::vector<std::string>(setting.words.begin(), setting.words.end())))
      ->default_str(std::string(setting.words[static_cast<std::size_t>(preset)]));
}

}  // namespace

SharedArguments add_method_options(CLI::App& command) {
  auto arguments = std::make_shared<MethodArguments>();
  std::vector<std::string_view> names;
  std::string words = "Methods:";
  for (const ident::MethodDescription& method : ident::methods()) {
    names.push_back(method.name);
    words += fmt::format("\n  {:<10} {}", method.name, method.help);
  }
  command.footer(words);
  command
      .add_option("--methods", arguments->names,
                  fmt::format("One or several, commas between: {}", fmt::join(names, ",")))
      ->type_name("NAME[,NAME]")
      ->delimiter(',')
      ->allow_extra_args(false);
  for (const ident::MethodSetting& setting : ident::method_settings()) add_setting(command, setting, arguments);
  command.add_flag_callback(
      "--raw-threshold",
      [arguments] {
        arguments->settings.set("threshold_on", ident::find_method_setting("threshold_on")->index_of("raw"));
      },
      "The same as --threshold-on raw");
  return arguments;
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
  return arguments.settings.options_of(methods.empty() ? ident::default_methods() : methods);
}

}  // namespace apps
