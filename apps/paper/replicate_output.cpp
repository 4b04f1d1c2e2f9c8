#include "apps/paper/replicate_output.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "apps/output/json_number.hpp"
#include "apps/output/svg_plot.hpp"
#include "apps/paper/replicate_statistics.hpp"
#include "dsp/order_statistics.hpp"

namespace apps {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using nlohmann::ordered_json;

// JSON has no NaN.
std::vector<std::string> names_of(const Section4Study& study, const std::vector<Index>& terms) {
  std::vector<std::string> names;
  for (const Index term : terms) names.push_back(study.library.terms[static_cast<std::size_t>(term)].name);
  return names;
}

ordered_json fit_json(const CaseReplication& replication, const CaseFit& fit, const ReplicateOptions& options) {
  const Section4Row& row = replication.row_of(fit);
  const auto names = names_of(replication.study, fit.fit.relevant);
  ordered_json terms = ordered_json::array(), rejected = ordered_json::array(), steps = ordered_json::array();
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto j = static_cast<Index>(i);
    const double truth = row.truth_known ? row.truth(fit.fit.relevant[i]) : std::nan("");
    terms.push_back({{"name", names[i]},
                     {"true", number_or_null(truth)},
                     {"mean", fit.fit.mean(j)},
                     {"std", number_or_null(std::sqrt(fit.fit.interval_covariance()(j, j)))},
                     {"std_noise", number_or_null(std::sqrt(fit.fit.covariance(j, j)))},
                     {"inclusion_probability", number_or_null(fit.fit.inclusion_probability(fit.fit.relevant[i]))}});
  }
  for (Index i = 0; i < fit.fit.evidence_gain.size(); ++i)
    if (!std::binary_search(fit.fit.relevant.begin(), fit.fit.relevant.end(), i))
      rejected.push_back({{"name", names_of(replication.study, {i}).front()},
                          {"inclusion_probability", number_or_null(fit.fit.inclusion_probability(i))}});
  const auto name_of = [&](Index term) {
    return term < 0 ? ordered_json(nullptr) : ordered_json(names_of(replication.study, {term}).front());
  };
  for (const ident::FitStep& step : fit.fit.steps) {
    steps.push_back({{"action", ident::to_string(step.action)},
                     {"term", name_of(step.term)},
                     {"log_evidence", number_or_null(step.log_evidence)},
                     {"noise_variance", number_or_null(step.noise_variance)}});
    if (step.action == ident::FitAction::start) steps.back()["terms"] = names_of(replication.study, step.terms);
    if (step.action == ident::FitAction::exchange) steps.back()["leaving"] = name_of(step.leaving);
    if (std::isfinite(step.penalty)) steps.back()["lambda"] = step.penalty;
  }
  const std::optional<ident::Selection> selection = fit.fit.selection;
  return {{"case", replication.study.definition->name},
          {"row", row.label()},
          {"seed", fit.seed},
          {"noise", options.noise},
          {"method", fit.method},
          {"selection", selection ? ordered_json(ident::to_string(*selection)) : ordered_json(nullptr)},
          {"tau", selection ? ordered_json(fit.fit.tau) : ordered_json(nullptr)},
          {"status", ident::to_string(fit.fit.status)},
          {"iterations", fit.fit.iterations},
          {"discarded_iterations", fit.fit.discarded_iterations},
          {"support_exact", row.truth_known ? ordered_json(fit.error.exact()) : ordered_json(nullptr)},
          {"false_terms", names_of(replication.study, fit.error.false_terms)},
          {"missing_terms", names_of(replication.study, fit.error.missing_terms)},
          {"terms", std::move(terms)},
          {"rejected", std::move(rejected)},
          {"noise_std", number_or_null(std::sqrt(fit.fit.noise_variance))},
          {"log_evidence", number_or_null(fit.fit.log_evidence)},
          {"condition_number", number_or_null(fit.fit.condition_number)},
          {"steps", std::move(steps)},
          {"seconds", fit.seconds}};
}

const char* title_of(const std::string& method) {
  return method == "fast_rvm" ? "F-RVM" : method == "slow_rvm" ? "S-RVM" : "SINDy";
}

/// Exact fits of known rows, fits, false and missing terms by how often.
struct Tally {
  int exact = 0, fits = 0;
  std::map<std::string, int> false_terms, missing_terms;
};

