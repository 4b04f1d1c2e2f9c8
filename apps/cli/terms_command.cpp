#include "apps/cli/terms_command.hpp"

#include <fmt/format.h>

#include "apps/output/results_json.hpp"

namespace apps {

void run_terms(Console& console) {
  const std::vector<ident::FunctionHelp> signals = {
      {"x v a", "displacement of the payload relative to the base, its velocity and acceleration"},
      {"r dr ddr", "displacement of the base, its velocity and acceleration"},
      {"y dy ddy", "displacement of the payload, absolute, its velocity and acceleration"},
      {"f", "measured force or input"},
      {"z", "hysteretic force"},
      {"t", "time from the start of the record, s"},
      {"NAME", "any further channel of the recording, by its own name"},
  };
  const std::vector<ident::FunctionHelp> functions = ident::expression_functions();
  if (console.json()) return console.result(terms_json(signals, functions));
  std::string text = "signals (those that the recording has or that follow from what it has)\n";
  for (const ident::FunctionHelp& signal : signals) text += fmt::format("  {:<10} {}\n", signal.name, signal.meaning);
  text += "functions and operators\n";
  for (const ident::FunctionHelp& function : functions)
    text += fmt::format("  {:<10} {}\n", function.name, function.meaning);
  console.result(text + "examples: 1  x^3  x^2*v  sgn(v)  abs(x)*v  ddr; where = \"abs(v) > 0.004 && t < 830\"\n");
}

}  // namespace apps
