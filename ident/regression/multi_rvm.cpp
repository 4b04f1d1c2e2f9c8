#include "ident/regression/multi_rvm.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "ident/regression/finish_fit.hpp"
#include "ident/regression/posterior.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The shared search at unit norm: what all targets say of every term.
class SharedSearch {
 public:
  SharedSearch(const RFactor& data, const FastRvmOptions& options, double tau) : options_(options), tau_(tau) {
    for (Index j = 0; j < data.num_targets(); ++j) targets_.push_back(unit_problem(data, j));
    num_samples_ = static_cast<double>(data.num_samples);
    num_targets_ = static_cast<double>(targets_.size());
    const Index q = data.num_targets();
    omega_ = MatrixXd::Identity(q, q) * (options.initial_noise_fraction / num_samples_);
    look();
  }

  void climb(MultiFit& fit) {
    fit.steps.push_back({FitAction::start, -1, log_evidence(), mean_noise(), -1, kept_});
    while (fit.iterations < options_.max_iterations) {
      const auto [action, term] = best_move();
      if (term < 0) {
        settle_noise();
        return;
      }
      apply(action, term);
      ++fit.iterations;
      fit.steps.push_back({action, term, log_evidence(), mean_noise()});
    }
    fit.status = FitStatus::iteration_limit;
  }

  // All usable terms at once, for libraries in which no term stands out alone.
  void start_full() {
    kept_ = usable_terms(targets_.front());
    lambda_.assign(kept_.size(), flat);
    look();
    settle_noise();
    apply(FitAction::reestimate, -1);
  }

  [[nodiscard]] double criterion() const { return 2.0 * log_evidence() - tau_ * static_cast<double>(kept_.size()); }