std::string counted(const std::map<std::string, int>& terms) {
  std::vector<std::string> parts;
  for (const auto& [name, count] : terms) parts.push_back(count > 1 ? fmt::format("{} ({}x)", name, count) : name);
  return parts.empty() ? "-" : fmt::format("{}", fmt::join(parts, ", "));
}

std::string supports(const CaseReplication& replication) {
  std::map<std::pair<std::string, std::string>, Tally> tallies;
  std::vector<std::pair<std::string, std::string>> order;
  for (const CaseFit& fit : replication.fits) {
    const Section4Row& row = replication.row_of(fit);
    const std::pair key{row.label(), fit.method};
    if (!tallies.contains(key)) order.push_back(key);
    Tally& tally = tallies[key];
    ++tally.fits;
    tally.exact += row.truth_known && fit.error.exact();
    for (const auto& name : names_of(replication.study, fit.error.false_terms)) ++tally.false_terms[name];
    for (const auto& name : names_of(replication.study, fit.error.missing_terms)) ++tally.missing_terms[name];
    if (!row.truth_known)  // no truth: what is kept is all there is to say
      for (const auto& name : names_of(replication.study, fit.fit.relevant)) ++tally.false_terms[name];
  }
  std::string text = fmt::format("{:<12} {:<10} {:>9}  {}\n", "row", "method", "exact", "false terms; missing terms");
  for (const auto& key : order) {
    const Tally& tally = tallies[key];
    const bool known =
        tally.exact > 0 || !tally.missing_terms.empty() || replication.study.definition->table != 4 || key.first == "1";
    text += fmt::format("{:<12} {:<10} {:>9}  {}\n", key.first, key.second,
                        known ? fmt::format("{}/{}", tally.exact, tally.fits) : "no truth",
                        known ? counted(tally.false_terms) + "; " + counted(tally.missing_terms)
                              : "kept: " + counted(tally.false_terms));
  }
  return text;
}

// What no regression can help: true terms the noise hides.
std::string weak(const CaseReplication& replication, const ReplicateOptions& options) {
  std::string text;
  for (const CaseFit& fit : replication.fits) {  // the first fast RVM of each row knows its tau
    if (fit.method != "fast_rvm" || fit.seed != options.first_seed) continue;
    for (const WeakTerm& term : weak_terms(replication.study, options.noise, fit.fit.tau))
      if (term.row == replication.row_of(fit).label())
        text += fmt::format(
            "row {}: {} is {:.2f} standard deviations from zero; tau {:.4g} keeps it in {:.0f} % of draws, and no "
            "threshold "
            "on "
            "the gain gets the row exact in more than {:.0f} %\n",
            term.row, term.term, term.t, fit.fit.tau, 100.0 * term.kept_fraction, 100.0 * term.best_exact_fraction);
  }
  return text;
}

std::string shown(double value) {
  return std::isfinite(value) ? fmt::format("{:.5g}", value) : "-";
}

std::string free_runs(const CaseReplication& replication) {
  std::string text = fmt::format("{:<10} {:>6} {:<7} {:>11} {:>11}\n", "method", "ratio", "signal", "median", "worst");
  std::map<std::tuple<std::string, double, std::string>, std::vector<double>> groups;
  std::vector<std::tuple<std::string, double, std::string>> order;
  for (const HeldOutScore& score : replication.scores) {
    if (score.kind != "free_run") continue;
    const std::tuple key{score.method, score.ratio, score.signal};
    if (!groups.contains(key)) order.push_back(key);
    groups[key].push_back(std::isfinite(score.nmse) ? score.nmse : HUGE_VAL);
  }
  for (const auto& key : order) {
    const auto& values = groups[key];
    const auto& [method, ratio, signal] = key;
    const auto value = [](double nmse) { return std::isfinite(nmse) ? fmt::format("{:.2e}", nmse) : "diverged"; };
    text += fmt::format("{:<10} {:>6.2f} {:<7} {:>11} {:>11}\n", method, ratio, signal, value(dsp::median(values)),
                        value(*std::max_element(values.begin(), values.end())));
  }
  return text;
}

std::string printed_free_runs(const std::vector<Comparison>& comparisons) {
  const auto value = [](double nmse) { return std::isfinite(nmse) ? fmt::format("{:.2e}", nmse) : "diverged"; };
  std::string text = fmt::format("{:<6} {:>6} {:<7} {:>11} {:>11} {:>11}  {}\n", "method", "ratio", "signal", "paper",
                                 "expected", "ours", "verdict");
  for (const Comparison& c : comparisons)
    if (c.quantity == "free_run")
      text += fmt::format("{:<6} {:>6.2f} {:<7} {:>11} {:>11} {:>11}  {}{}\n", title_of(c.method), c.ratio, c.term,
                          value(c.paper), value(c.expected), value(c.ours), c.verdict.verdict,
                          c.verdict.reason.empty() ? "" : ": " + c.verdict.reason);
  return text;
}

