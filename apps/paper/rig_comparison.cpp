#include "apps/paper/rig_comparison.hpp"

#include <fmt/args.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "apps/paper/comparison.hpp"
#include "apps/text/number_text.hpp"
#include "ident/library/expression.hpp"

namespace apps {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

const std::string& regime_of(int table) {
  return std::find_if(rig_regimes().begin(), rig_regimes().end(), [&](const auto& one) { return one.table == table; })
      ->name;
}

/// One period of x = X sin, v = V cos.
dsp::Motion cycle(double x_max, double v_max) {
  constexpr Index n = 360;
  const VectorXd angle = VectorXd::LinSpaced(n, 0.5, n - 0.5) * (2.0 * std::numbers::pi / n);
  dsp::Motion motion;
  motion.signals = {
      {"t", "s", angle}, {"x", "m", x_max * angle.array().sin()}, {"v", "m/s", v_max * angle.array().cos()}};
  return motion;
}

VectorXd values_on(const std::string& term, const dsp::Motion& motion) {
  return ident::Expression(term, {"x", "v"}).evaluate(motion);
}

/// Mean over the seeds; NaN without a term in x, v or ddr.
double damping_of(const JsonRows& fits) {
  double sum = 0.0;
  for (const Json* fit : fits) {
    std::vector<std::pair<std::string, double>> terms;
    std::map<std::string, double> scale{{"x", missing}, {"v", missing}, {"ddr", missing}};
    for (const Json& term : fit->at("terms")) {
      terms.emplace_back(term["name"], term["mean"]);
      scale[term["name"]] = term["scale"];
    }
    sum += damping_over_supply(terms, scale["x"], scale["v"], scale["ddr"]);
  }
  return sum / static_cast<double>(fits.size());
}

/// What an answer on the rig is: that of the paper's recipe.
Json compare_print(const RigReplication& replication, const RigRegime& regime, const Printed& print) {
  const auto answer_by = [&](const RigWay& way) -> Answer {
    const JsonRows fits = rig_fits(replication, regime, way, "paper", print.method);
    if (print.quantity == "seconds") return {.ours = mean_of(fits, "/seconds")};
    if (print.quantity == "nmse") return {.ours = mean_of(fits, "/nmse/" + print.term)};
    const FoundTerm found = found_term(fits, print.term);
    if (print.quantity == "mean") return {.ours = found.mean_scaled, .ours_std = found.std_scaled};
    return {.ours = found.cov};
  };
  Answer answer = answer_by(rig_ways().front());
  if (print.quantity == "mean" || print.quantity == "nmse")
    answer.reason = "T1 matched: " + number_text(answer_by(rig_ways()[2]).ours, "{:.3g}", "not kept");
  Json row = compared(print, answer);
  if (print.quantity == "cov" && print.method == "fast_rvm")
    row["expected"] = printed_value(print.table, print.term, "slow_rvm", "cov") * printed_cov_ratio(print.table).mean;
  return row;
}

using Numbers = std::map<std::string, double>;
using Words = std::map<std::string, std::string>;

/// What the sentences may name.
void put_facts(const RigReplication& replication, const RigRegime& regime, Numbers& numbers, Words& words) {
  const auto by_way = [&](const std::function<std::string(const RigWay&)>& text, const char* between) {
    std::vector<std::string> parts;
    for (const RigWay& way : rig_ways())
      if (const std::string one = text(way); !one.empty()) parts.push_back(way.name + " " + one);
    return fmt::format("{}", fmt::join(parts, between));
  };
  const auto errors = [&](const RigWay& way, const char* candidates) {
    const JsonRows fits = rig_fits(replication, regime, way, candidates);
    return fmt::format("{:.2g}/{:.2g}", mean_of(fits, "/nmse/train"), mean_of(fits, "/nmse/test"));
  };
  words["steps"] =
      by_way([&](const RigWay& way) { return fmt::format("{} ({})", errors(way, "paper"), errors(way, "all")); }, "; ");
  words["damping"] = by_way(
      [&](const RigWay& way) {
        const double ratio = damping_of(rig_fits(replication, regime, way));
        return std::isfinite(ratio) ? fmt::format("{:.2g}", ratio) : "";
      },
      ", ");
  words["friction"] = by_way(
      [&](const RigWay& way) {
        const FoundTerm sgn = found_term(rig_fits(replication, regime, way, "all"), "sgn(v)");
        return sgn.kept > 0 ? fmt::format("{:.3g} m/s^2 (t = {:.0f})", sgn.mean, sgn.t) : "not kept";
      },
      ", ");
  const JsonRows paper = rig_fits(replication, regime, rig_ways().front()),
                 all = rig_fits(replication, regime, rig_ways().front(), "all");
  const auto shown = std::find_if(replication.shown.begin(), replication.shown.end(),
                                  [&](const RigFit& one) { return one.result.spec.name == regime.name; });
  std::vector<std::string> kept;
  for (const std::string& name : words_in(paper_cases(), "rig_terms"))
    if (found_term(all, name).kept > 0) kept.push_back(name);
  words["all_kept"] = fmt::format("{}", fmt::join(kept, ", "));
  numbers["all_test"] = mean_of(all, "/nmse/test");
  numbers["paper_test"] = mean_of(paper, "/nmse/test");
  const VectorXd& target = shown->result.target;
  const Index num_train = std::ssize(shown->result.rows.train);
  numbers["train_rms"] = std::sqrt(target.head(num_train).squaredNorm() / static_cast<double>(num_train));
  numbers["test_rms"] =
      std::sqrt(target.tail(target.size() - num_train).squaredNorm() / static_cast<double>(target.size() - num_train));
  numbers["train_residual"] = std::sqrt(mean_of(paper, "/nmse/train")) * numbers["train_rms"];
  numbers["test_residual"] = std::sqrt(numbers["paper_test"]) * numbers["test_rms"];
  numbers["noise_std"] = mean_of(paper, "/noise_std");
  numbers["constant"] = found_term(paper, "1").mean;
  const CovRatio ratio = printed_cov_ratio(regime.table);
  numbers["cov_ratio"] = ratio.mean;
  numbers["cov_spread"] = 100.0 * ratio.spread;
  numbers["printed_noise"] = 1.0 / ratio.mean;
  numbers["printed_rms"] = ratio.target_rms;
  numbers["printed_damping"] = printed_damping_over_supply(regime.table);
  words["relations"] = replication.relations;
  words["branch"] = regime.name == "high" ? "high" : "low";
  for (const Json& sensors : replication.sensors) {
    if (numbers.contains("power_raw") || !sensors["way"].get<std::string>().starts_with("T1")) continue;
    numbers["power_raw"] = number_in(sensors["power_check"]["raw"].value(words["branch"], Json()));
    numbers["power_corrected"] = number_in(sensors["power_check"]["corrected"].value(words["branch"], Json()));
  }
}

}  // namespace