  void finish(MultiFit& fit) const {
    std::vector<std::size_t> order(kept_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return kept_[a] < kept_[b]; });
    const auto n = static_cast<Index>(kept_.size()), q = static_cast<Index>(targets_.size());
    fit.mean.resize(n, q);
    fit.lambda.resize(n);
    MatrixXd root(n, n);
    for (Index i = 0; i < n; ++i) {
      const std::size_t from = order[static_cast<std::size_t>(i)];
      const double norm = targets_.front().column_norm(kept_[from]);
      fit.relevant.push_back(kept_[from]);
      fit.lambda(i) = lambda_[from] * norm * norm;
      root.row(i) = at_.front().root.row(static_cast<Index>(from)) / norm;
      for (Index j = 0; j < q; ++j)
        fit.mean(i, j) = at(j).mean(static_cast<Index>(from)) * target(j).target_norm / norm;
    }
    fit.row_covariance = root * root.transpose();
    fit.noise_covariance = omega_;
    for (Index j = 0; j < q; ++j)
      for (Index k = 0; k < q; ++k) fit.noise_covariance(j, k) *= target(j).target_norm * target(k).target_norm;
    fit.log_evidence = log_evidence();
    if (n == 0) fit.status = FitStatus::no_relevant_term;
  }

 private:
  [[nodiscard]] const UnitProblem& target(Index j) const { return targets_[static_cast<std::size_t>(j)]; }
  [[nodiscard]] const Posterior& at(Index j) const { return at_[static_cast<std::size_t>(j)]; }

  void look() {
    at_.clear();
    const Eigen::Map<const VectorXd> lambda(lambda_.data(), static_cast<Index>(lambda_.size()));
    for (const UnitProblem& problem : targets_) at_.push_back(posterior(problem, kept_, lambda));
    const Index q = omega_.rows(), b = targets_.front().num_terms();
    // l Omega^-1 l' / q of each term, as the square of what a single target would have for its quality at noise 1.
    const MatrixXd root = omega_.llt().matrixL();
    MatrixXd quality(q, b);
    for (Index j = 0; j < q; ++j) quality.row(j) = at(j).quality.transpose();
    root.triangularView<Eigen::Lower>().solveInPlace(quality);
    quality_ = quality.colwise().norm().transpose() / std::sqrt(num_targets_);
  }

  // For fixed lambda the evidence is highest at Omega = T'C^-1 T / m.
  [[nodiscard]] MatrixXd misfit() const {
    const Index q = omega_.rows(), n = static_cast<Index>(kept_.size()), rows = targets_.front().A.rows();
    MatrixXd residuals(rows + n, q);
    for (Index j = 0; j < q; ++j) {
      residuals.col(j).head(rows) = target(j).y;
      for (Index i = 0; i < n; ++i) {
        const auto place = static_cast<std::size_t>(i);
        residuals.col(j).head(rows) -= target(j).A.col(kept_[place]) * at(j).mean(i);
        residuals(rows + i, j) = std::sqrt(lambda_[place]) * at(j).mean(i);
      }
    }
    return residuals.transpose() * residuals;
  }
  void settle_noise() {
    omega_ = misfit() / num_samples_;
    // Keeps Omega positive where a target is fitted exactly, or is another target's multiple.
    omega_.diagonal().array() +=
        std::max(options_.noise_floor_fraction, 1e-14 * omega_.diagonal().maxCoeff() * num_samples_) / num_samples_;
    look();
  }

  [[nodiscard]] double log_determinant_of_noise() const {
    double sum = 2.0 * MatrixXd(omega_.llt().matrixL()).diagonal().array().log().sum();
    for (const UnitProblem& problem : targets_) sum += 2.0 * std::log(problem.target_norm);
    return sum;
  }
  [[nodiscard]] double mean_noise() const { return std::exp(log_determinant_of_noise() / num_targets_); }
  [[nodiscard]] double log_evidence() const {
    return -0.5 * (num_samples_ * (num_targets_ * std::log(2.0 * std::numbers::pi) + log_determinant_of_noise()) +
                   num_targets_ * at_.front().log_determinant + omega_.llt().solve(misfit()).trace());
  }

  [[nodiscard]] double gain(Index term) const {
    const double s = at_.front().sparsity(term);
    return s > smallest_sparsity ? num_targets_ * evidence_gain(quality_(term) * quality_(term) / s) : 0.0;
  }
  [[nodiscard]] double share(Index term, double lambda) const {
    return num_targets_ * evidence_share(at_.front().sparsity(term), quality_(term), lambda, 1.0);
  }
  [[nodiscard]] double best(Index term) const { return best_lambda(at_.front().sparsity(term), quality_(term), 1.0); }

  [[nodiscard]] std::pair<FitAction, Index> best_move() const {
    std::pair<FitAction, Index> move{FitAction::reestimate, -1};
    double most = 1e-9 + 1e-14 * std::abs(log_evidence()), change = options_.log_alpha_tolerance;
    for (std::size_t j = 0; j < kept_.size(); ++j) {
      const Index term = kept_[j];
      const double now = share(term, lambda_[j]);
      if (gain(term) <= tau_) {
        if (tau_ - now > most) most = tau_ - now, move = {FitAction::remove, term};
      } else if (std::abs(std::log(best(term) / lambda_[j])) > change && move.second < 0) {
        change = std::abs(std::log(best(term) / lambda_[j]));
        move = {FitAction::reestimate, term};
      }
    }
    for (Index i = 0; i < targets_.front().num_terms(); ++i)
      if (std::find(kept_.begin(), kept_.end(), i) == kept_.end() && gain(i) - tau_ > most)
        most = gain(i) - tau_, move = {FitAction::add, i};
    return move;
  }

  void apply(FitAction action, Index term) {
    const auto place = std::find(kept_.begin(), kept_.end(), term) - kept_.begin();
    if (action == FitAction::add) {
      kept_.push_back(term);
      lambda_.push_back(best(term));
    } else if (action == FitAction::remove) {
      kept_.erase(kept_.begin() + place);
      lambda_.erase(lambda_.begin() + place);
    } else {
      for (std::size_t j = 0; j < kept_.size(); ++j)
        if (std::isfinite(best(kept_[j]))) lambda_[j] = best(kept_[j]);
    }
    look();
    settle_noise();
  }

  // A column this close to the span of the others is rounding, not information.
  static constexpr double smallest_sparsity = 1e-28;
  // A prior that lets every coefficient go where the data want it.
  static constexpr double flat = 1e-30;
  const FastRvmOptions& options_;
  double tau_, num_samples_ = 0.0, num_targets_ = 0.0;
  std::vector<UnitProblem> targets_;
  std::vector<Index> kept_;
  std::vector<double> lambda_;
  MatrixXd omega_;  ///< q x q, of the unit-norm targets
  std::vector<Posterior> at_;
  VectorXd quality_;  ///< b
};

