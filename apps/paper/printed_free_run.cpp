#include "apps/paper/printed_free_run.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "apps/paper/free_response.hpp"
#include "apps/paper/printed_equation.hpp"
#include "dsp/order_statistics.hpp"

namespace apps {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// All that one method printed for a case.
struct PrintedEquations {
  const Section4Study& study;
  std::vector<const Section4Row*> rows;
  std::vector<PrintedRow> printed;  ///< one for each row

  PrintedEquations(const Section4Study& of, const std::string& method) : study(of) {
    for (const Section4Regression& regression : study.regressions)
      for (const Section4Row& row : regression.rows) {
        rows.push_back(&row);
        printed.push_back(printed_row(study, regression, row, method));
      }
  }
  [[nodiscard]] std::vector<std::vector<Index>> terms() const {
    std::vector<std::vector<Index>> each;
    for (const PrintedRow& row : printed) each.push_back(row.terms);
    return each;
  }
  [[nodiscard]] std::vector<VectorXd> coefficients(VectorXd PrintedRow::*which) const {
    std::vector<VectorXd> each;
    for (const PrintedRow& row : printed) each.push_back(row.*which);
    return each;
  }
  [[nodiscard]] sim::Simulation run(const std::vector<VectorXd>& coefficients, const Section4Record& record) const {
    std::vector<ident::StateEquation> equations;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      equations.push_back({static_cast<std::size_t>(rows[i]->row - 1),
                           {},
                           {coefficients[i].begin(), coefficients[i].end()},
                           rows[i]->where});
      for (const Index term : printed[i].terms)
        equations.back().terms.push_back(study.library.terms[static_cast<std::size_t>(term)].name);
    }
    return free_response(*study.definition, equations, record);
  }
};

/// Mean NMSE of each state over draws of the stated noise; NaN where the expected equations diverge, infinite where an
/// error of a standard deviation makes them.
std::vector<double> expected_nmse(const PrintedEquations& equations, const Section4Record& record) {
  const std::vector<VectorXd> expected = equations.coefficients(&PrintedRow::expected);
  const sim::Simulation base = equations.run(expected, record);
  std::vector<double> sums;
  for (const StateError& error : state_errors(base, *equations.study.definition, record)) sums.push_back(error.nmse);
  if (base.status != sim::SimulationStatus::finished) return sums;
  for (std::size_t i = 0; i < expected.size(); ++i)
    for (Index c = 0; c < equations.printed[i].root.cols(); ++c) {
      std::vector<VectorXd> moved = expected;
      moved[i] += equations.printed[i].root.col(c);
      const sim::Simulation run = equations.run(moved, record);
      if (run.status != sim::SimulationStatus::finished) return std::vector<double>(sums.size(), INFINITY);
      for (std::size_t j = 0; j < sums.size(); ++j) {
        const auto state = static_cast<Index>(j);
        sums[j] += (run.states.col(state) - base.states.col(state)).squaredNorm() /
                   record.simulation.states.col(state).squaredNorm();
      }
    }
  return sums;
}

double median_of_ours(const CaseReplication& replication, const std::string& method, double ratio,
                      const std::string& signal) {
  std::vector<double> values;
  for (const HeldOutScore& score : replication.scores)
    if (score.kind == "free_run" && score.method == method && score.ratio == ratio && score.signal == signal)
      values.push_back(std::isfinite(score.nmse) ? score.nmse : INFINITY);
  const double median = values.empty() ? nan : dsp::median(values);
  return std::isfinite(median) ? median : nan;
}

/// True terms that are printed and that none of our fits by this method keeps.
std::vector<std::string> terms_we_lack(const CaseReplication& replication, const PrintedEquations& equations,
                                       const std::string& method) {
  std::vector<std::string> lacking;
  for (std::size_t i = 0; i < equations.rows.size(); ++i)
    for (const Index term : equations.printed[i].terms) {
      const Section4Row& row = *equations.rows[i];
      const bool kept = std::any_of(replication.fits.begin(), replication.fits.end(), [&](const CaseFit& fit) {
        const auto& relevant = fit.fit.relevant;
        return fit.method == method && &replication.row_of(fit) == &row &&
               std::find(relevant.begin(), relevant.end(), term) != relevant.end();
      });
      if (row.truth_known && row.truth(term) != 0.0 && !kept)
        lacking.push_back(replication.study.library.terms[static_cast<std::size_t>(term)].name);
    }
  return lacking;
}

PaperVerdict judge_free_run(double printed, double expected, const std::vector<std::string>& lacking) {
  const char* out = "not reproducible";
  if (std::isnan(expected))
    return {out, std::isfinite(printed) ? "the noise-free fit of its terms diverges"
                                        : "it diverges, and so does the noise-free fit of its terms"};
  if (!std::isfinite(printed)) return {out, "it diverges; the noise-free fit of its terms does not"};
  if (!lacking.empty()) return {out, fmt::format("no fit of ours keeps {} at this noise", fmt::join(lacking, ", "))};
  // Coefficients that are n standard deviations off err n^2 times as much.
  if (printed <= stds_allowed * stds_allowed * expected) return {"within noise", ""};
  return {out, fmt::format("{:.3g} times what the stated noise gives on average", printed / expected)};
}

}  // namespace

std::vector<Comparison> compare_free_runs(const CaseReplication& replication) {
  const Section4Study& study = replication.study;
  std::vector<Comparison> comparisons;
  std::map<std::pair<std::vector<std::vector<Index>>, double>, std::vector<double>> expected;  // by terms and ratio
  for (const char* method : {"fast_rvm", "slow_rvm", "sindy"}) {
    const PrintedEquations equations(study, method);
    const std::vector<std::string> lacking = terms_we_lack(replication, equations, method);
    for (const HeldOutRun& held_out : replication.runs) {
      const Section4Record& record = held_out.record;
      const auto errors =
          state_errors(equations.run(equations.coefficients(&PrintedRow::printed), record), *study.definition, record);
      std::vector<double>& means = expected[{equations.terms(), record.ratio}];
      if (means.empty()) means = expected_nmse(equations, record);
      for (std::size_t j = 0; j < errors.size(); ++j)
        comparisons.push_back({study.definition->table, "", errors[j].signal, method, "free_run", errors[j].nmse,
                               means[j], median_of_ours(replication, method, record.ratio, errors[j].signal), nan,
                               judge_free_run(errors[j].nmse, means[j], lacking), record.ratio});
    }
  }
  return comparisons;
}

}  // namespace apps
