#include "apps/paper/comparison.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "apps/text/json_number.hpp"
#include "dsp/values/order_statistics.hpp"

namespace apps {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double stds_allowed = 5.0;  // of a coefficient; errors of a free run grow with their square

/// What the paper prints for one row by one method, and what the stated method gives for the same terms.
struct PrintedRow {
  const Section4Row* row;
  std::vector<Index> terms;  // of the case's library; those printed come first
  VectorXd printed, expected;
  Eigen::MatrixXd root;  // L of the covariance L L^T of an estimate under the stated noise
  /// What is expected of a term, with its standard deviation.
  [[nodiscard]] std::pair<double, double> expected_of(Index term) const {
    const Index j = std::find(terms.begin(), terms.end(), term) - terms.begin();
    return {expected(j), root.row(j).norm()};
  }
};
using PrintedRows = std::vector<PrintedRow>;  // of all equations of a case, by one method

/// `beside`: terms fitted beside those printed.
PrintedRows printed_rows(const Section4Study& study, const std::string& method,
                         const std::vector<std::string>& beside = {}) {
  PrintedRows rows;
  for (const Section4Regression& regression : study.regressions)
    for (const Section4Row& row : regression.rows) {
      PrintedRow one{&row, {}, {}, {}, {}};
      std::vector<double> printed;
      for (const Printed& print : printed_numbers()) {
        if (print.table != study.definition->table || print.row != row.label() || print.method != method) continue;
        if (print.quantity != "mean") continue;
        one.terms.push_back(column_of(study, print.term));
        printed.push_back(print.value);
      }
      one.printed = Eigen::Map<const VectorXd>(printed.data(), std::ssize(printed));
      for (const std::string& name : beside)
        if (const Index term = column_of(study, name); std::count(one.terms.begin(), one.terms.end(), term) == 0)
          one.terms.push_back(term);
      one.expected = row.truth_known
                         ? VectorXd(row.truth(one.terms))
                         : ident::fit_ols(ident::r_factor(regression.phi(Eigen::all, one.terms), row.values)).mean;
      one.root = unit_root(regression, one.terms) * stated_noise() * row.std;
      rows.push_back(std::move(one));
    }
  return rows;
}

const PrintedRow& row_named(const PrintedRows& rows, const std::string& label) {
  return *std::find_if(rows.begin(), rows.end(), [&](const PrintedRow& one) { return one.row->label() == label; });
}

/// A case as far as a printed number is concerned.
struct CaseView {
  const CaseReplication& replication;
  const Section4Study& study = replication.study;
  std::map<std::string, PrintedRows> printed, otherwise = {};  // by method; otherwise: from the other origin
  [[nodiscard]] JsonRows fits(const std::string& row, const std::string& method) const {
    return matching(replication.document.at("fits"), {{"row", row}, {"method", method}});
  }
};

Json compare_mean(const CaseView& view, const Printed& print) {
  const PrintedRow& equation = row_named(view.printed.at(print.method), print.row);
  const Index term = column_of(view.study, print.term);
  const bool false_term = equation.row->truth_known && equation.row->truth(term) == 0.0;
  const FoundTerm found = found_term(view.fits(print.row, false_term ? "sindy_raw" : print.method), print.term);
  const auto [expected, std] = equation.expected_of(term);
  Answer answer{expected, std, found.mean, found.std, false_term ? reason("false_term") : ""};
  const bool agrees = verdict_on(print, answer) == "within noise", kept = found.kept > 0 || false_term;
  if (!agrees) answer.reason = reason("off", fmt::arg("off", std::abs(print.value - expected) / std));
  if (!agrees && !view.otherwise.empty()) {
    const auto [other, other_std] = row_named(view.otherwise.at(print.method), print.row).expected_of(term);
    const double off = (print.value - other) / other_std;
    answer.reason += reason(std::abs(off) <= print.tolerance ? "explained" : "not_explained", fmt::arg("off", off),
                            fmt::arg("origin", view.study.definition->otherwise));
  }
  Json row = compared(print, answer);
  if (agrees && !kept && equation.row->truth_known)
    row["verdict"] = "not reproducible", row["reason"] = reason("too_weak", fmt::arg("t", std::abs(expected / std)));
  return row;
}

/// Those of the fast RVM leave the noise's standard deviation out and are no uncertainties, however well they agree.
Json compare_cov(const CaseView& view, const Printed& print) {
  const PrintedRow& equation = row_named(view.printed.at(print.method), print.row);
  const Index term = column_of(view.study, print.term);
  const double mean = printed_value(print.table, print.term, print.method, "mean", print.row);
  const double cov = expected_cov(mean, equation.expected_of(term).second), noise = stated_noise() * equation.row->std;
  const bool fast = print.method == "fast_rvm";
  const double expected = fast ? cov / noise : cov;
  const FoundTerm found = found_term(view.fits(print.row, print.method), print.term);
  Json row = compared(print, {.expected = expected, .expected_std = expected, .ours = found.cov});
  row["expected"] = number_or_null(cov);
  const auto numbers = [&](const char* name) {
    return reason(name, fmt::arg("expected", expected), fmt::arg("noise", noise), fmt::arg("cov", cov),
                  fmt::arg("remark", print.remark));
  };
  if (row["verdict"] != "within noise")
    row["reason"] =
        numbers(row["verdict"] == "misprint" ? "misprint" : "cov") + (fast ? numbers("even_without_noise") : "");
  else if (fast)
    row["verdict"] = "not reproducible", row["reason"] = numbers("cov_without_noise");
  return row;
}

sim::Simulation run_printed(const CaseView& view, const PrintedRows& rows, const std::vector<VectorXd>& coefficients,
                            const Section4Record& record) {
  std::vector<ident::StateEquation> equations;
  for (std::size_t i = 0; i < rows.size(); ++i)
    equations.push_back(state_equation(view.study, *rows[i].row, rows[i].terms, coefficients[i]));
  return free_response(*view.study.definition, equations, record);
}

std::vector<VectorXd> coefficients_of(const PrintedRows& rows, VectorXd PrintedRow::*which) {
  std::vector<VectorXd> coefficients;
  for (const PrintedRow& row : rows) coefficients.push_back(row.*which);
  return coefficients;
}

/// Mean NMSE of each state over draws of the stated noise: that of the expected equations and what a standard deviation
/// of each independent error adds. NaN where the expected equations diverge, infinite where such an error makes them.
VectorXd expected_nmse(const CaseView& view, const PrintedRows& rows, const Section4Record& record) {
  const auto expected = coefficients_of(rows, &PrintedRow::expected);
  const sim::Simulation base = run_printed(view, rows, expected, record);
  VectorXd sums(view.study.definition->num_rows());
  for (Index state = 0; state < sums.size(); ++state) sums(state) = state_error(base, record, state);
  for (std::size_t i = 0; i < rows.size() && base.reason.empty(); ++i)
    for (Index c = 0; c < rows[i].root.cols(); ++c) {
      auto moved = expected;
      moved[i] += rows[i].root.col(c);
      const sim::Simulation run = run_printed(view, rows, moved, record);
      if (!run.reason.empty()) return VectorXd::Constant(sums.size(), INFINITY);
      for (Index state = 0; state < sums.size(); ++state)
        sums(state) += (run.states.col(state) - base.states.col(state)).squaredNorm() /
                       record.simulation.states.col(state).squaredNorm();
    }
  return sums;
}

double median_of_ours(const CaseView& view, const std::string& method, double ratio, const std::string& signal) {
  std::vector<double> values;
  for (const Json* run :
       matching(view.replication.document.at("free_run"), {{"method", method}, {"ratio", ratio}, {"signal", signal}})) {
    const double nmse = number_in(run->at("nmse"));
    values.push_back(std::isfinite(nmse) ? nmse : INFINITY);
  }
  const double median = values.empty() ? missing : dsp::median(values);
  return std::isfinite(median) ? median : missing;
}

/// True terms that are printed and that none of our fits by this method keeps.
std::vector<std::string> terms_we_lack(const CaseView& view, const PrintedRows& rows, const std::string& method) {
  std::vector<std::string> lacking;
  for (const PrintedRow& row : rows)
    for (const std::string& name : names_of(view.study, row.terms))
      if (row.row->truth_known && row.row->truth(column_of(view.study, name)) != 0.0 &&
          found_term(view.fits(row.row->label(), method), name).kept == 0)
        lacking.push_back(name);
  return lacking;
}

std::string reason_of_run(double printed, double expected, const std::vector<std::string>& lacking) {
  if (std::isnan(expected)) return reason(std::isnan(printed) ? "both_diverge" : "fit_diverges");
  if (std::isnan(printed)) return reason("print_diverges");
  if (!lacking.empty()) return reason("lacking", fmt::arg("terms", fmt::format("{}", fmt::join(lacking, ", "))));
  const double ratio = printed / expected;
  return ratio <= stds_allowed * stds_allowed ? "" : reason("free_run", fmt::arg("ratio", ratio));
}

void compare_free_runs(const CaseView& view, Json& rows) {
  const Section4Case& definition = *view.study.definition;
  for (const char* method : paper_methods) {
    const PrintedRows& printed = view.printed.at(method);
    const auto lacking = terms_we_lack(view, printed, method);
    for (const HeldOutRun& held_out : view.replication.runs) {
      const Section4Record& record = held_out.record;
      const auto run = run_printed(view, printed, coefficients_of(printed, &PrintedRow::printed), record);
      const VectorXd means = expected_nmse(view, printed, record);
      for (Index state = 0; state < means.size(); ++state) {
        const std::string& signal = definition.variables[static_cast<std::size_t>(state)];
        const double error = state_error(run, record, state);
        const std::string why = reason_of_run(error, means(state), lacking);
        rows.push_back(compared(
            {definition.table, "", signal, method, "free_run", error},
            {.expected = means(state), .ours = median_of_ours(view, method, record.ratio, signal), .reason = why}));
        rows.back()["verdict"] = why.empty() ? "within noise" : "not reproducible";
        rows.back()["ratio"] = record.ratio;
      }
    }
  }
}

}  // namespace

