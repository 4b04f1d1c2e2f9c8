#include "apps/paper/section5_comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "ident/library/expression.hpp"

namespace apps {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double error_factor = 1.5, size_factor = 2.0;

double printed(const PaperTerm& paper, const std::string& method) {
  return method == "fast_rvm" ? paper.fast_rvm : method == "slow_rvm" ? paper.slow_rvm : paper.sindy;
}

/// One period of x = X sin, v = V cos.
dsp::Motion cycle(double x_max, double v_max) {
  constexpr Index n = 360;
  const VectorXd angle = VectorXd::LinSpaced(n, 0.5, n - 0.5) * (2.0 * std::numbers::pi / n);
  dsp::Motion motion{.sample_rate_hz = 1.0};
  motion.signals = {{"t", "s", VectorXd::LinSpaced(n, 0.0, n - 1.0)},
                    {"x", "m", x_max * angle.array().sin()},
                    {"v", "m/s", v_max * angle.array().cos()}};
  return motion;
}

VectorXd values_on(const std::string& term, const dsp::Motion& motion) {
  return ident::Expression(term, {"x", "v"}).evaluate(motion);
}

template <class Value>
double mean_over(const std::vector<const ident::JudgedFit*>& fits, Value&& value) {
  double sum = 0.0;
  for (const ident::JudgedFit* fit : fits) sum += value(*fit);
  return fits.empty() ? nan : sum / static_cast<double>(fits.size());
}

const ident::ModelTerm* find(const ident::JudgedFit& fit, const std::string& name) {
  for (const ident::ModelTerm& term : fit.model.terms)
    if (term.name == name) return &term;
  return nullptr;
}

}  // namespace

std::string judge_size(double paper, double ours, double factor) {
  if (!std::isfinite(ours)) return "none";
  const double ratio = ours / paper;
  return ratio > factor ? "larger" : ratio < 1.0 / factor ? "smaller" : "same size";
}

std::string judge_scaled(double paper, double ours) {
  if (!std::isfinite(ours)) return "not kept";
  if (paper * ours < 0.0) return "other sign";
  return judge_size(paper, ours, size_factor) == "same size" ? "same sign and size" : "same sign";
}

Section5View::Section5View(const Section5Replication& replication, const Section5Case& definition,
                           const Section5Way& way, const std::string& candidates) {
  for (const Section5Fit& fit : replication.fits)
    if (fit.definition == &definition && fit.way == &way && fit.candidates == candidates) fits_.push_back(&fit);
}

std::vector<const ident::JudgedFit*> Section5View::fits(const std::string& method) const {
  std::vector<const ident::JudgedFit*> result;
  for (const Section5Fit* fit : fits_)
    for (const ident::JudgedFit& judged : fit->result.fits)
      if (to_string(judged.fit.method) == method) result.push_back(&judged);
  return result;
}

FoundTerm Section5View::term(const std::string& method, const std::string& name) const {
  FoundTerm found;
  const auto all = fits(method);
  found.fits = static_cast<int>(all.size());
  for (const ident::JudgedFit* fit : all)
    if (const ident::ModelTerm* term = find(*fit, name)) {
      found.mean += term->mean;
      found.std += term->std;
      found.mean_scaled += term->mean * term->scale;
      found.std_scaled += term->std * term->scale;
      found.cov += term->coefficient_of_variation();
      found.t += term->t();
      found.unit = term->unit;
      ++found.kept;
    }
  for (double* value : {&found.mean, &found.std, &found.mean_scaled, &found.std_scaled, &found.cov, &found.t})
    *value = found.kept > 0 ? *value / found.kept : nan;
  return found;
}

FoundErrors Section5View::errors(const std::string& method) const {
  const auto all = fits(method);
  FoundErrors found;
  found.train = mean_over(all, [](const ident::JudgedFit& fit) { return fit.train.value; });
  found.test = mean_over(all, [](const ident::JudgedFit& fit) { return fit.test.value; });
  found.free_run = mean_over(all, [](const ident::JudgedFit& fit) { return fit.free_run.nmse; });
  found.noise_std = mean_over(all, [](const ident::JudgedFit& fit) { return fit.model.noise_std; });
  found.seconds = mean_over(all, [](const ident::JudgedFit& fit) { return fit.solve_s; });
  for (const Section5Fit* fit : fits_) found.seconds += fit->result.accumulate_s / static_cast<double>(fits_.size());
  return found;
}

std::vector<std::string> Section5View::kept(const std::string& method) const {
  std::vector<std::string> names;
  if (fits_.empty()) return names;
  for (const std::string& name : fits_.front()->result.terms)
    if (term(method, name).kept > 0) names.push_back(name);
  return names;
}

double Section5View::target_rms(bool train) const {
  if (fits_.empty()) return nan;
  const ident::RangeResult& result = fits_.front()->result;
  const auto num_train = static_cast<Index>(result.rows.train.size());
  const VectorXd rows = train ? result.target.head(num_train) : result.target.tail(result.target.size() - num_train);
  return std::sqrt(rows.squaredNorm() / static_cast<double>(rows.size()));
}

double Section5View::damping_over_supply(const std::string& method) const {
  return mean_over(fits(method), [](const ident::JudgedFit& fit) {
    const ident::ModelTerm *x = find(fit, "x"), *v = find(fit, "v"), *ddr = find(fit, "ddr");
    if (x == nullptr || v == nullptr || ddr == nullptr) return nan;
    std::vector<std::pair<std::string, double>> terms;
    for (const ident::ModelTerm& term : fit.model.terms) terms.emplace_back(term.name, term.mean);
    return apps::damping_over_supply(terms, x->scale, v->scale, ddr->scale);
  });
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
  return supply > 0.0 ? taken / supply : nan;
}

