#pragma once
#include <Eigen/Core>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "ident/regression/r_factor.hpp"

// Sparse linear regression: a target t (m rows) as t = Phi c + noise with most of the b coefficients c zero. Every
// method here takes an RFactor of one target, in whatever units the caller has, scales its columns to unit norm inside,
// and returns coefficients in the caller's units. Numbers of equations and steps are those of [QZS23].

namespace ident {

struct MethodDescription;  // of ident/regression/methods.hpp

/// In the order of MethodOptions below.
enum class Method { fast_rvm, slow_rvm, multi_rvm, stlsq, lasso, ridge, ols };
[[nodiscard]] std::string_view to_string(Method method);  ///< its name in the table of ident/regression/methods.hpp

/// What speaks for a range where both can (Likelihood).
enum class Stage { likelihood, regression };

/// How a term earns its place.
enum class Selection {
  evidence,  ///< its gain in log evidence must exceed tau: 2 dL = q - 1 - log q > tau, at the effective sample size
             ///< where the rows are known, as `identify` knows them; the rows of a bare R factor count in full
  evidence_white,  ///< the same, and every row counts in full, as it does where the residual is white noise
  type2,  ///< any gain will do: type-II maximum likelihood, as in [QZS23]; keeps about 3 of 10 irrelevant terms
};
[[nodiscard]] std::string_view to_string(Selection selection);

/// rank_deficient: some terms are combinations of others and were left out, or nearly so. too_few_rows: fewer rows than
/// terms, or no more rows than kept terms, so that the noise is unknown.
enum class FitStatus { converged, iteration_limit, no_relevant_term, rank_deficient, too_few_rows, zero_target };
[[nodiscard]] std::string_view to_string(FitStatus status);

enum class FitAction { start, add, reestimate, remove, exchange };
[[nodiscard]] std::string_view to_string(FitAction action);

/// One move of a fit, in order: what a reader would plot. The first is the start; additions, removals and exchanges
/// replayed from there end at `relevant`.
struct FitStep {
  FitAction action = FitAction::add;
  Eigen::Index term = 0;                                      ///< index into the library; -1: all kept terms at once
  double log_evidence = 0.0, noise_variance = 0.0;            ///< after the move; NaN: not computed
  Eigen::Index leaving = -1;                                  ///< of an exchange: the term that `term` replaced
  std::vector<Eigen::Index> terms = {};                       ///< of a start: what is kept from the outset
  double penalty = std::numeric_limits<double>::quiet_NaN();  ///< lasso: lambda as a fraction of the largest useful one
};

/// A term left out because on these rows it is a combination of others, but for rounding.
struct Dependent {
  Eigen::Index term = 0;
  std::vector<Eigen::Index> of;  ///< those that carry the combination
};

/// Some terms of a library as a model, by least squares.
struct RankedModel {
  std::vector<Eigen::Index> terms;  ///< indices into the columns of the RFactor, ascending
  double rss = 1.0;                 ///< of the target's squares
  double probability = 0.0;         ///< by the selection's score, among all that were scored
};

/// Models of a library by what the rows say of each: see ident/selection/ranked_models.hpp.
struct ModelRanking {
  double num_models = 0.0;        ///< that were scored
  bool all = true;                ///< they are all there are; false: those near the kept terms
  std::vector<RankedModel> best;  ///< the most probable first, at least one
  Eigen::VectorXd inclusion;      ///< b: probability that the term belongs; NaN: in none of these models
  /// By how much the first is more probable than the second; infinite where there is no other.
  [[nodiscard]] double odds() const;
  /// Neither in nor out with 80 % probability.
  [[nodiscard]] bool is_undecided(Eigen::Index term) const;
};

/// One regression of one target on a library, in the caller's units: coefficients in those of the target over those of
/// their columns. Numerics that end badly are a status, never a throw.
struct Fit {
  Method method = Method::fast_rvm;
  std::optional<Selection> selection;  ///< none for methods without an evidence
  FitStatus status = FitStatus::converged;
  std::vector<Eigen::Index> relevant;  ///< b' kept terms: indices into the columns of the RFactor, ascending
  Eigen::VectorXd mean;                ///< mu (b'), Eq. 12 of [QZS23]
  Eigen::MatrixXd covariance;          ///< delta (b' x b'), Eq. 13, noise included
  Eigen::MatrixXd covariance_weak;  ///< the same with what terms too weak to be kept may take from these; empty where
                                    ///< the method has no evidence, or selects by Selection::type2
  Eigen::VectorXd alpha;            ///< inverse prior variances (b'); zero for methods without a prior
  double noise_variance = 0.0;      ///< sigma^2 of the target
  std::string no_variance;          ///< not empty: why noise_variance or covariance are NaN
  double log_evidence = 0.0;        ///< Eq. 16 with its misprint corrected; NaN for methods without one
  Eigen::VectorXd evidence_gain;    ///< b (all terms): 2 dL of having the term, at its best alpha; NaN: not computed
  double tau = 0.0;                 ///< what a gain had to exceed
  double condition_number = 0.0;    ///< of the kept columns at unit norm
  int iterations = 0;               ///< moves from the start that won to its end
  int discarded_iterations = 0;     ///< of starts that ended lower
  std::vector<FitStep> steps;
  std::optional<ModelRanking> ranking;  ///< where the rows are known as evidence: by `identify`
  std::vector<Dependent> dependent;     ///< least squares and what rests on it; then the status is rank_deficient
  std::vector<std::string> remarks;     ///< sentences for a person: "columns nearly collinear: ..."

