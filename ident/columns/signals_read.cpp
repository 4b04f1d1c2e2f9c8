#include "ident/columns/signals_read.hpp"

#include <algorithm>
#include <string>
#include <vector>

namespace ident {
namespace {

bool reads(const Expression& expression, const std::string& name) {
  const std::vector<std::string>& own = expression.signals();
  const std::vector<Switch> switches = expression.all_switches();
  return std::find(own.begin(), own.end(), name) != own.end() ||
         std::any_of(switches.begin(), switches.end(), [&](const Switch& one) { return reads(one.argument, name); });
}

}  // namespace

void free_signals_read(dsp::Prepared& prepared, const CandidateLibrary& library, const std::string& target) {
  if (target == "y" || std::any_of(library.terms.begin(), library.terms.end(),
                                   [](const Term& term) { return reads(term.expression, "y"); }))
    return;
  for (dsp::Signal& signal : prepared.intermediate.signals)
    if (signal.name == "y") signal.values.resize(0);
}

}  // namespace ident