/// What is drawn of each held-out run: one signal over another.
struct View {
  const char *x, *y;
};

std::vector<View> views_of(const std::string& name) {
  if (name == "bouc-wen") return {{"x", "z"}, {"t", "v"}, {"t", "dz"}};
  if (name == "bouc-wen-2") return {{"t", "v"}, {"t", "a"}};
  if (name.starts_with("valanis")) return {{"x", "z"}, {"t", "x"}, {"t", "v"}};
  return {{"x", "v"}, {"t", "x"}};
}

const char* axis_of(const std::string& signal) {
  static const std::map<std::string, const char*> axes{{"t", "time (s)"},
                                                       {"x", "displacement x (m)"},
                                                       {"v", "velocity v (m/s)"},
                                                       {"a", "acceleration a (m/s\u00b2)"},
                                                       {"z", "hysteretic force z (N)"},
                                                       {"dz", "rate of the force dz/dt (N/s)"}};
  return axes.at(signal);
}

VectorXd signal_of(const sim::Simulation& run, const std::string& signal) {
  if (signal == "t") return run.time_s;
  if (signal == "a") return run.derivatives.col(1);
  if (signal == "dz") return run.derivatives.col(2);
  return run.states.col(signal == "x" ? 0 : signal == "v" ? 1 : 2);
}

PlotPanel panel_of(const View& view, const HeldOutRun& run, const std::string& title) {
  PlotPanel panel{title, axis_of(view.x), axis_of(view.y), {}, {}, {}};
  const VectorXd& true_y = run.record.motion.at(view.y);
  panel.series.push_back({"true", run.record.motion.at(view.x), true_y, PlotStyle::line, PlotColour::black});
  panel.series.push_back({"identified", signal_of(run.identified, view.x), signal_of(run.identified, view.y),
                          PlotStyle::dashed, PlotColour::vermilion});
  // A diverging run must not shrink the truth to a line, nor lines run under the legend.
  const double low = true_y.minCoeff(), high = true_y.maxCoeff(), size = high - low;
  panel.y_limits = {low - 0.12 * size, high + 0.30 * size};
  return panel;
}

}  // namespace

ordered_json comparison_json(const Comparison& c) {
  ordered_json row{{"table", c.table},
                   {"row", c.row},
                   {"term", c.term},
                   {"method", c.method},
                   {"quantity", c.quantity},
                   {"paper", number_or_null(c.paper)},
                   {"expected", number_or_null(c.expected)},
                   {"ours", number_or_null(c.ours)},
                   {"ours_std", number_or_null(c.ours_std)},
                   {"verdict", c.verdict.verdict},
                   {"reason", c.verdict.reason}};
  if (c.quantity == "free_run") row["ratio"] = c.ratio;
  return row;
}

ordered_json replicate_json(const std::vector<ReplicatedCase>& cases, const ReplicateOptions& options) {
  ordered_json document{{"fits", ordered_json::array()},     {"free_run", ordered_json::array()},
                        {"one_step", ordered_json::array()}, {"bands", ordered_json::array()},
                        {"paper", ordered_json::array()},    {"accumulate", ordered_json::array()}};
  for (const auto& [replication, comparisons] : cases) {
    const std::string& name = replication.study.definition->name;
    for (const CaseFit& fit : replication.fits) document["fits"].push_back(fit_json(replication, fit, options));
    for (const HeldOutScore& score : replication.scores)
      document[score.kind].push_back({{"case", name},
                                      {"seed", score.seed},
                                      {"method", score.method},
                                      {"ratio", score.ratio},
                                      {"signal", score.signal},
                                      {"nmse", number_or_null(score.nmse)},
                                      {"status", score.status}});
    for (const HeldOutBands& band : replication.bands)
      document["bands"].push_back({{"case", name},
                                   {"row", band.row},
                                   {"seed", band.seed},
                                   {"ratio", band.ratio},
                                   {"within_50", band.fractions.within_50},
                                   {"within_90", band.fractions.within_90},
                                   {"within_95", band.fractions.within_95}});
    for (const Comparison& c : comparisons) document["paper"].push_back(comparison_json(c));
    document["accumulate"].push_back({{"case", name}, {"seconds", replication.accumulate_seconds}});
  }
  return document;
}

