#pragma once
#include <string>
#include <vector>

#include "apps/cli/command.hpp"
#include "ident/regression/methods.hpp"

namespace apps {

/// --methods and the settings of all methods, as they were typed.
struct MethodArguments {
  std::vector<std::string> names;  ///< empty: ident::default_methods
  ident::MethodSettings settings;
  bool raw_threshold = false;
};

/// --methods, and one option for each setting of the methods' table.
[[nodiscard]] std::vector<Option> method_options(MethodArguments& typed);
/// Lines that describe the methods, below these options.
[[nodiscard]] std::vector<std::string> methods_help();

/// Throws dsp::Fault (usage, "fit.method") for a method there is none of.
[[nodiscard]] std::vector<ident::MethodOptions> options_of(const MethodArguments& arguments);

}  // namespace apps
