#pragma once
#include <memory>
#include <string>
#include <vector>

#include "apps/cli/command.hpp"
#include "ident/methods.hpp"

namespace apps {

/// --methods and the settings of all methods, as they were typed.
struct MethodArguments {
  std::vector<std::string> names;  ///< empty: ident::default_methods
  ident::MethodSettings settings;
};

/// One option for each setting of the methods' table, and a footer that describes the methods.
[[nodiscard]] std::shared_ptr<MethodArguments> add_method_options(CLI::App& command);

/// Throws dsp::Fault (usage, "fit.method") for a method there is none of.
[[nodiscard]] std::vector<ident::MethodOptions> options_of(const MethodArguments& arguments);

}  // namespace apps
