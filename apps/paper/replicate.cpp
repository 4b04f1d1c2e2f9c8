#include "apps/paper/replicate.hpp"

#include <fmt/ranges.h>

#include <algorithm>

#include "apps/paper/comparison.hpp"
#include "apps/paper/inner_state.hpp"
#include "apps/paper/paper_figures.hpp"
#include "apps/paper/replicate_page.hpp"
#include "apps/paper/rig_comparison.hpp"
#include "apps/paper/tables.hpp"
#include "dsp/values/fault.hpp"

namespace apps {
namespace {

using Names = std::vector<std::string>;

std::string name_of(const char* kind, int number) {
  return fmt::format("{}-{}", kind, number);
}

bool asked(const Names& items, const Names& any_of) {
  return std::find_first_of(items.begin(), items.end(), any_of.begin(), any_of.end()) != items.end();
}

/// The results as they grow, and the folder they go to.
struct Results {
  const Names& items;
  const OutputFolder& folder;
  Json document;
  std::vector<ReplicatedItem> written = {};

  void add(const Json& part) {
    for (const auto& [list, rows] : part.items())
      for (const Json& row : rows) document[list].push_back(row);
  }
  void write_table(int number, const std::string& what, const std::string& head, const JsonRows& rows,
                   const std::string& further) {
    std::string text = fmt::format("Table {}: {}\n{}", number, what, head);
    for (const PaperTable& table : compared_tables(rows)) text += table.text();
    text += further;
    folder.write(name_of("table", number) + ".txt", text);
    written.push_back({name_of("table", number), fmt::format("Table {}: {}", number, what), {}, std::move(text)});
  }
  void write_figure(int number, const std::string& what, PlotFigure figure) {
    figure.name = name_of("fig", number);
    std::string svg = to_svg(figure);
    folder.write(name_of("fig", number) + ".svg", svg);
    written.push_back({name_of("fig", number), fmt::format("Figure {}: {}", number, what), std::move(svg)});
  }
};

std::string head_of(const char* section, const ReplicateOptions& options) {
  return fmt::format(fmt::runtime(paper_sentences().table("head").text(section).value()),
                     fmt::arg("noise", options.noise), fmt::arg("selection", ident::to_string(options.selection)),
                     fmt::arg("first", options.first_seed),
                     fmt::arg("last", options.first_seed + static_cast<std::uint64_t>(options.num_seeds) - 1));
}

std::string replicate_section4(const Section4Case& definition, const ReplicateOptions& options, Results& results,
                               Console& console) {
  const bool table = asked(results.items, {"all", definition.name, name_of("table", definition.table)});
  const bool figure = asked(results.items, {"all", definition.name, name_of("fig", definition.figure)});
  if (!table && !figure) return {};
  console.step(definition.name);
  CaseReplication replication = replicate_case(definition, options, shown_progress(console, definition.name));
  if (table) replicate_inner_state(replication, options);
  const Json rows = compare_with_paper(replication);
  results.add(replication.document);
  results.add({{"paper", rows}});
  if (table)
    results.write_table(definition.table, definition.name, head_of("case", options), matching(rows, Json::object()),
                        case_text(replication, options));
  if (figure)
    results.write_figure(
        definition.figure,
        fmt::format("{}, true and identified responses at frequency ratios that were not fitted", definition.name),
        case_figure(replication));
  const auto fits = [&](bool exact) {
    return matching(replication.document["fits"], {{"method", "fast_rvm"}, {"support_exact", exact}}).size();
  };
  return fmt::format("{:<11} rows right {}/{} over {} seed{}, printed coefficients within noise {}/{}\n",
                     definition.name, fits(true), fits(true) + fits(false), options.num_seeds,
                     options.num_seeds == 1 ? "" : "s",
                     matching(rows, {{"quantity", "mean"}, {"verdict", "within noise"}}).size(),
                     matching(rows, {{"quantity", "mean"}}).size());
}

std::string summary_of(const RigReplication& replication, const RigRegime& regime) {
  std::string text = fmt::format("{:<11} NMSE train/test paper {:.4f}/{:.4f}", regime.case_name(),
                                 printed_value(9, "train", "fast_rvm", "nmse", regime.name),
                                 printed_value(9, "test", "fast_rvm", "nmse", regime.name));
  for (const RigWay& way : rig_ways()) {
    const JsonRows fits = rig_fits(replication, regime, way);
    text += fmt::format(", {} {:.2g}/{:.2g}", way.name, mean_of(fits, "/nmse/train"), mean_of(fits, "/nmse/test"));
  }
  return text + "\n";
}

std::string replicate_section5(const ReplicateOptions& options, Results& results, Console& console) {
  const auto wants = [&](const std::string& name) { return asked(results.items, {"all", "qzs", name}); };
  if (wants("fig-11")) {
    console.step("sweeping both twins up and down");
    results.write_figure(11, "frequency response of the rig's twins", rig_sweeps());
  }
  const bool need_all = wants("table-9") || wants("fig-12") || wants("fig-13");
  std::vector<RigRegime> tables = rig_regimes();
  std::erase_if(tables,
                [&](const RigRegime& one) { return !wants(one.case_name()) && !wants(name_of("table", one.table)); });
  const std::vector<RigRegime> regimes = need_all ? rig_regimes() : tables;
  if (regimes.empty()) return {};
  const RigReplication replication = replicate_rig(regimes, options, results.folder, console);
  const Json rows = compare_rig(replication, regimes);
  results.add({{"fits", replication.fits},
               {"free_run", replication.free_run},
               {"paper", rows},
               {"sensors", replication.sensors}});
  std::string head = head_of("rig", options);
  for (const RigWay& way : rig_ways()) head += fmt::format("  {:<11} {}\n", way.name, way.what);
  if (wants("table-9")) {
    const JsonRows of_table = matching(rows, {{"table", 9}});
    results.write_table(9, "errors on the rig", head + "\n", of_table, rig_errors_text(replication, regimes, of_table));
  }
  for (const RigRegime& one : tables) {
    const JsonRows of_table = matching(rows, {{"table", one.table}});
    results.write_table(one.table, fmt::format("the rig, {} regime", one.name), head + "\n", of_table,
                        rig_text(replication, one, of_table));
  }
  if (wants("fig-12")) results.write_figure(12, "measured states of each regime, twin T1", rig_states(replication));
  if (wants("fig-13"))
    results.write_figure(13, "measured and identified acceleration, twin T1", rig_responses(replication));
  std::string summary;
  for (const RigRegime& one : regimes) summary += summary_of(replication, one);
  return summary;
}

}  // namespace

void require_items(const Names& items) {
  Names cases, known{"all", "qzs", name_of("table", 9), name_of("fig", 11), name_of("fig", 12), name_of("fig", 13)};
  for (const Section4Case& one : section4_cases()) {
    cases.push_back(one.name);
    known.insert(known.end(), {name_of("table", one.table), name_of("fig", one.figure)});
  }
  for (const RigRegime& one : rig_regimes()) {
    cases.push_back(one.case_name());
    known.push_back(name_of("table", one.table));
  }
  const auto refuse = [](const std::string& text) {
    throw dsp::Fault(dsp::FaultKind::usage, "replicate.item", "replicate: " + text);
  };
  if (items.empty()) refuse("nothing to do; name a table, a figure, a case, or all");
  for (const std::string& item : items)
    if (!asked({item}, known) && !asked({item}, cases))
      refuse(fmt::format(
          "'{}' is not known; there are table-1 to table-12, fig-2 to fig-9, fig-11 to fig-13, {}, qzs, all", item,
          fmt::join(cases, ", ")));
}

Replicated replicate(const Names& items, const ReplicateOptions& options, const ReplicateOptions& rig_options,
                     const OutputFolder& folder, Console& console) {
  Results results{items, folder};
  for (const char* list : {"fits", "free_run", "one_step", "bands", "paper", "accumulate"})
    results.document[list] = Json::array();
  std::string summary;
  for (const Section4Case& one : section4_cases()) summary += replicate_section4(one, options, results, console);
  summary += replicate_section5(rig_options, results, console);
  for (ReplicatedItem& item : results.written)
    for (const Json& row : results.document["paper"])
      if (item.name == name_of("table", row["table"])) item.rows.push_back(&row);
  const std::string json = results.document.dump(1) + "\n";
  folder.write("replicate.json", json);
  folder.write("replicate.html", replicate_page(results.written, summary));
  return {json, summary};
}

}  // namespace apps
