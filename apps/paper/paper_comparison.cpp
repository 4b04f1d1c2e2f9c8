#include "apps/paper/paper_comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <stdexcept>

#include "apps/paper/printed_equation.hpp"
#include "apps/paper/printed_free_run.hpp"

namespace apps {
namespace {

using Eigen::Index;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

struct RowIndex {
  std::size_t regression = 0, row = 0;
};

std::optional<RowIndex> row_index_of(const Section4Study& study, const PaperTerm& paper) {
  for (std::size_t g = 0; g < study.regressions.size(); ++g)
    for (std::size_t j = 0; j < study.regressions[g].rows.size(); ++j) {
      const Section4Row& row = study.regressions[g].rows[j];
      if (row.row == paper.row && row.where == paper.where) return RowIndex{g, j};
    }
  return std::nullopt;
}

struct Expected {
  double mean = 0.0, std = 0.0;
};

Expected expected_of(const Section4Study& study, const PaperTerm& paper, const std::string& method,
                     RowIndex row_index) {
  const Section4Regression& regression = study.regressions[row_index.regression];
  const PrintedRow row = printed_row(study, regression, regression.rows[row_index.row], method);
  const Index j = row.position_of(column_of(study, paper.term));
  return {row.expected(j), row.root.row(j).norm()};
}

// The samples of a regression outside the training record that goes furthest from x = 0, and that record's ratio.
struct Milder {
  double left_out_ratio = 0.0;
  std::vector<Index> rows;  // of the regression
  double target_std = 0.0;  // over what is left of the training set
};
Milder without_widest_record(const Section4Study& study, const Section4Regression& regression, const Section4Row& row) {
  const std::vector<double>& ratios = study.definition->training_ratios;
  const Index length = study.training.num_samples() / static_cast<Index>(ratios.size());
  Index widest = 0;
  study.training.at("x").cwiseAbs().maxCoeff(&widest);
  widest /= length;
  Milder milder{ratios[static_cast<std::size_t>(widest)], {}, 0.0};
  for (std::size_t i = 0; i < regression.samples.size(); ++i)
    if (regression.samples[i] / length != widest) milder.rows.push_back(static_cast<Index>(i));
  const Eigen::VectorXd& whole = study.training.at(row.target);
  Eigen::VectorXd rest(whole.size() - length);
  rest << whole.head(widest * length), whole.tail(whole.size() - (widest + 1) * length);
  milder.target_std = std::sqrt((rest.array() - rest.mean()).square().mean());
  return milder;
}

// A print that its stated origin cannot give, held against another origin.
std::string explanation_of(const Section4Study& study, const PaperTerm& paper, const std::string& method,
                           RowIndex row_index) {
  const Section4Regression& regression = study.regressions[row_index.regression];
  const Section4Row& row = regression.rows[row_index.row];
  std::vector<Index> kept = printed_row(study, regression, row, method).terms;
  Expected other;
  std::string origin;
  if (row.truth_known) {
    const Milder milder = without_widest_record(study, regression, row);
    Section4Regression rest;
    rest.phi = regression.phi(milder.rows, Eigen::all);
    rest.rows.push_back(row);
    rest.rows.front().values = row.values(milder.rows);
    const Index j = std::find(kept.begin(), kept.end(), column_of(study, paper.term)) - kept.begin();
    other = {row.truth(column_of(study, paper.term)), unit_stds(rest, kept)(j) * stated_noise * milder.target_std};
    origin =
        fmt::format("a training set without the record at ratio {:g}, the one with large x", milder.left_out_ratio);
  } else {
    for (const char* beside : {"v^2", "abs(x)*v"})
      if (const Index column = column_of(study, beside); std::find(kept.begin(), kept.end(), column) == kept.end())
        kept.push_back(column);
    const Index j = std::find(kept.begin(), kept.end(), column_of(study, paper.term)) - kept.begin();
    other = {ident::fit_ols(ident::r_factor(regression.phi(Eigen::all, kept), row.values)).mean(j),
             unit_stds(regression, kept)(j) * stated_noise * row.std};
    origin = "a fit with v^2 and |x| v beside the printed terms, dropped without a refit";
  }
  const double off = (paper.printed(method) - other.mean) / other.std;
  return fmt::format(
      "{:+.2g} from that of {}{}", off, origin,
      std::abs(off) <= stds_allowed ? ", which would explain the print" : ", which explains it no better");
}

// Means over the seeds whose fit by `method` keeps the term.
struct Found {
  double mean = nan, std = nan, cov = nan;
};
Found found_by(const CaseReplication& replication, RowIndex row_index, Index column, const std::string& method) {
  double mean = 0.0, std_sum = 0.0, cov = 0.0;
  int count = 0;
  for (const CaseFit& fit : replication.fits) {
    if (fit.regression != row_index.regression || fit.row != row_index.row || fit.method != method) continue;
    const auto& kept = fit.fit.relevant;
    const auto at = std::lower_bound(kept.begin(), kept.end(), column);
    if (at == kept.end() || *at != column) continue;
    const Index j = at - kept.begin();
    const double sd = std::sqrt(fit.fit.covariance(j, j));
    mean += fit.fit.mean(j);
    std_sum += sd;
    cov += sd / std::abs(fit.fit.mean(j));
    ++count;
  }
  if (count == 0) return {};
  return {mean / count, std_sum / count, cov / count};
}

Comparison compare_mean(const CaseReplication& replication, const PaperTerm& paper, RowIndex row_index,
                        const std::string& method) {
  const Section4Row& row = replication.study.regressions[row_index.regression].rows[row_index.row];
  const Index column = column_of(replication.study, paper.term);
  const Expected expected = expected_of(replication.study, paper, method, row_index);
  const bool false_term = row.truth_known && row.truth(column) == 0.0;
  const Found found = found_by(replication, row_index, column, false_term ? "sindy_raw" : method);
  const double printed = paper.printed(method);
  PaperVerdict verdict = judge_coefficient(printed, expected.mean, expected.std);
  if (row.truth_known && !false_term && std::isnan(found.mean) && verdict.verdict == "within noise")
    verdict = {"not reproducible",
               fmt::format("no fit keeps the term at this noise: {:.1f} standard deviations gain less "
                           "evidence than tau asks",
                           std::abs(expected.mean / expected.std))};
  else if (verdict.verdict == "not reproducible")
    verdict.reason += "; " + explanation_of(replication.study, paper, method, row_index);
  return {paper.table, row.label(),   paper.term, method,    "mean",
          printed,     expected.mean, found.mean, found.std, std::move(verdict)};
}

Comparison compare_cov(const CaseReplication& replication, const PaperTerm& paper, RowIndex row_index,
                       const std::string& method) {
  const Section4Row& row = replication.study.regressions[row_index.regression].rows[row_index.row];
  const bool fast = method == "fast_rvm";
  const double printed = fast ? paper.cov_fast_rvm : paper.cov_slow_rvm;
  const double expected =
      expected_cov(paper.printed(method), expected_of(replication.study, paper, method, row_index).std);
  const double noise = stated_noise * row.std;
  PaperVerdict verdict = judge_cov(printed, fast ? expected / noise : expected);
  if (fast && verdict.verdict == "within noise")
    verdict = {
        "not reproducible",
        fmt::format("not an uncertainty: the noise's standard deviation {:.3g} is left out; {:.2g} / {:.3g} = {:.2g}",
                    noise, expected, noise, expected / noise)};
  else if (fast)
    verdict.reason += fmt::format(", even with the noise's standard deviation {:.3g} left out", noise);
  const Found found = found_by(replication, row_index, column_of(replication.study, paper.term), method);
  return {paper.table, row.label(), paper.term, method, "cov", printed, expected, found.cov, nan, std::move(verdict)};
}

void compare_seconds(const CaseReplication& replication, std::vector<Comparison>& comparisons) {
  for (const PaperSeconds& paper : paper_seconds()) {
    if (paper.table != replication.study.definition->table) continue;
    for (const auto& [method, seconds] :
         {std::pair{"fast_rvm", paper.fast_rvm}, {"slow_rvm", paper.slow_rvm}, {"sindy", paper.sindy}}) {
      double sum = 0.0;
      std::set<std::uint64_t> seeds;
      for (const CaseFit& fit : replication.fits) {
        if (fit.method != method) continue;
        sum += fit.seconds;
        seeds.insert(fit.seed);
      }
      const double ours = sum / static_cast<double>(seeds.size()) + replication.accumulate_seconds;
      comparisons.push_back({paper.table,
                             "",
                             "",
                             method,
                             "seconds",
                             seconds,
                             nan,
                             ours,
                             nan,
                             {"not reproducible", "another machine and another program"}});
    }
  }
}

}  // namespace

std::vector<Comparison> compare_with_paper(const CaseReplication& replication) {
  std::vector<Comparison> comparisons;
  for (const PaperTerm& paper : paper_terms()) {
    if (paper.table != replication.study.definition->table) continue;
    const auto row_index = row_index_of(replication.study, paper);
    if (!row_index) throw std::logic_error("compare_with_paper: no such row");
    for (const char* method : {"fast_rvm", "slow_rvm", "sindy"})
      if (std::isfinite(paper.printed(method)))
        comparisons.push_back(compare_mean(replication, paper, *row_index, method));
    for (const char* method : {"slow_rvm", "fast_rvm"})
      if (std::isfinite(paper.cov_slow_rvm)) comparisons.push_back(compare_cov(replication, paper, *row_index, method));
  }
  for (Comparison& run : compare_free_runs(replication)) comparisons.push_back(std::move(run));
  compare_seconds(replication, comparisons);
  return comparisons;
}

}  // namespace apps
