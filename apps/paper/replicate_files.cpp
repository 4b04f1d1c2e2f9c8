#include "apps/paper/replicate_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "apps/paper/section5_output.hpp"

namespace apps {
namespace {

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

void add_table(const std::string& what, int number, std::string text, std::vector<Comparison> rows,
               const OutputFolder& folder, std::vector<ReplicatedItem>& items) {
  const std::string name = fmt::format("table-{}", number);
  folder.write(name + ".txt", text);
  items.push_back({name, fmt::format("Table {}: {}", number, what), {}, std::move(text), std::move(rows)});
}

void add_figure(const std::string& what, int number, std::string svg, const OutputFolder& folder,
                std::vector<ReplicatedItem>& items) {
  const std::string name = fmt::format("fig-{}", number);
  folder.write(name + ".svg", svg);
  items.push_back({name, fmt::format("Figure {}: {}", number, what), std::move(svg), {}, {}});
}

}  // namespace

std::string write_section4(const std::vector<WantedCase>& wanted, const ReplicateOptions& options,
                           const OutputFolder& folder, std::vector<ReplicatedCase>& cases,
                           std::vector<ReplicatedItem>& items, Console& console) {
  std::string summary;
  for (const WantedCase& one : wanted) {
    const std::string& name = one.definition->name;
    console.step(name);
    CaseReplication replication = replicate_case(*one.definition, options, shown_progress(console, name));
    auto comparisons = compare_with_paper(replication);
    cases.push_back({std::move(replication), std::move(comparisons)});
    if (one.table)
      add_table(name, one.definition->table, replicate_table(cases.back(), options), cases.back().comparisons, folder,
                items);
    if (one.figure)
      add_figure(fmt::format("{}, true and identified responses at frequency ratios that were not fitted", name),
                 one.definition->figure, replicate_figure(cases.back()), folder, items);
    summary += summary_of(cases.back(), options.num_seeds);
  }
  return summary;
}

std::string write_section5(const WantedOfRig& wanted, const Section5Options& options, const OutputFolder& folder,
                           nlohmann::ordered_json& document, std::vector<ReplicatedItem>& items, Console& console) {
  if (wanted.responses) {
    console.step("sweeping both twins up and down");
    add_figure("frequency response of the rig's twins", 11, section5_sweeps_figure(), folder, items);
  }
  const auto cases = wanted.cases();
  if (cases.empty()) return {};
  const Section5Replication replication = replicate_section5(cases, options, folder, console);
  const std::vector<Comparison> compared = compare_section5(replication, cases);
  const auto rows_of = [&](int table) {
    std::vector<Comparison> rows;
    std::copy_if(compared.begin(), compared.end(), std::back_inserter(rows),
                 [&](const Comparison& row) { return row.table == table; });
    return rows;
  };
  if (wanted.errors)
    add_table("errors on the rig", 9, section5_errors_table(replication, cases, options), rows_of(9), folder, items);
  for (const Section5Case* one : wanted.tables)
    add_table(fmt::format("the rig, {} regime", one->regime), one->table, section5_table(replication, *one, options),
              rows_of(one->table), folder, items);
  if (wanted.states)
    add_figure("measured states of each regime, twin T1", 12, section5_states_figure(replication), folder, items);
  if (wanted.identified)
    add_figure("measured and identified acceleration, twin T1", 13, section5_responses_figure(replication), folder,
               items);
  append_section5(document, replication, cases, options);
  std::string summary;
  for (const Section5Case* one : cases) summary += summary_of(replication, *one);
  return summary;
}

}  // namespace apps