JsonRows rig_fits(const RigReplication& replication, const RigRegime& regime, const RigWay& way,
                  const std::string& candidates, const std::string& method) {
  return matching(replication.fits,
                  {{"case", regime.case_name()}, {"way", way.name}, {"candidates", candidates}, {"method", method}});
}

double damping_over_supply(const std::vector<std::pair<std::string, double>>& terms, double x_max, double v_max,
                           double ddr_max) {
  const dsp::Motion motion = cycle(x_max, v_max);
  const VectorXd& v = motion.at("v");
  double taken = 0.0, supply = 0.0;
  for (const auto& [name, coefficient] : terms) {
    if (name == "ddr")
      supply = 0.5 * std::abs(coefficient) * ddr_max * v_max;  // in phase with v, the most there is
    else
      taken -= coefficient * values_on(name, motion).dot(v) / static_cast<double>(v.size());
  }
  return supply > 0.0 ? taken / supply : missing;
}

double printed_damping_over_supply(int table) {
  const dsp::Motion motion = cycle(1.0, 1.0);
  std::vector<std::pair<std::string, double>> terms;
  for (const Printed& print : printed_numbers()) {
    if (print.table != table || print.method != "fast_rvm" || print.quantity != "mean") continue;
    const double largest = print.term == "ddr" ? 1.0 : values_on(print.term, motion).cwiseAbs().maxCoeff();
    terms.emplace_back(print.term, print.value / largest);
  }
  return damping_over_supply(terms, 1.0, 1.0, 1.0);
}

CovRatio printed_cov_ratio(int table) {
  std::vector<double> ratios;
  for (const Printed& print : printed_numbers())
    if (print.table == table && print.method == "fast_rvm" && print.quantity == "cov")
      ratios.push_back(print.value / printed_value(table, print.term, "slow_rvm", "cov"));
  const auto [least, greatest] = std::minmax_element(ratios.begin(), ratios.end());
  const double mean = Eigen::Map<const VectorXd>(ratios.data(), std::ssize(ratios)).mean();
  return {mean, *greatest / *least - 1.0,
          1.0 / mean / std::sqrt(printed_value(9, "train", "fast_rvm", "nmse", regime_of(table)))};
}

Json compare_rig(const RigReplication& replication, const std::vector<RigRegime>& regimes) {
  Json rows = Json::array();
  for (const RigRegime& regime : regimes)
    for (const Printed& print : printed_numbers())
      if (print.table == regime.table || (print.table == 9 && print.row == regime.name))
        rows.push_back(compare_print(replication, regime, print));
  return rows;
}

std::vector<std::string> rig_differences(const RigReplication& replication, const RigRegime& regime) {
  Numbers numbers;
  Words words;
  put_facts(replication, regime, numbers, words);
  fmt::dynamic_format_arg_store<fmt::format_context> facts;
  for (const auto& [name, value] : numbers) facts.push_back(fmt::arg(name.c_str(), value));
  for (const auto& [name, value] : words) facts.push_back(fmt::arg(name.c_str(), value));
  std::vector<std::string> sentences;
  for (const dsp::Settings& one : paper_sentences().tables("difference")) {
    const auto regimes = words_in(one, "regimes");
    const bool other = !regimes.empty() && std::count(regimes.begin(), regimes.end(), regime.name) == 0;
    const std::string needs = one.text("needs").value_or("");
    if (!other && (needs.empty() || std::isfinite(numbers[needs])))
      sentences.push_back(fmt::vformat(one.text("text").value(), facts));
  }
  return sentences;
}

}  // namespace apps
