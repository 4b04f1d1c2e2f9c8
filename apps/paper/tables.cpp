#include "apps/paper/tables.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "apps/paper/inner_state.hpp"
#include "apps/paper/paper_data.hpp"
#include "apps/paper/rig_comparison.hpp"
#include "apps/text/number_text.hpp"
#include "apps/text/wrapped_text.hpp"
#include "dsp/values/order_statistics.hpp"

namespace apps {
namespace {

/// "x (3x), v", by how often the fits have a term in this list; "-" for none.
std::string counted(const JsonRows& fits, const char* list) {
  std::map<std::string, int> counts;
  for (const Json* fit : fits)
    for (const Json& term : fit->at(list)) ++counts[term.is_string() ? term : term["name"]];
  std::vector<std::string> parts;
  for (const auto& [name, count] : counts) parts.push_back(count > 1 ? fmt::format("{} ({}x)", name, count) : name);
  return parts.empty() ? "-" : fmt::format("{}", fmt::join(parts, ", "));
}

PaperTable supports(const Json& document) {
  PaperTable table{"Support", {"<row", "<method", ">exact", "<false terms; missing terms"}, {}};
  for (const auto& [key, fits] : grouped(matching(document["fits"], {}), {"row", "method"})) {
    const bool known = !fits.front()->at("support_exact").is_null();
    const auto exact =
        std::count_if(fits.begin(), fits.end(), [](const Json* fit) { return fit->at("support_exact") == true; });
    table.rows.push_back({key[0], key[1], known ? fmt::format("{}/{}", exact, fits.size()) : "no truth",
                          known ? counted(fits, "false_terms") + "; " + counted(fits, "missing_terms")
                                : "kept: " + counted(fits, "terms")});
  }
  return table;
}

/// What no regression can help: true terms the noise hides.
std::string weak_text(const CaseReplication& replication, const ReplicateOptions& options) {
  std::string text;
  for (const Json* fit : matching(replication.document["fits"], {{"method", "fast_rvm"}, {"seed", options.first_seed}}))
    for (const WeakTerm& term : weak_terms(replication.study, options.noise, fit->at("tau")))
      if (fit->at("row") == term.row)
        text += reason("weak", fmt::arg("row", term.row), fmt::arg("term", term.term), fmt::arg("t", term.t),
                       fmt::arg("tau", fit->at("tau").get<double>()), fmt::arg("kept", 100.0 * term.kept_fraction),
                       fmt::arg("exact", 100.0 * term.best_exact_fraction));
  return text;
}

/// Of exact fits by the fast RVM.
std::string error_text(const CaseReplication& replication, double noise) {
  int covered = 0, total = 0;
  double largest = 0.0;
  std::vector<double> medians;
  for (const Section4Regression& regression : replication.study.regressions)
    for (const Section4Row& row : regression.rows) {
      std::vector<Eigen::Index> terms;
      for (Eigen::Index i = 0; i < row.truth.size(); ++i)
        if (row.truth(i) != 0.0) terms.push_back(i);
      const JsonRows fits = matching(replication.document["fits"],
                                     {{"row", row.label()}, {"method", "fast_rvm"}, {"support_exact", true}});
      for (std::size_t i = 0; i < terms.size() && !fits.empty(); ++i) {
        const double expected = unit_root(regression, terms).row(static_cast<Eigen::Index>(i)).norm() * noise * row.std;
        std::vector<double> errors;
        for (const Json* fit : fits) {
          const Json& term = fit->at("terms")[i];
          const double error = std::abs(number_in(term["mean"]) - number_in(term["true"])),
                       stds = error / number_in(term["std"]);
          covered += stds <= 1.959964;
          ++total;
          largest = std::max(largest, stds);
          errors.push_back(error / expected);
        }
        medians.push_back(dsp::median(errors));
      }
    }
  if (total == 0) return {};
  return fmt::format(
      "95 % intervals hold {} of {} coefficients; largest error {:.2f} standard deviations\n"
      "median errors of {} coefficients: {:.2f} to {:.2f} of the standard deviation the noise allows (0.67 expected)\n",
      covered, total, largest, medians.size(), *std::min_element(medians.begin(), medians.end()),
      *std::max_element(medians.begin(), medians.end()));
}

PaperTable free_runs(const Json& document) {
  PaperTable table{"Free run at held-out ratios, NMSE", {"<method", ">ratio", "<signal", ">median", ">worst"}, {}};
  const auto value = [](double nmse) { return std::isfinite(nmse) ? fmt::format("{:.2e}", nmse) : "diverged"; };
  for (const auto& [key, runs] : grouped(matching(document["free_run"], {}), {"method", "ratio", "signal"})) {
    std::vector<double> errors;
    for (const Json* run : runs) errors.push_back(run->at("nmse").is_null() ? HUGE_VAL : number_in(run->at("nmse")));
    table.rows.push_back({key[0], fmt::format("{:.2f}", number_in(key[1])), key[2], value(dsp::median(errors)),
                          value(*std::max_element(errors.begin(), errors.end()))});
  }
  return table;
}

/// Heads of a table with a column for each way.
std::vector<std::string> with_ways(std::vector<std::string> heads) {
  for (const RigWay& way : rig_ways()) heads.push_back(">" + way.name);
  return heads;
}

std::string error_pair(double train, double test) {
  if (!std::isfinite(train)) return "";
  return train < 1e-3 ? fmt::format("{:.1e}/{:.1e}", train, test) : fmt::format("{:.4f}/{:.4f}", train, test);
}

/// Mean and standard deviation in SI of every term that some way keeps, beside what is true.
std::string si_text(const RigReplication& replication, const RigRegime& regime, const char* candidates,
                    const std::string& caption) {
  PaperTable table{caption, with_ways({"<term", "<unit"}), {}};
  table.heads.insert(table.heads.end(), {">true T1", ">true T0"});
  for (const std::string& name : words_in(paper_cases(), "rig_terms")) {
    std::vector<std::string> row{name, ""};
    for (const RigWay& way : rig_ways()) {
      const FoundTerm term = found_term(rig_fits(replication, regime, way, candidates), name);
      row.push_back(term.kept > 0 ? fmt::format("{:.5g} +- {:.2g}", term.mean, term.std) : "-");
      if (term.kept > 0) row[1] = term.unit;
    }
    for (const char* twin : {"T1", "T0"}) row.push_back(number_text(rig_truth(twin, name), "{:.4g}"));
    if (!row[1].empty()) table.rows.push_back(std::move(row));
  }
  return table.text();
}

std::string listed(const std::vector<std::string>& sentences) {
  std::string text;
  for (const std::string& sentence : sentences)
    text += fmt::format("- {}\n", fmt::join(wrapped(sentence, 116), "\n  "));
  return text;
}

}  // namespace

std::string PaperTable::text() const {
  std::vector<std::size_t> widths;
  for (std::size_t j = 0; j < heads.size(); ++j) {
    widths.push_back(heads[j].size() - 1);
    for (const auto& row : rows) widths[j] = std::max(widths[j], row[j].size());
  }
  std::string text = caption + "\n";
  for (std::size_t i = 0; i <= rows.size(); ++i) {
    std::string line;
    for (std::size_t j = 0; j < heads.size(); ++j)
      line += fmt::format(fmt::runtime(heads[j].front() == '<' ? "{:<{}} " : "{:>{}} "),
                          i == 0 ? heads[j].substr(1) : rows[i - 1][j], widths[j]);
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text + "\n";
}

std::vector<PaperTable> compared_tables(const JsonRows& rows) {
  std::vector<PaperTable> tables;
  for (const char* name : {"mean", "cov", "nmse", "free_run", "seconds"}) {
    const dsp::Settings words = paper_sentences().table("quantity").table(name);
    PaperTable table{words.text("caption").value(),
                     {"<row", "<term", "<method", ">paper", ">expected", ">ours", ">our standard deviation",
                      "<verdict on the print"},
                     {}};
    bool expected = false;
    for (const Json* row : rows) {
      if (row->at("quantity") != name) continue;
      const std::string term = row->at("term"), verdict = row->at("verdict"), why = row->at("reason");
      expected = expected || row->at("expected").is_number();
      table.rows.push_back(
          {row->at("row"), row->contains("ratio") ? fmt::format("{} at {:g}", term, number_in(row->at("ratio"))) : term,
           row->at("method")});
      for (const char* value : {"paper", "expected", "ours", "ours_std"})
        table.rows.back().push_back(number_text(number_in(row->at(value)), "{:.5g}"));
      table.rows.back().push_back(why.empty() ? verdict : verdict + ": " + why);
    }
    if (const std::string meaning = words.text("expected").value(); expected && !meaning.empty())
      table.caption += "; expected: " + meaning;
    if (!table.rows.empty()) tables.push_back(std::move(table));
  }
  return tables;
}

std::string case_text(const CaseReplication& replication, const ReplicateOptions& options) {
  const Json& document = replication.document;
  std::string text = supports(document).text() + weak_text(replication, options);
  text += "Error bars, bands and times of the fast RVM\n";
  if (options.noise > 0.0) text += error_text(replication, options.noise);
  if (const JsonRows bands = matching(document["bands"], {}); !bands.empty())
    text += fmt::format(
        "bands at held-out ratios, {} records: {:.1f}, {:.1f} and {:.1f} % inside the 50, 90 and 95 % bands\n",
        bands.size(), 100.0 * mean_of(bands, "/within_50"), 100.0 * mean_of(bands, "/within_90"),
        100.0 * mean_of(bands, "/within_95"));
  const JsonRows fits = matching(document["fits"], {{"method", "fast_rvm"}});
  const double ms = 1e3 * static_cast<double>(fits.size()) / options.num_seeds;
  text += fmt::format("F-RVM of all rows from R: {:.2f} ms; all columns and targets to R: {:.2f} ms\n\n",
                      ms * mean_of(fits, "/seconds"), 1e3 * number_in(document["accumulate"][0]["seconds"]));
  return text + free_runs(document).text() + inner_state_text(replication);
}

std::string rig_errors_text(const RigReplication& replication, const std::vector<RigRegime>& regimes,
                            const JsonRows& rows) {
  std::string text;
  std::vector<std::string> differences;
  for (const Json* row : rows)
    if (row->at("method") == "fast_rvm" && row->at("verdict") != "same size")
      differences.push_back(fmt::format("{}, {}: ours is {} than printed, {:.4f} for {:.4f}.",
                                        row->at("row").get<std::string>(), row->at("term").get<std::string>(),
                                        row->at("verdict").get<std::string>(), number_in(row->at("ours")),
                                        number_in(row->at("paper"))));
  PaperTable runs{"Free run over the test rows, NMSE of x, F-RVM (the paper has none; 1 is as good as no motion)",
                  with_ways({"<data", "<candidates"}),
                  {}};
  for (const auto& [candidates, words] :
       {std::pair{"paper", "the paper's candidates"}, {"all", "cubic terms, sgn(v) and ddr"}}) {
    PaperTable errors{fmt::format("From {}", words), with_ways({"<data", "<method", ">paper"}), {}};
    for (const RigRegime& regime : regimes) {
      for (const char* method : paper_methods) {
        const auto print = [&](const char* part) { return printed_value(9, part, method, "nmse", regime.name); };
        errors.rows.push_back(
            {regime.name, method, *candidates == 'p' ? error_pair(print("train"), print("test")) : ""});
        for (const RigWay& way : rig_ways()) {
          const JsonRows fits = rig_fits(replication, regime, way, candidates, method);
          errors.rows.back().push_back(error_pair(mean_of(fits, "/nmse/train"), mean_of(fits, "/nmse/test")));
        }
      }
      runs.rows.push_back({regime.name, candidates});
      for (const RigWay& way : rig_ways()) {
        const JsonRows found = matching(
            replication.free_run,
            {{"case", regime.case_name()}, {"method", "fast_rvm"}, {"way", way.name}, {"candidates", candidates}});
        runs.rows.back().push_back(number_text(mean_of(found, "/nmse"), "{:.2g}"));
      }
    }
    text += errors.text();
  }
  for (const RigRegime& regime : regimes) {
    const auto sentences = rig_differences(replication, regime);
    differences.push_back(fmt::format("{}: {} {}", regime.name, sentences[0], sentences[1]));
  }
  return text + runs.text() + "What differs, and why\n" + listed(differences);
}

std::string rig_text(const RigReplication& replication, const RigRegime& regime, const JsonRows& rows) {
  std::string text, alone;
  const JsonRows fits = rig_fits(replication, regime, rig_ways().front());
  for (const std::string& name : words_in(paper_cases(), "rig_terms"))
    if (const FoundTerm term = found_term(fits, name);
        term.kept > 0 &&
        std::none_of(rows.begin(), rows.end(), [&](const Json* row) { return row->at("term") == name; }))
      alone += fmt::format("{}{} {:.3g}", alone.empty() ? "" : ", ", name, term.mean_scaled);
  if (!alone.empty()) text += fmt::format("kept by ours alone (F-RVM): {}\n\n", alone);
  text += si_text(replication, regime, "paper",
                  "SI, F-RVM, the paper's candidates (true: friction at its kinetic level; the payload's laser reads "
                  "0.4 % short, so -95000 x^3 is -95766 in its units)");
  text += si_text(replication, regime, "all", "SI, F-RVM, cubic terms, sgn(v) and ddr");
  return text + "What differs, and why\n" + listed(rig_differences(replication, regime));
}

}  // namespace apps
