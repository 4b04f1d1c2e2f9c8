#include <fmt/format.h>

#include "apps/cli/command.hpp"
#include "apps/output/results_json.hpp"
#include "dsp/signals.hpp"

namespace apps {
namespace {

/// Of a body, or of signals that are no motion, each by itself; further channels last.
std::vector<ident::FunctionHelp> signal_help() {
  std::vector<ident::FunctionHelp> help;
  for (const dsp::Body body : {dsp::Body::relative, dsp::Body::base, dsp::Body::payload}) {
    std::string names;
    for (int order = 0; order < 3; ++order)
      names.append(order > 0 ? " " : "").append(dsp::motion_signal(body, order).name);
    help.push_back({names, std::string(dsp::motion_signal(body, 0).meaning) + ", its velocity and acceleration"});
  }
  for (const dsp::SignalInfo& signal : dsp::signal_table())
    if (signal.body == dsp::Body::none && signal.role != dsp::Role::other)
      help.push_back({std::string(signal.name), std::string(signal.meaning)});
  help.push_back({"NAME", std::string(dsp::info_of(dsp::Role::other).meaning)});
  return help;
}

void terms(Console& console) {
  const std::vector<ident::FunctionHelp> signals = signal_help();
  const std::vector<ident::FunctionHelp> functions = ident::expression_functions();
  if (console.json()) return console.result(terms_json(signals, functions));
  std::string text = "signals (those that the recording has or that follow from what it has)\n";
  for (const ident::FunctionHelp& signal : signals) text += fmt::format("  {:<10} {}\n", signal.name, signal.meaning);
  text += "functions and operators\n";
  for (const ident::FunctionHelp& function : functions)
    text += fmt::format("  {:<10} {}\n", function.name, function.meaning);
  console.result(text + "examples: 1  x^3  x^2*v  sgn(v)  abs(x)*v  ddr; where = \"abs(v) > 0.004 && t < 830\"\n");
}

}  // namespace

Command terms_command() {
  return {"terms",
          "Names and functions allowed in candidate terms",
          {{"--output"}, {"--seed"}, {"--dry-run"}, {"--set"}},
          [](CLI::App&) -> CommandBody {
            return [](const GlobalOptions&, Console& console) {
              terms(console);
              return 0;
            };
          }};
}

}  // namespace apps