std::string replicate_table(const ReplicatedCase& replicated, const ReplicateOptions& options) {
  const CaseReplication& replication = replicated.replication;
  const std::vector<Comparison>& comparisons = replicated.comparisons;
  const Section4Case& definition = *replication.study.definition;
  std::string text = fmt::format(
      "Table {}: {}\nnoise {:g} of each target's standard deviation, on the targets; selection {}; seeds {} to {}\n\n",
      definition.table, definition.name, options.noise, ident::to_string(options.selection), options.first_seed,
      options.first_seed + static_cast<std::uint64_t>(options.num_seeds) - 1);
  const auto list = [&, &comparisons = comparisons](const char* quantity, const char* heading) {
    text += heading;
    for (const Comparison& c : comparisons) {
      if (c.quantity != quantity) continue;
      text += fmt::format("{:<12} {:<16} {:<6} {:>11} {:>11} {:>11} {:>10}  {}{}\n", c.row, c.term, title_of(c.method),
                          shown(c.paper), shown(c.expected), shown(c.ours), shown(c.ours_std), c.verdict.verdict,
                          c.verdict.reason.empty() ? "" : ": " + c.verdict.reason);
    }
    text += "\n";
  };
  const std::string head = fmt::format("{:<12} {:<16} {:<6} {:>11} {:>11} {:>11} {:>10}  {}\n", "row", "term", "method",
                                       "paper", "expected", "ours", "our sd", "verdict");
  list("mean", ("Coefficients (expected: the truth, or the noise-free fit of the printed terms)\n" + head).c_str());
  if (std::any_of(comparisons.begin(), comparisons.end(), [](const auto& c) { return c.quantity == "cov"; }))
    list("cov", ("Coefficients of variation (expected: noise-free columns, the stated noise)\n" + head).c_str());
  text += "Support\n" + supports(replication) + weak(replication, options) + "\n";
  text += "Error bars, bands and times of the fast RVM\n" + statistics_text(replication, options.noise) + "\n";
  text += "Free run at held-out ratios, NMSE\n" + free_runs(replication) + "\n";
  text +=
      "The printed equations run free (expected: the stated noise on the terms printed, on average; ours: median)\n" +
      printed_free_runs(comparisons) + "\n";
  text += fmt::format("CPU seconds, all rows\n{:<8} {:>12} {:>12} {:>12}\n", "method", "paper", "ours", "ratio");
  for (const Comparison& c : comparisons)
    if (c.quantity == "seconds")
      text +=
          fmt::format("{:<8} {:>12.4f} {:>12.6f} {:>12.3g}\n", title_of(c.method), c.paper, c.ours, c.paper / c.ours);
  return text +
         fmt::format("of which from columns and targets to R factors: {:.6f} s\n", replication.accumulate_seconds);
}

std::string replicate_figure(const ReplicatedCase& replicated) {
  const CaseReplication& replication = replicated.replication;
  const Section4Case& definition = *replication.study.definition;
  const auto views = views_of(definition.name);
  PlotFigure figure;
  figure.title =
      fmt::format("{}: true and identified responses at ratios held out (Fig. {})", definition.name, definition.figure);
  figure.name = fmt::format("fig-{}", definition.figure);
  figure.columns = static_cast<int>(views.size());
  const std::uint64_t seed = replication.scores.front().seed;
  for (const HeldOutRun& run : replication.runs) {
    const std::string ratio = fmt::format("\u03c9/\u03c9\u2099 = {:g}", run.record.ratio);
    std::vector<std::string> values;
    std::string trouble;
    for (const HeldOutScore& score : replication.scores) {
      if (score.seed != seed || score.method != "fast_rvm" || score.kind != "free_run" ||
          score.ratio != run.record.ratio)
        continue;
      if (std::isfinite(score.nmse))
        values.push_back(fmt::format("{} {:.2g}", score.signal, score.nmse));
      else
        trouble = score.status;
    }
    figure.caption.push_back(trouble.empty() ? fmt::format("{}: free-run NMSE {}", ratio, fmt::join(values, ", "))
                                             : fmt::format("{}: no free-run NMSE, {}", ratio, trouble));
    for (const View& view : views) figure.panels.push_back(panel_of(view, run, ratio));
  }
  figure.caption.push_back(
      fmt::format("Identified: mean coefficients of the fast RVM, seed {}; 25 s from rest.", seed));
  return to_svg(figure);
}

}  // namespace apps
