#include "apps/paper/section5_output.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/output/json_number.hpp"
#include "apps/paper/replicate_output.hpp"
#include "ident/model.hpp"
#include "sim/rig/qzs_rig.hpp"

namespace apps {
namespace {

using nlohmann::ordered_json;

std::string shown(double value, const char* format = "{:.4g}") {
  return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : "-";
}

std::string head(const Section5Options& options) {
  return fmt::format(
      "seeds {} to {}; noise {:g} times the sensors' own; selection {}\nThe rig's record is not public. Twin T1 takes "
      "in "
      "for it, with effects no candidate holds; T0 has none of them.\n",
      options.first_seed, options.first_seed + static_cast<std::uint64_t>(options.num_seeds) - 1, options.noise,
      ident::to_string(options.selection));
}

std::string ways_text() {
  std::string text;
  for (const Section5Way& way : section5_ways()) text += fmt::format("  {:<11} {}\n", way.name, way.what);
  return text;
}

std::string wrapped(const std::vector<std::string>& sentences) {
  constexpr std::size_t width = 118;
  std::string text;
  for (const std::string& sentence : sentences) {
    std::string line = "-";
    for (std::size_t at = 0; at < sentence.size();) {
      const std::size_t end = std::min(sentence.find(' ', at), sentence.size());
      const std::string word = sentence.substr(at, end - at);
      if (line.size() + 1 + word.size() > width) {
        text += line + "\n";
        line = " ";
      }
      line += " " + word;
      at = end + 1;
    }
    text += line + "\n";
  }
  return text;
}

double truth_of(const std::string& twin, const std::string& term) {
  for (const sim::TrueTerm& truth : sim::true_terms(sim::qzs_twin(twin)))
    if (truth.target == "a" && truth.name == term) return truth.value;
  return 0.0;
}

// Mean and standard deviation in SI of every term that some way keeps, beside what is true.
std::string si_table(const Section5Replication& replication, const Section5Case& definition, const char* candidates) {
  std::vector<Section5View> views;
  for (const Section5Way& way : section5_ways()) views.emplace_back(replication, definition, way, candidates);
  std::string text = fmt::format("{:<8} {:<14}", "term", "unit");
  for (const Section5Way& way : section5_ways()) text += fmt::format(" {:>22}", way.name);
  text += fmt::format(" {:>10} {:>10}\n", "true T1", "true T0");
  for (const char* name : {"1", "x", "v", "x^2", "x*v", "v^2", "x^3", "x^2*v", "x*v^2", "v^3", "sgn(v)", "ddr"}) {
    std::string row, unit;
    int kept = 0;
    for (const Section5View& view : views) {
      const FoundTerm term = view.term("fast_rvm", name);
      row += fmt::format(" {:>22}", term.kept > 0 ? fmt::format("{:.5g} +- {:.2g}", term.mean, term.std) : "-");
      if (term.kept > 0) unit = term.unit;
      kept += term.kept;
    }
    if (kept > 0)
      text += fmt::format("{:<8} {:<14}{} {:>10} {:>10}\n", name, unit, row, shown(truth_of("T1", name)),
                          shown(truth_of("T0", name)));
  }
  return text;
}

std::string quantity_rows(const std::vector<Comparison>& rows, int table, const char* quantity) {
  std::string text =
      fmt::format("{:<8} {:<9} {:>10} {:>10} {:>9}  {}\n", "term", "method", "paper", "ours", "our sd", "verdict");
  for (const Comparison& row : rows)
    if (row.table == table && row.quantity == quantity)
      text += fmt::format("{:<8} {:<9} {:>10} {:>10} {:>9}  {}{}\n", row.term, row.method, shown(row.paper),
                          shown(row.ours), shown(row.ours_std, "{:.2g}"), row.verdict.verdict,
                          row.verdict.reason.empty() ? "" : "; " + row.verdict.reason);
  return text;
}

ordered_json support_json(const Section5Fit& fit, const ident::JudgedFit& judged) {
  if (fit.way->twin != "T0")
    return {
        {"support_exact", nullptr}, {"false_terms", ordered_json::array()}, {"missing_terms", ordered_json::array()}};
  std::vector<std::string> wrong, missing;
  for (const ident::ModelTerm& term : judged.model.terms)
    if (truth_of("T0", term.name) == 0.0) wrong.push_back(term.name);
  for (const sim::TrueTerm& truth : sim::true_terms(sim::qzs_twin("T0")))
    if (truth.target == "a" && std::none_of(judged.model.terms.begin(), judged.model.terms.end(),
                                            [&](const auto& term) { return term.name == truth.name; }))
      missing.push_back(truth.name);
  return {{"support_exact", wrong.empty() && missing.empty()}, {"false_terms", wrong}, {"missing_terms", missing}};
}

ordered_json fit_json(const Section5Fit& fit, const ident::JudgedFit& judged, const Section5Options& options) {
  ordered_json terms = ordered_json::array();
  for (const ident::ModelTerm& term : judged.model.terms)
    terms.push_back({{"name", term.name},
                     {"true", fit.way->twin == "T0" ? ordered_json(truth_of("T0", term.name)) : ordered_json(nullptr)},
                     {"mean", term.mean},
                     {"std", number_or_null(term.std)},
                     {"unit", term.unit},
                     {"scale", term.scale},
                     {"mean_scaled", term.mean * term.scale},
                     {"std_scaled", number_or_null(term.std * term.scale)}});
  ordered_json row{
      {"case", fit.definition->name},
      {"row", "a"},
      {"seed", fit.seed},
      {"noise", options.noise},
      {"method", to_string(judged.fit.method)},
      {"selection", to_string(options.selection)},
      {"twin", fit.way->twin},
      {"way", fit.way->name},
      {"candidates", fit.candidates},
      {"status", to_string(judged.fit.status)},
      {"terms", std::move(terms)},
      {"noise_std", judged.model.noise_std},
      {"nmse", {{"train", number_or_null(judged.train.value)}, {"test", number_or_null(judged.test.value)}}},
      {"seconds", fit.result.accumulate_s + judged.solve_s}};
  row.update(support_json(fit, judged));
  return row;
}

}  // namespace

std::string section5_errors_table(const Section5Replication& replication, const std::vector<const Section5Case*>& cases,
                                  const Section5Options& options) {
  std::string text = "Table 9: NMSE of the acceleration, train/test\n" + head(options) + ways_text() + "\n";
  for (const char* candidates : {paper_candidates, all_candidates}) {
    text += fmt::format("From {}:\n{:<6} {:<9} {:>15}",
                        candidates == paper_candidates ? "the paper's candidates" : "cubic terms, sgn(v) and ddr",
                        "data", "method", "paper");
    for (const Section5Way& way : section5_ways()) text += fmt::format(" {:>15}", way.name);
    text += "\n";
    for (const Section5Case* one : cases)
      for (int m = 0; m < 3; ++m) {
        text += fmt::format("{:<6} {:<9}", one->regime, section5_methods[m]);
        for (const PaperErrors& paper : paper_errors())
          if (paper.table == one->table)
            text += fmt::format(" {:>15}", candidates == paper_candidates
                                               ? fmt::format("{:.4f}/{:.4f}", paper.train[m], paper.test[m])
                                               : "");
        for (const Section5Way& way : section5_ways()) {
          const auto errors = Section5View(replication, *one, way, candidates).errors(section5_methods[m]);
          text += fmt::format(" {:>15}", errors.train < 1e-3 ? fmt::format("{:.1e}/{:.1e}", errors.train, errors.test)
                                                             : fmt::format("{:.4f}/{:.4f}", errors.train, errors.test));
        }
        text += "\n";
      }
    text += "\n";
  }
  text += "Free run over the test rows, NMSE of x, F-RVM (the paper has none; 1 is as good as no motion)\n";
  for (const Section5Case* one : cases)
    for (const char* candidates : {paper_candidates, all_candidates}) {
      text += fmt::format("{:<6} {:<25}", one->regime, fmt::format("{} candidates", candidates));
      for (const Section5Way& way : section5_ways()) {
        const FoundErrors errors = Section5View(replication, *one, way, candidates).errors("fast_rvm");
        text +=
            fmt::format(" {:>15}", std::isfinite(errors.free_run) ? fmt::format("{:.2g}", errors.free_run) : "none");
      }
      text += "\n";
    }
  text += "\nWhat differs, and why\n";
  for (const Comparison& row : compare_section5(replication, cases))
    if (row.table == 9 && row.method == "fast_rvm" && row.verdict.verdict != "same size")
      text += wrapped({fmt::format("{}, {}: ours is {} than printed, {:.4f} for {:.4f}.", row.row, row.term,
                                   row.verdict.verdict, row.ours, row.paper)});
  for (const Section5Case* one : cases) {
    const auto reasons = section5_reasons(replication, *one);
    text += wrapped({fmt::format("{}: {} {}", one->regime, reasons[0], reasons[1])});
  }
  return text;
}

std::string section5_table(const Section5Replication& replication, const Section5Case& definition,
                           const Section5Options& options) {
  const auto rows = compare_section5(replication, {&definition});
  const int table = definition.table;
  const Section5View ours(replication, definition, section5_ways().front(), paper_candidates);
  std::string text = fmt::format("Table {}: acceleration in the {} regime, {:g} to {:g} s, trained to {:g} s\n", table,
                                 definition.regime, definition.from_s, definition.to_s, definition.train_to_s);
  text += head(options) + ways_text();
  text += "\nCoefficients of columns at unit maximum, m/s^2: the paper's beside T1 by its recipe\n" +
          quantity_rows(rows, table, "mean");
  std::vector<std::string> alone;
  for (const std::string& name : ours.kept("fast_rvm"))
    if (std::none_of(rows.begin(), rows.end(), [&](const Comparison& row) { return row.term == name; }))
      alone.push_back(fmt::format("{} {:.3g}", name, ours.term("fast_rvm", name).mean_scaled));
  if (!alone.empty()) text += fmt::format("kept by ours alone (F-RVM): {}\n", fmt::join(alone, ", "));
  text += "\nCoefficients of variation\n" + quantity_rows(rows, table, "cov");
  text +=
      "\nSI, F-RVM, the paper's candidates (true: friction at its kinetic level; the payload's laser reads 0.4 % "
      "short, so -95000 x^3 is -95766 in its units)\n" +
      si_table(replication, definition, paper_candidates);
  text += "\nSI, F-RVM, cubic terms, sgn(v) and ddr\n" + si_table(replication, definition, all_candidates);
  text += fmt::format("\nSeconds to train, rows to R factor included\n{:<9} {:>10} {:>10} {:>9}\n", "method", "paper",
                      "ours", "ratio");
  for (const Comparison& row : rows)
    if (row.quantity == "seconds")
      text += fmt::format("{:<9} {:>10} {:>10} {:>9}\n", row.method, shown(row.paper), shown(row.ours, "{:.2g}"),
                          shown(row.paper / row.ours, "{:.2g}"));
  return text + "\nWhat differs, and why\n" + wrapped(section5_reasons(replication, definition));
}

void append_section5(ordered_json& document, const Section5Replication& replication,
                     const std::vector<const Section5Case*>& cases, const Section5Options& options) {
  for (const Section5Fit& fit : replication.fits)
    for (const ident::JudgedFit& judged : fit.result.fits) {
      document["fits"].push_back(fit_json(fit, judged, options));
      const ident::FreeRun& run = judged.free_run;
      document["free_run"].push_back({{"case", fit.definition->name},
                                      {"seed", fit.seed},
                                      {"method", to_string(judged.fit.method)},
                                      {"ratio", nullptr},
                                      {"signal", "x"},
                                      {"nmse", number_or_null(run.nmse)},
                                      {"status", run.reason.empty() ? "finished" : run.reason},
                                      {"way", fit.way->name},
                                      {"candidates", fit.candidates}});
    }
  for (const Comparison& row : compare_section5(replication, cases)) document["paper"].push_back(comparison_json(row));
  for (const Section5Sensors& sensors : replication.sensors) {
    ordered_json raw = ordered_json::object(), corrected = ordered_json::object();
    for (const dsp::RegimePower& one : sensors.power) {
      raw[std::string(to_string(one.regime))] = number_or_null(one.raw);
      corrected[std::string(to_string(one.regime))] = number_or_null(one.corrected);
    }
    document["sensors"].push_back({{"way", sensors.way->name},
                                   {"seed", sensors.seed},
                                   {"power_check", {{"raw", std::move(raw)}, {"corrected", std::move(corrected)}}}});
  }
}

}  // namespace apps