double printed_damping_over_supply(int table) {
  const dsp::Motion motion = cycle(1.0, 1.0);
  std::vector<std::pair<std::string, double>> terms;
  for (const PaperTerm& paper : paper_terms()) {
    if (paper.table != table) continue;
    const std::string name = paper.term;
    terms.emplace_back(name,
                       name == "ddr" ? paper.fast_rvm : paper.fast_rvm / values_on(name, motion).cwiseAbs().maxCoeff());
  }
  return damping_over_supply(terms, 1.0, 1.0, 1.0);
}

CovRatio printed_cov_ratio(int table) {
  double sum = 0.0, least = HUGE_VAL, greatest = 0.0, train = nan;
  int count = 0;
  for (const PaperTerm& paper : paper_terms()) {
    if (paper.table != table) continue;
    const double ratio = paper.cov_fast_rvm / paper.cov_slow_rvm;
    sum += ratio;
    least = std::min(least, ratio);
    greatest = std::max(greatest, ratio);
    ++count;
  }
  for (const PaperErrors& paper : paper_errors())
    if (paper.table == table) train = paper.train[0];
  const double mean = sum / count;
  return {mean, greatest / least - 1.0, 1.0 / mean / std::sqrt(train)};
}

namespace {

/// Rows of Table 9: errors of every method, by the paper's recipe and, as the reason, with matched columns.
void compare_errors(const PaperErrors& paper, const std::string& regime, const Section5View& ours,
                    const Section5View& matched, std::vector<Comparison>& rows) {
  for (int m = 0; m < 3; ++m)
    for (const bool train : {true, false}) {
      const std::string method = section5_methods[m];
      const FoundErrors found = ours.errors(method), other = matched.errors(method);
      const double print = train ? paper.train[m] : paper.test[m], value = train ? found.train : found.test;
      rows.push_back({9,
                      regime,
                      train ? "train" : "test",
                      method,
                      "nmse",
                      print,
                      nan,
                      value,
                      nan,
                      {judge_size(print, value, error_factor),
                       fmt::format("T1 matched: {:.3g}", train ? other.train : other.test)}});
    }
}

/// Rows of a printed term: its coefficient by every method, and its two coefficients of variation.
void compare_term(const PaperTerm& paper, const Section5View& ours, const Section5View& matched,
                  std::vector<Comparison>& rows) {
  const auto with = [](double value) { return std::isfinite(value) ? fmt::format("{:.3g}", value) : "not kept"; };
  for (const char* method : section5_methods) {
    const double print = printed(paper, method);
    if (!std::isfinite(print)) continue;
    const FoundTerm found = ours.term(method, paper.term);
    rows.push_back({paper.table,
                    "a",
                    paper.term,
                    method,
                    "mean",
                    print,
                    nan,
                    found.mean_scaled,
                    found.std_scaled,
                    {judge_scaled(print, found.mean_scaled),
                     "T1 matched: " + with(matched.term(method, paper.term).mean_scaled)}});
  }
  const double slow = ours.term("slow_rvm", paper.term).cov, fast = ours.term("fast_rvm", paper.term).cov;
  rows.push_back({paper.table,
                  "a",
                  paper.term,
                  "slow_rvm",
                  "cov",
                  paper.cov_slow_rvm,
                  nan,
                  slow,
                  nan,
                  {judge_size(paper.cov_slow_rvm, slow, size_factor), ""}});
  rows.push_back({paper.table,
                  "a",
                  paper.term,
                  "fast_rvm",
                  "cov",
                  paper.cov_fast_rvm,
                  paper.cov_slow_rvm * printed_cov_ratio(paper.table).mean,
                  fast,
                  nan,
                  {"not reproducible", "not an uncertainty: the noise's standard deviation is left out"}});
}

void compare_seconds(const PaperSeconds& paper, const Section5View& ours, std::vector<Comparison>& rows) {
  for (const auto& [method, print] :
       {std::pair{"fast_rvm", paper.fast_rvm}, {"slow_rvm", paper.slow_rvm}, {"sindy", paper.sindy}})
    rows.push_back({paper.table,
                    "a",
                    "",
                    method,
                    "seconds",
                    print,
                    nan,
                    ours.errors(method).seconds,
                    nan,
                    {"not reproducible", "another machine and another program"}});
}

}  // namespace

std::vector<Comparison> compare_section5(const Section5Replication& replication,
                                         const std::vector<const Section5Case*>& cases) {
  std::vector<Comparison> rows;
  const Section5Way &paper_way = section5_ways().front(), &matched_way = section5_ways()[2];
  for (const Section5Case* one : cases) {
    const Section5View ours(replication, *one, paper_way, paper_candidates),
        matched(replication, *one, matched_way, paper_candidates);
    for (const PaperErrors& paper : paper_errors())
      if (paper.table == one->table) compare_errors(paper, one->regime, ours, matched, rows);
    for (const PaperTerm& paper : paper_terms())
      if (paper.table == one->table) compare_term(paper, ours, matched, rows);
    for (const PaperSeconds& paper : paper_seconds())
      if (paper.table == one->table) compare_seconds(paper, ours, rows);
  }
  return rows;
}

}  // namespace apps