MultiFit shared_fit(const RFactor& data, const FastRvmOptions& options, MultiFit begun) {
  MultiFit fit = begun;
  SharedSearch search(data, options, fit.tau);
  search.climb(fit);
  const bool hard = options.selection == Selection::evidence && data.num_samples > data.num_terms &&
                    data.num_terms <= widest_full_start &&
                    largest_inflation(unit_problem(data)) > inflation_of_a_hard_library;
  if (hard) {
    SharedSearch full(data, options, fit.tau);
    full.start_full();
    full.climb(begun);
    if (full.criterion() > search.criterion() + 1e-6) {
      full.finish(begun);
      return begun;
    }
  }
  search.finish(fit);
  return fit;
}

// One target has nothing to share: the whole search of fit_fast_rvm, in this vocabulary.
MultiFit of_one_target(Fit row) {
  MultiFit fit;
  fit.status = row.status;
  fit.relevant = row.relevant;
  fit.mean = row.mean;
  fit.row_covariance = row.covariance / row.noise_variance;
  fit.noise_covariance = MatrixXd::Constant(1, 1, row.noise_variance);
  fit.lambda = row.alpha * row.noise_variance;
  fit.log_evidence = row.log_evidence;
  fit.tau = row.tau;
  fit.iterations = row.iterations;
  fit.steps = row.steps;
  row.method = Method::multi_rvm;
  fit.rows.push_back(std::move(row));
  return fit;
}

// Every row ends as the shared fit did, which kept nothing.
MultiFit without_terms(MultiFit fit, const RFactor& data) {
  for (Index j = 0; j < data.num_targets(); ++j) {
    const UnitProblem problem = unit_problem(data, j);
    Fit row;
    row.method = Method::multi_rvm;
    row.tau = fit.tau;
    if (!cannot_begin(problem, row))
      finish_bayesian(problem, {}, VectorXd(), 1.0 / static_cast<double>(problem.num_samples), row);
    row.status = fit.status;
    fit.rows.push_back(std::move(row));
  }
  return fit;
}

}  // namespace

MatrixXd MultiFit::standard_deviation() const {
  return (row_covariance.diagonal() * noise_covariance.diagonal().transpose()).cwiseSqrt();
}

MultiFit fit_multi_rvm(const RFactor& data, const FastRvmOptions& options) {
  if (!(options.initial_noise_fraction > 0.0 && options.initial_noise_fraction < 1.0))
    throw std::invalid_argument("fit_multi_rvm: initial_noise_fraction must be in (0, 1)");
  if (data.num_targets() == 1) return of_one_target(fit_fast_rvm(data, options));
  MultiFit fit;
  for (Index j = 0; j < data.num_targets(); ++j) {
    Fit row;
    if (cannot_begin(unit_problem(data, j), row)) fit.status = row.status;
  }
  if (fit.status != FitStatus::converged) return without_terms(std::move(fit), data);
  if (options.tau >= 0.0)
    fit.tau = options.tau;
  else if (options.selection == Selection::evidence)
    fit.tau = default_tau(data.num_samples, data.num_terms);
  fit = shared_fit(data, options, std::move(fit));
  if (fit.relevant.empty()) return without_terms(std::move(fit), data);

  FastRvmOptions alone = options;
  alone.tau = fit.tau;
  for (Index j = 0; j < data.num_targets(); ++j) {
    fit.rows.push_back(fit_fast_rvm(select(data, fit.relevant, j), alone));
    fit.rows.back().method = Method::multi_rvm;
    renumber(fit.rows.back(), fit.relevant, data.num_terms);
  }
  return fit;
}

}  // namespace ident