  /// What intervals are made of.
  [[nodiscard]] const Eigen::MatrixXd& interval_covariance() const& {
    return covariance_weak.size() > 0 ? covariance_weak : covariance;
  }
  void interval_covariance() const&& = delete;
  /// Of any term of the library: by the ranking of models, else 1 / (1 + exp((tau - gain) / 2)), which compares two of
  /// them; NaN for methods without an evidence.
  [[nodiscard]] double inclusion_probability(Eigen::Index term) const;
};

/// Makes the indices of a fit on the columns `terms` of a library into indices into that library of `num_terms`; the
/// gains of the other terms are NaN.
void renumber(Fit& fit, const std::vector<Eigen::Index>& terms, Eigen::Index num_terms);

/// Called between the steps of a fit; may throw to stop it.
using Poll = std::function<void()>;

/// Of the three relevance vector machines.
template <Method method>
struct RvmOptions {
  Selection selection = Selection::evidence;
  double tau = -1.0;  ///< what a gain must exceed; negative: ln m + 2 ln b (evidence) or 0 (type2)
  int max_iterations = method == Method::slow_rvm ? 5000 : 1000;
  double log_alpha_tolerance = 1e-6;    ///< on |log(alpha_new / alpha)|, Sec. 3.4 of [QZS23]
  double initial_noise_fraction = 0.1;  ///< gamma of Algorithm 1, in (0, 1); sigma^2 starts at gamma t't / m
  double noise_floor_fraction = 1e-26;  ///< sigma^2 is kept above this fraction of t't / m
  Poll poll = {};
};
using FastRvmOptions = RvmOptions<Method::fast_rvm>;
using SlowRvmOptions = RvmOptions<Method::slow_rvm>;
using MultiRvmOptions = RvmOptions<Method::multi_rvm>;

/// Sparse Bayesian regression by fast marginal likelihood maximisation [TF03]; Algorithm 1 of [QZS23] corrected.
/// Sparsity and quality factors are residual norms of a QR of [R_A; sqrt(alpha sigma^2)]: nothing is subtracted, R'R is
/// never formed. With Selection::evidence, an exchange swaps one kept for one left-out term while that raises the
/// criterion 2 log evidence - tau b', and ill-conditioned libraries are also searched from all terms; the highest end
/// is returned. Throws std::invalid_argument for several targets, and for an initial_noise_fraction outside (0, 1).
[[nodiscard]] Fit fit_fast_rvm(const RFactor& data, const FastRvmOptions& options = {});
[[nodiscard]] MethodDescription describe(const FastRvmOptions& options);

/// Fixed-point re-estimation of all alphas from all terms, with pruning [Tip01]; S-RVM of [QZS23]. Throws like
/// fit_fast_rvm.
[[nodiscard]] Fit fit_slow_rvm(const RFactor& data, const SlowRvmOptions& options = {});
[[nodiscard]] MethodDescription describe(const SlowRvmOptions& options);

/// fit_multi_rvm, of ident/regression/multi_rvm.hpp; for one target the same as fit_fast_rvm.
[[nodiscard]] MethodDescription describe(const MultiRvmOptions& options);

struct StlsqOptions {
  double threshold = 0.02;  ///< on |c_j| ||phi_j|| / ||t|| (unit-norm), or on |c_j| as it is (raw)
  bool unit_norm = true;
  int max_iterations = 100;
  Poll poll = {};
};
/// Sequentially thresholded least squares, the regression of SINDy [BPK16]. With fewer rows than terms: status
/// too_few_rows. Throws std::invalid_argument for several targets, and for a negative threshold.
[[nodiscard]] Fit fit_stlsq(const RFactor& data, const StlsqOptions& options = {});
[[nodiscard]] MethodDescription describe(const StlsqOptions& options);

struct LassoOptions {
  double lambda = -1.0;    ///< on unit-norm columns, as a fraction of the largest useful one; negative: by BIC
  int path_length = 60;    ///< penalties tried, at least 2
  double path_end = 1e-4;  ///< the last of them, as a fraction of the first, in (0, 1)
  Poll poll = {};
};
/// Eq. 7 of [QZS23] by coordinate descent on R's columns along a path of penalties; the reported coefficients are least
/// squares on the support. By BIC, supports of as many terms as rows are passed over.
/// Throws std::invalid_argument for several targets, and for a path out of its range.
[[nodiscard]] Fit fit_lasso(const RFactor& data, const LassoOptions& options = {});
[[nodiscard]] MethodDescription describe(const LassoOptions& options);

struct RidgeOptions {
  double lambda = 1e-6;  ///< penalty on unit-norm columns: (R'R + lambda I) c = R't
  Poll poll = {};
};
/// Least squares with a penalty, by QR: keeps all terms, also where there are more of them than rows.
/// Throws std::invalid_argument for several targets, and unless lambda is positive.
[[nodiscard]] Fit fit_ridge(const RFactor& data, const RidgeOptions& options = {});
[[nodiscard]] MethodDescription describe(const RidgeOptions& options);

struct OlsOptions {
  Poll poll = {};
};
/// Least squares on all terms (or on those given) by QR of unit-norm columns; a column that depends on earlier ones is
/// left out. Throws std::invalid_argument for several targets, and for a term that the library does not have.
[[nodiscard]] Fit fit_ols(const RFactor& data, const OlsOptions& options = {});
[[nodiscard]] Fit fit_ols(const RFactor& data, const std::vector<Eigen::Index>& terms);
[[nodiscard]] MethodDescription describe(const OlsOptions& options);

/// The options of any method, in the order of Method: ident/regression/methods.hpp makes its table of them.
using MethodOptions =
    std::variant<FastRvmOptions, SlowRvmOptions, MultiRvmOptions, StlsqOptions, LassoOptions, RidgeOptions, OlsOptions>;

}  // namespace ident