std::string judge_size(double paper, double ours, double factor) {
  if (!std::isfinite(ours)) return "none";
  const double ratio = ours / paper;
  return ratio > factor ? "larger" : ratio < 1.0 / factor ? "smaller" : "same size";
}

std::string judge_scaled(double paper, double ours, double factor) {
  if (!std::isfinite(ours)) return "not kept";
  if (paper * ours < 0.0) return "other sign";
  return judge_size(paper, ours, factor) == "same size" ? "same sign and size" : "same sign";
}

std::string verdict_on(const Printed& print, const Answer& answer) {
  const char* out = "not reproducible";
  if (std::isnan(print.tolerance)) return out;
  if (std::isnan(answer.expected))
    return (print.quantity == "mean" ? judge_scaled : judge_size)(print.value, answer.ours, print.tolerance);
  const auto agrees = [&](double value) {
    return std::abs(value - answer.expected) <= print.tolerance * std::abs(answer.expected_std);
  };
  return agrees(print.value) ? "within noise" : agrees(print.should_be) ? "misprint" : out;
}

Json compared(const Printed& print, const Answer& answer) {
  const std::string verdict = verdict_on(print, answer);
  return {{"table", print.table},
          {"row", print.row},
          {"term", print.term},
          {"method", print.method},
          {"quantity", print.quantity},
          {"paper", number_or_null(print.value)},
          {"expected", number_or_null(answer.expected)},
          {"ours", number_or_null(answer.ours)},
          {"ours_std", number_or_null(answer.ours_std)},
          {"verdict", verdict},
          {"reason", std::isnan(print.tolerance) && answer.reason.empty() ? print.remark : answer.reason}};
}

