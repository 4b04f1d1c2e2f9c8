#include "apps/paper/replicate_files.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

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

}  // namespace

std::string write_section4(const std::vector<WantedCase>& wanted, const ReplicateOptions& options,
                           const OutputFolder& folder, std::vector<ReplicatedCase>& cases, Console& console) {
  std::string summary;
  for (const WantedCase& one : wanted) {
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

std::string write_section5(const WantedOfRig& wanted, const Section5Options& options, const OutputFolder& folder,
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

}  // namespace apps
