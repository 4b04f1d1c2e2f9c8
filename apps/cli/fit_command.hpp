#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "apps/process/console.hpp"
#include "ident/methods.hpp"

namespace apps {

/// `ardent fit TABLE.csv --target NAME --terms FILE|LIST ...` as it was typed.
struct FitArguments {
  std::filesystem::path table;
  std::string target;
  std::string terms;                 ///< "1,x,x^2", or a file with one term a line (# begins a comment)
  std::vector<std::string> methods;  ///< empty: ident::default_methods
  ident::MethodSettings settings;
  std::string where;  ///< condition on the rows
  int num_threads = 1;
  bool strict = false;
};

/// Regression of one column of a table on expressions of the others, all rows at once, printed. Column names that are
/// no names become some ("force [kN]" -> force_kN). Returns the exit code: 4 if no method selected anything, or the
/// rows determine none of the fits. Throws dsp::Fault.
int run_fit(const FitArguments& arguments, Console& console);

/// Terms separated by commas outside brackets. Throws dsp::Fault (usage, "term.syntax") for an empty one.
[[nodiscard]] std::vector<std::string> split_terms(const std::string& list);

}  // namespace apps