double expected_cov(double mean, double se) {
  // mean = L gamma with gamma = 1 - (se / L)^2, so L^2 - mean L - se^2 = 0.
  const double least_squares = 0.5 * (std::abs(mean) + std::sqrt(mean * mean + 4.0 * se * se));
  return se * std::sqrt(std::abs(mean) / least_squares) / std::abs(mean);
}

Json compare_with_paper(const CaseReplication& replication) {
  CaseView view{replication};
  Section4Case other = *view.study.definition;
  std::erase(other.training_ratios, other.otherwise_without);
  const Section4Study other_study = other.otherwise.empty() ? Section4Study{} : section4_study(other);
  for (const char* method : paper_methods) {
    view.printed[method] = printed_rows(view.study, method);
    if (!other.otherwise.empty()) view.otherwise[method] = printed_rows(other_study, method, other.otherwise_beside);
  }
  Json rows = Json::array(), seconds = Json::array();
  for (const Printed& print : printed_numbers()) {
    if (print.table != other.table) continue;
    if (print.quantity == "mean") rows.push_back(compare_mean(view, print));
    if (print.quantity == "cov") rows.push_back(compare_cov(view, print));
    if (print.quantity != "seconds") continue;
    const double a_fit = mean_of(matching(replication.document.at("fits"), {{"method", print.method}}), "/seconds");
    const double all_rows = a_fit * static_cast<double>(view.printed.at(print.method).size());
    seconds.push_back(
        compared(print, {.ours = all_rows + mean_of(matching(replication.document.at("accumulate"), {}), "/seconds")}));
  }
  compare_free_runs(view, rows);
  rows.insert(rows.end(), seconds.begin(), seconds.end());
  return rows;
}

}  // namespace apps
