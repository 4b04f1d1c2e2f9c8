#include "ident/regression/finish_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "dsp/values/constants.hpp"
#include "dsp/values/linear.hpp"
#include "ident/regression/weak_terms.hpp"

namespace ident {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

using dsp::nan;

// target norm over column norms: what turns unit-norm coefficients into the caller's.
VectorXd coefficient_scale(const UnitProblem& problem, const std::vector<Index>& kept) {
  VectorXd scale(static_cast<Index>(kept.size()));
  for (std::size_t j = 0; j < kept.size(); ++j)
    scale(static_cast<Index>(j)) = problem.target_norm(0) / problem.column_norm(kept[j]);
  return scale;
}

MatrixXd columns(const UnitProblem& problem, const std::vector<Index>& kept) {
  MatrixXd A(problem.A.rows(), static_cast<Index>(kept.size()));
  for (std::size_t j = 0; j < kept.size(); ++j) A.col(static_cast<Index>(j)) = problem.A.col(kept[j]);
  return A;
}

// Takes out of `kept` each column that the earlier ones make up but for rounding (Gram-Schmidt, done twice): the later
// of two equal candidates is the one a person would miss least.
void leave_out_dependent(const UnitProblem& problem, std::vector<Index>& kept, Fit& fit) {
  // Unit vectors are known to some eps, sums of columns that were filtered one by one to some tens of eps.
  constexpr double rounding = 64.0 * std::numeric_limits<double>::epsilon();
  constexpr double negligible_fraction = 1e-6;
  const auto n = static_cast<Index>(kept.size());
  MatrixXd Q(problem.A.rows(), n), T = MatrixXd::Zero(n, n);
  std::vector<Index> independent;
  for (const Index term : kept) {
    const auto r = static_cast<Index>(independent.size());
    VectorXd beyond = problem.A.col(term), within_basis = VectorXd::Zero(r);
    for (int pass = 0; pass < 2; ++pass) {
      const VectorXd within = Q.leftCols(r).transpose() * beyond;
      beyond -= Q.leftCols(r) * within;
      within_basis += within;
    }
    const double left = beyond.norm();
    if (left > rounding) {
      Q.col(r) = beyond / left;
      T.col(r).head(r) = within_basis;
      T(r, r) = left;
      independent.push_back(term);
      continue;
    }
    Dependent found{term, {}};
    const VectorXd weights = dsp::solve_upper(T.topLeftCorner(r, r), within_basis);
    for (Index j = 0; j < r; ++j)
      if (std::abs(weights(j)) > negligible_fraction * weights.cwiseAbs().maxCoeff())
        found.of.push_back(independent[static_cast<std::size_t>(j)]);
    fit.dependent.push_back(std::move(found));
    fit.steps.push_back({FitAction::remove, term, nan, nan});
    fit.status = FitStatus::rank_deficient;
  }
  kept = std::move(independent);
}

// Variances of very small or very large units are beyond what a double holds: none is better than a wrong one.
void withhold_unrepresentable(Fit& fit) {
  const bool noise = std::isnormal(fit.noise_variance);
  const bool errors = fit.covariance.diagonal().unaryExpr([](double value) { return std::isnormal(value); }).all();
  if (!noise) fit.noise_variance = nan;
  if (!errors) {
    fit.covariance.setConstant(nan);
    fit.covariance_weak.resize(0, 0);
  }
  if (noise && errors) return;
  fit.no_variance = "a variance in these units is beyond what a double holds: give the data in others";
}

}  // namespace

UnitProblem one_target(const RFactor& data, const char* function, Poll poll) {
  if (data.num_targets() != 1)
    throw std::invalid_argument(std::string(function) + ": needs one target, got " +
                                std::to_string(data.num_targets()) + "; `select` makes data of one of them");
  return unit_problem(data, std::move(poll));
}

bool cannot_begin(const UnitProblem& problem, Fit& fit) {
  fit.mean.resize(0);
  fit.covariance.resize(0, 0);
  fit.alpha.resize(0);
  fit.evidence_gain = VectorXd::Constant(problem.num_terms(), nan);
  fit.log_evidence = nan;
  if (problem.num_samples < 2 || problem.num_terms() == 0)
    fit.status = FitStatus::too_few_rows;
  else if (problem.target_norm(0) == 0.0)
    fit.status = FitStatus::zero_target;
  else
    return false;
  return true;
}

std::vector<Index> usable_terms(const UnitProblem& problem) {
  std::vector<Index> usable;
  for (Index i = 0; i < problem.num_terms(); ++i)
    if (problem.column_norm(i) > 0.0) usable.push_back(i);
  return usable;
}

FitStep start_from(std::vector<Index> kept) {
  return {FitAction::start, -1, nan, nan, -1, std::move(kept)};
}

double condition_number(const UnitProblem& problem, const std::vector<Index>& kept) {
  if (kept.empty()) return 1.0;
  const VectorXd s = dsp::singular_values(triangle(columns(problem, kept)));
  const double smallest = s(s.size() - 1);
  return smallest > 0.0 ? s(0) / smallest : std::numeric_limits<double>::infinity();
}

double largest_inflation(const UnitProblem& problem) {
  const std::vector<Index> all = usable_terms(problem);
  if (all.empty()) return 1.0;
  const Posterior at = posterior(problem, all, VectorXd::Constant(static_cast<Index>(all.size()), flat_lambda));
  double smallest = 1.0;
  for (const Index i : all) smallest = std::min(smallest, at.sparsity(i));
  return 1.0 / smallest;
}

