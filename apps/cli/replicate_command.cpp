#include "apps/cli/replicate_command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/output/results_json.hpp"
#include "apps/paper/replicate_output.hpp"
#include "apps/paper/section5_output.hpp"
#include "apps/process/interrupt.hpp"
#include "apps/process/output_folder.hpp"

namespace apps {
namespace {

/// What is wanted of a case of Section 4.
struct Wanted {
  const Section4Case* definition = nullptr;
  bool table = false, figure = false;
};

/// What is wanted of Section 5.
struct WantedOfRig {
  std::vector<const Section5Case*> tables;
  bool errors = false, responses = false, states = false, identified = false;  ///< table-9, fig-11, fig-12, fig-13
  /// Table 9 and Figs. 12 and 13 need every regime.
  [[nodiscard]] std::vector<const Section5Case*> cases() const {
    if (!errors && !states && !identified) return tables;
    std::vector<const Section5Case*> all;
    for (const Section5Case& known : section5_cases()) all.push_back(&known);
    return all;
  }
};

struct Items {
  std::vector<Wanted> cases;
  WantedOfRig rig;
};

[[noreturn]] void refuse(const char* name, const std::string& text) {
  throw dsp::Fault(dsp::FaultKind::usage, name, "replicate: " + text);
}

bool want_case(std::vector<Wanted>& cases, const std::string& item) {
  bool known = false;
  for (Wanted& one : cases) {
    const bool whole = item == "all" || item == one.definition->name;
    const bool table = whole || item == fmt::format("table-{}", one.definition->table);
    const bool figure = whole || item == fmt::format("fig-{}", one.definition->figure);
    one.table |= table;
    one.figure |= figure;
    known |= table || figure;
  }
  return known;
}

bool want_rig(WantedOfRig& rig, const std::string& item) {
  const bool whole = item == "all" || item == "qzs";
  bool known = whole;
  for (const Section5Case& one : section5_cases()) {
    if (!whole && item != one.name && item != fmt::format("table-{}", one.table)) continue;
    if (std::find(rig.tables.begin(), rig.tables.end(), &one) == rig.tables.end()) rig.tables.push_back(&one);
    known = true;
  }
  for (const auto& [name, flag] : {std::pair{"table-9", &WantedOfRig::errors},
                                   {"fig-11", &WantedOfRig::responses},
                                   {"fig-12", &WantedOfRig::states},
                                   {"fig-13", &WantedOfRig::identified}})
    if (whole || item == name) rig.*flag = known = true;
  return known;
}

Items items_of(const std::vector<std::string>& names) {
  Items items;
  for (const Section4Case& known : section4_cases()) items.cases.push_back({&known, false, false});
  for (const std::string& name : names) {
    const bool of_section4 = want_case(items.cases, name), of_section5 = want_rig(items.rig, name);
    if (of_section4 || of_section5) continue;
    std::vector<std::string> known;
    for (const Section4Case& one : section4_cases()) known.push_back(one.name);
    for (const Section5Case& one : section5_cases()) known.push_back(one.name);
    refuse(
        "replicate.item",
        fmt::format("'{}' is not known; there are table-1 to table-12, fig-2 to fig-9, fig-11 to fig-13, {}, qzs, all",
                    name, fmt::join(known, ", ")));
  }
  std::erase_if(items.cases, [](const Wanted& one) { return !one.table && !one.figure; });
  if (names.empty()) refuse("replicate.item", "nothing to do; name a table, a figure, a case, or all");
  return items;
}

ReplicateOptions options_of(const ReplicateArguments& arguments) {
  constexpr double stated_noise = 0.1;
  if (arguments.num_seeds < 1)
    refuse("replicate.seeds", fmt::format("--seeds {}, want 1 or more", arguments.num_seeds));
  const double noise = arguments.noise.value_or(stated_noise);
  if (!(noise >= 0.0) || !std::isfinite(noise))
    refuse("replicate.noise", fmt::format("--noise {}, want 0 or more", noise));
  ReplicateOptions options{arguments.num_seeds, arguments.first_seed, noise};
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

// One line a regime: T1 by the paper's recipe beside the print, and by ours.
std::string summary_of(const Section5Replication& replication, const Section5Case& definition) {
  const auto errors = [&](std::size_t way) {
    return Section5View(replication, definition, section5_ways()[way], paper_candidates).errors("fast_rvm");
  };
  std::string text = fmt::format("{:<11} NMSE train/test", definition.name);
  for (const PaperErrors& paper : paper_errors())
    if (paper.table == definition.table) text += fmt::format(" paper {:.4f}/{:.4f}", paper.train[0], paper.test[0]);
  for (std::size_t way = 0; way < section5_ways().size(); ++way)
    text += fmt::format(", {} {:.2g}/{:.2g}", section5_ways()[way].name, errors(way).train, errors(way).test);
  return text + "\n";
}

/// Section 4: files, and the summary.
std::string replicate_cases(const std::vector<Wanted>& wanted, const ReplicateOptions& options,
                            const OutputFolder& folder, std::vector<ReplicatedCase>& cases, Console& console) {
  std::string summary;
  for (const Wanted& one : wanted) {
    const std::string& name = one.definition->name;
    console.step(name);
    CaseReplication replication = replicate_case(*one.definition, options, shown_progress(console, name));
    auto comparisons = compare_with_paper(replication);
    cases.push_back({std::move(replication), std::move(comparisons)});
    if (one.table)
      folder.write(fmt::format("table-{}.txt", one.definition->table), replicate_table(cases.back(), options));
    if (one.figure) folder.write(fmt::format("fig-{}.svg", one.definition->figure), replicate_figure(cases.back()));
    summary += summary_of(cases.back(), options.num_seeds);
  }
  return summary;
}

/// Section 5 likewise.
std::string replicate_rig(const WantedOfRig& wanted, const Section5Options& options, const OutputFolder& folder,
                          nlohmann::ordered_json& document, Console& console) {
  if (wanted.responses) {
    console.step("sweeping both twins up and down");
    folder.write("fig-11.svg", section5_sweeps_figure());
  }
  const auto cases = wanted.cases();
  if (cases.empty()) return {};
  const Section5Replication replication = replicate_section5(cases, options, folder, console);
  if (wanted.errors) folder.write("table-9.txt", section5_errors_table(replication, cases, options));
  for (const Section5Case* one : wanted.tables)
    folder.write(fmt::format("table-{}.txt", one->table), section5_table(replication, *one, options));
  if (wanted.states) folder.write("fig-12.svg", section5_states_figure(replication));
  if (wanted.identified) folder.write("fig-13.svg", section5_responses_figure(replication));
  append_section5(document, replication, cases, options);
  std::string summary;
  for (const Section5Case* one : cases) summary += summary_of(replication, *one);
  return summary;
}

}  // namespace

void run_replicate(const ReplicateArguments& arguments, Console& console) {
  const ReplicateOptions options = options_of(arguments);
  const Items items = items_of(arguments.items);
  const auto start = std::chrono::steady_clock::now();
  OutputFolder folder(arguments.folder, arguments.force);
  Manifest manifest = begin_manifest("replicate", arguments.command_line, arguments.first_seed, folder.destination());

  std::vector<ReplicatedCase> cases;
  std::string summary = replicate_cases(items.cases, options, folder, cases, console);
  nlohmann::ordered_json document = replicate_json(cases, options);
  summary += replicate_rig(
      items.rig, {options.num_seeds, options.first_seed, arguments.noise.value_or(1.0), options.selection, options.tau},
      folder, document, console);
  const std::string text = document.dump(1) + "\n";
  folder.write("replicate.json", text);
  folder.commit(std::move(manifest));
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  console.result(console.json() ? text : summary + fmt::format("in {:.1f} s\n", seconds));
}

}  // namespace apps
