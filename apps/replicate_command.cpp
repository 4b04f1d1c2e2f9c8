#include "apps/replicate_command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

#include "apps/atomic_file.hpp"
#include "apps/interrupt.hpp"
#include "apps/replicate_output.hpp"
#include "apps/system_fault.hpp"

namespace apps {
namespace {

namespace fs = std::filesystem;

/// What is wanted of a case.
struct Wanted {
  const Section4Case* definition = nullptr;
  bool table = false, figure = false;
};

[[noreturn]] void refuse(const char* name, const std::string& text) {
  throw dsp::Fault(dsp::FaultKind::usage, name, "replicate: " + text);
}

std::vector<Wanted> wanted_of(const std::vector<std::string>& items) {
  std::vector<Wanted> wanted;
  for (const Section4Case& known : section4_cases()) wanted.push_back({&known, false, false});
  for (const std::string& item : items) {
    bool known = false;
    for (Wanted& one : wanted) {
      const bool whole = item == "all" || item == one.definition->name;
      const bool table = whole || item == fmt::format("table-{}", one.definition->table);
      const bool figure = whole || item == fmt::format("fig-{}", one.definition->figure);
      one.table |= table;
      one.figure |= figure;
      known |= table || figure;
    }
    if (known) continue;
    std::vector<std::string> names;
    for (const Section4Case& one : section4_cases()) names.push_back(one.name);
    refuse("replicate.item", fmt::format("'{}' is not known; there are table-1 to table-8, fig-2 to fig-9, {}, all",
                                         item, fmt::join(names, ", ")));
  }
  std::erase_if(wanted, [](const Wanted& one) { return !one.table && !one.figure; });
  if (wanted.empty()) refuse("replicate.item", "nothing to do; name a table, a figure, a case, or all");
  return wanted;
}

ReplicateOptions options_of(const ReplicateArguments& arguments) {
  if (arguments.num_seeds < 1)
    refuse("replicate.seeds", fmt::format("--seeds {}, want 1 or more", arguments.num_seeds));
  if (!(arguments.noise >= 0.0) || !std::isfinite(arguments.noise))
    refuse("replicate.noise", fmt::format("--noise {}, want 0 or more", arguments.noise));
  ReplicateOptions options{arguments.num_seeds, arguments.first_seed, arguments.noise};
  if (arguments.selection == "type2")
    options.selection = ident::Selection::type2;
  else if (arguments.selection != "evidence")
    refuse("replicate.selection", fmt::format("--selection '{}', want evidence or type2", arguments.selection));
  if (arguments.tau && !(*arguments.tau >= 0.0 && std::isfinite(*arguments.tau)))
    refuse("replicate.tau", fmt::format("--tau {}, want 0 or more", *arguments.tau));
  options.tau = arguments.tau.value_or(-1.0);
  return options;
}

// One line a case: how often every row was right, and how many printed numbers agree.
std::string summary_of(const ReplicatedCase& replicated, int num_seeds) {
  const CaseReplication& replication = replicated.replication;
  int exact = 0, known = 0, agree = 0, judged = 0;
  for (const CaseFit& fit : replication.fits)
    if (fit.method == "fast_rvm" && replication.row_of(fit).truth_known) exact += fit.error.exact(), ++known;
  for (const Comparison& c : replicated.comparisons)
    if (c.quantity == "mean") agree += c.verdict.verdict == "within noise", ++judged;
  return fmt::format("{:<11} rows right {}/{} over {} seed{}, printed coefficients within noise {}/{}\n",
                     replication.study.definition->name, exact, known, num_seeds, num_seeds == 1 ? "" : "s", agree,
                     judged);
}

}  // namespace

void run_replicate(const ReplicateArguments& arguments, Console& console) {
  const ReplicateOptions options = options_of(arguments);
  const auto wanted = wanted_of(arguments.items);
  std::error_code error;
  fs::create_directories(arguments.folder, error);
  if (error) throw cannot_write(arguments.folder, error.value());

  std::vector<ReplicatedCase> cases;
  std::string summary;
  for (const Wanted& one : wanted) {
    const std::string& name = one.definition->name;
    console.step(name);
    CaseReplication replication = replicate_case(*one.definition, options, [&](double share) {
      check_interrupted();
      console.progress(name, share);
    });
    auto comparisons = compare_with_paper(replication);
    cases.push_back({std::move(replication), std::move(comparisons)});
    if (one.table)
      write_file(arguments.folder / fmt::format("table-{}.txt", one.definition->table),
                 replicate_table(cases.back(), options));
    if (one.figure)
      write_file(arguments.folder / fmt::format("fig-{}.svg", one.definition->figure), replicate_figure(cases.back()));
    summary += summary_of(cases.back(), options.num_seeds);
  }
  const std::string document = replicate_json(cases, options);
  write_file(arguments.folder / "replicate.json", document);
  console.result(console.json() ? document : summary);
}

}  // namespace apps