void finish_bayesian(const UnitProblem& problem, std::vector<Index> kept, VectorXd lambda, double noise_variance,
                     Fit& fit) {
  std::vector<std::size_t> order(kept.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return kept[a] < kept[b]; });
  fit.relevant.clear();
  VectorXd sorted(lambda.size());
  for (std::size_t j = 0; j < order.size(); ++j) {
    fit.relevant.push_back(kept[order[j]]);
    sorted(static_cast<Index>(j)) = lambda(static_cast<Index>(order[j]));
  }
  const Posterior at = posterior(problem, fit.relevant, sorted);
  const VectorXd scale = coefficient_scale(problem, fit.relevant);
  fit.mean = at.mean.cwiseProduct(scale);
  const MatrixXd root = std::sqrt(noise_variance) * (scale.asDiagonal() * at.root);
  fit.covariance = root * root.transpose();
  if (fit.selection.has_value() && fit.selection != Selection::type2 &&
      static_cast<Index>(kept.size()) < problem.num_samples)
    fit.covariance_weak = scale.asDiagonal() *
                          covariance_with_weak_terms(problem, fit.relevant, sorted, noise_variance, fit.tau) *
                          scale.asDiagonal();
  fit.alpha = (sorted.array() / noise_variance / scale.array().square()).matrix();
  fit.noise_variance = noise_variance * problem.target_norm(0) * problem.target_norm(0);
  withhold_unrepresentable(fit);
  fit.log_evidence = log_evidence(problem, at, noise_variance);
  fit.evidence_gain.resize(problem.num_terms());
  for (Index i = 0; i < problem.num_terms(); ++i)
    fit.evidence_gain(i) =
        at.sparsity(i) > 0.0 ? evidence_gain(at.quality(i) * at.quality(i) / at.sparsity(i) / noise_variance) : 0.0;
  fit.condition_number = condition_number(problem, fit.relevant);
  if (fit.relevant.empty())
    fit.status = FitStatus::no_relevant_term;
  else if (static_cast<Index>(fit.relevant.size()) >= problem.num_samples)
    fit.status = FitStatus::too_few_rows;
  if (problem.num_terms() > 2 && static_cast<Index>(fit.relevant.size()) == problem.num_terms())
    fit.remarks.push_back(
        "every candidate term was kept: a term may be missing from the candidates, or the residual is not noise");
}

void fit_on_terms(const UnitProblem& problem, const std::vector<Index>& terms, Fit& fit) {
  const double spare = std::max(1.0, static_cast<double>(problem.num_samples) - static_cast<double>(terms.size()));
  const VectorXd lambda = VectorXd::Constant(static_cast<Index>(terms.size()), flat_lambda);
  const double noise = posterior(problem, terms, lambda).residual(0, 0) / spare;
  fit.steps.push_back(start_from(terms));
  finish_bayesian(problem, terms, lambda, noise, fit);
}

void finish_least_squares(const UnitProblem& problem, std::vector<Index> kept, double penalty, Fit& fit) {
  if (problem.poll) problem.poll();
  fit.no_variance.clear();  // said of more terms, as is the status
  std::sort(kept.begin(), kept.end());
  if (fit.status == FitStatus::too_few_rows) fit.status = FitStatus::converged;
  fit.alpha = VectorXd::Zero(0);
  fit.mean = VectorXd::Zero(0);
  fit.covariance = MatrixXd::Zero(0, 0);
  if (penalty == 0.0) leave_out_dependent(problem, kept, fit);
  const auto n = static_cast<Index>(kept.size());
  fit.relevant = std::move(kept);
  if (n == 0) {
    fit.status = FitStatus::no_relevant_term;
    fit.noise_variance = problem.target_norm(0) * problem.target_norm(0) / static_cast<double>(problem.num_samples);
    return;
  }
  const VectorXd scale = coefficient_scale(problem, fit.relevant);
  const MatrixXd data_columns = columns(problem, fit.relevant);
  MatrixXd A = MatrixXd::Zero(problem.A.rows() + (penalty > 0.0 ? n : 0), n);
  A.topRows(problem.A.rows()) = data_columns;
  if (penalty > 0.0) A.bottomRows(n).diagonal().setConstant(std::sqrt(penalty));
  VectorXd y = VectorXd::Zero(A.rows());
  y.head(problem.A.rows()) = problem.Y.col(0);

  const dsp::Qr qr(std::move(A));
  qr.rotate(y);
  const MatrixXd T = qr.triangle();
  const VectorXd mean = dsp::solve_upper(T, VectorXd(y.head(n)));
  const MatrixXd root = dsp::inverse_of_upper(T);
  const double residual =
      penalty > 0.0 ? (problem.Y.col(0) - data_columns * mean).squaredNorm() : y.tail(y.size() - n).squaredNorm();
  const bool rows_to_spare = problem.num_samples > n;
  const double noise = rows_to_spare ? residual / static_cast<double>(problem.num_samples - n) : nan;
  fit.mean = mean.cwiseProduct(scale);
  fit.noise_variance = noise * problem.target_norm(0) * problem.target_norm(0);
  const MatrixXd scaled = std::sqrt(noise) * (scale.asDiagonal() * root);
  fit.covariance = scaled * scaled.transpose();
  if (noise > 0.0) withhold_unrepresentable(fit);
  if (!rows_to_spare)
    fit.no_variance = fmt::format("{} rows for {} terms: no row is left to estimate the noise", problem.num_samples, n);
  fit.alpha = VectorXd::Zero(n);
  fit.condition_number = condition_number(problem, fit.relevant);
  if (penalty == 0.0 && !(fit.condition_number < 0.1 / std::numeric_limits<double>::epsilon()))
    fit.status = FitStatus::rank_deficient;
  if (!rows_to_spare && penalty == 0.0) fit.status = FitStatus::too_few_rows;
}

}  // namespace ident
