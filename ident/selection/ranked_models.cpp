#include "ident/selection/ranked_models.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "ident/selection/best_subsets.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t most_listed = 10;
// Standard errors that a term in question is expected to be large, at most.
constexpr double largest_expected = 20.0;

// Which of the open terms a model has: bit i is the i-th.
using TermSet = std::uint32_t;

// The log of what each subset of the columns of a triangle leaves of the last, the target. To keep the first column of
// those that remain is to go on below its row, to leave it out is to make a triangle of the others again: nothing is
// subtracted.
class Subsets {
 public:
  Subsets(const MatrixXd& triangle, const Poll& poll)
      : log_rss(std::size_t{1} << (triangle.cols() - 1)), poll_(poll), num_open_(triangle.cols() - 1) {
    for (Index width = triangle.cols(); width > 0; --width) without_.emplace_back(width, width);
    visit(triangle, 0);
  }
  std::vector<double> log_rss;  // by TermSet

 private:
  void visit(const Eigen::Ref<const MatrixXd>& R, TermSet terms) {
    const Index left = R.cols() - 1;
    if (left == 0) {
      constexpr double rounding = 1e-24;  // of sums over up to 1e6 rows
      log_rss[terms] = std::log(std::max(R(0, 0) * R(0, 0), rounding));
      return;
    }
    constexpr Index seldom = 12;
    if (left == seldom && poll_) poll_();
    const auto term = static_cast<std::size_t>(num_open_ - left);
    visit(R.bottomRightCorner(left, left), terms | TermSet{1} << term);
    MatrixXd& others = without_[term + 1];
    leave_out_first(R, others);
    visit(others, terms);
  }

  // By Givens rotations of neighbouring rows.
  static void leave_out_first(const Eigen::Ref<const MatrixXd>& R, MatrixXd& others) {
    const Index count = others.cols();
    others = R.topRightCorner(count, count);
    for (Index j = 0; j < count; ++j) {
      const double here = others(j, j), below = R(j + 1, j + 1), norm = std::hypot(here, below);
      const double c = norm > 0.0 ? here / norm : 0.0, s = norm > 0.0 ? below / norm : 1.0;
      others(j, j) = norm;
      for (Index k = j + 1; k < count; ++k) {
        const double upper = others(j, k), lower = R(j + 1, k + 1);
        others(j, k) = c * upper + s * lower;
        others(j + 1, k) = c * lower - s * upper;
      }
    }
  }

  const Poll& poll_;
  Index num_open_;
  std::vector<MatrixXd> without_;
};

// By how much having a term or not changes what the kept ones leave.
double taken_away(const UnitProblem& problem, const Posterior& at, Index term) {
  return at.sparsity(term) > smallest_sparsity(problem) ? at.quality(term) * at.quality(term) / at.sparsity(term) : 0.0;
}

// What is scored: the sure terms are in every model; of the open ones, every subset.
struct Question {
  std::vector<Index> sure, open;
};

Question question_of(const UnitProblem& problem, const std::vector<Index>& kept) {
  const Index b = problem.num_terms();
  if (b <= widest_ranked_library) return {{}, all_columns(b)};
  const Posterior at = posterior(problem, kept, VectorXd::Constant(std::ssize(kept), flat_lambda));
  std::vector<Index> weakest = kept, strongest;
  for (Index i = 0; i < b; ++i)
    if (!std::binary_search(kept.begin(), kept.end(), i)) strongest.push_back(i);
  const auto change = [&](Index i) { return taken_away(problem, at, i); };
  std::stable_sort(weakest.begin(), weakest.end(), [&](Index i, Index j) { return change(i) < change(j); });
  std::stable_sort(strongest.begin(), strongest.end(), [&](Index i, Index j) { return change(i) > change(j); });
  const Index of_kept = std::min<Index>(std::ssize(weakest), widest_ranked_library / 2),
              of_others = std::min<Index>(std::ssize(strongest), widest_ranked_library - of_kept);
  Question question{{weakest.begin() + of_kept, weakest.end()}, {weakest.begin(), weakest.begin() + of_kept}};
  question.open.insert(question.open.end(), strongest.begin(), strongest.begin() + of_others);
  return question;
}

// R of [sure open target] below the sure ones.
MatrixXd triangle_beyond(const UnitProblem& problem, const Question& question) {
  const Index num_sure = std::ssize(question.sure), num_open = std::ssize(question.open);
  MatrixXd columns(problem.A.rows(), num_sure + num_open + 1);
  columns << problem.A(Eigen::all, question.sure), problem.A(Eigen::all, question.open), problem.Y;
  return triangle(columns).bottomRightCorner(num_open + 1, num_open + 1);
}

// Twice the negative log probability of each subset, but for what they share; infinite where rows are too few for it.
std::vector<double> scores(const UnitProblem& problem, const std::vector<double>& log_rss, std::size_t num_sure,
                           double largest_size) {
  const auto num_rows = static_cast<double>(problem.num_samples);
  std::vector<double> cost;
  for (std::size_t k = num_sure; k <= static_cast<std::size_t>(problem.num_terms()); ++k)
    cost.push_back(k > num_sure && static_cast<double>(k) + 2.0 > num_rows
                       ? std::numeric_limits<double>::infinity()
                       : model_cost(std::min(num_rows, largest_size), problem.num_terms(), k));
  std::vector<double> result(log_rss.size());
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i] = num_rows * log_rss[i] + cost[static_cast<std::size_t>(std::popcount(i))];
  return result;
}

// Of each model, in place of its score.
std::vector<double> probabilities(std::vector<double> scores) {
  const double least = *std::min_element(scores.begin(), scores.end());
  double total = 0.0;
  for (double& score : scores) total += score = std::exp(0.5 * (least - score));
  for (double& score : scores) score /= total;
  return scores;
}

// Of each open term.
VectorXd inclusion_of(const std::vector<double>& probability, std::size_t num_open) {
  constexpr double negligible = 1e-15;  // a million of them are nothing
  VectorXd inclusion = VectorXd::Zero(static_cast<Index>(num_open));
  for (std::size_t terms = 0; terms < probability.size(); ++terms)
    if (probability[terms] > negligible)
      for (std::size_t left = terms; left != 0; left &= left - 1)
        inclusion(std::countr_zero(left)) += probability[terms];
  return inclusion;
}

std::vector<RankedModel> best_models(const Question& question, const std::vector<double>& probability,
                                     const std::vector<double>& log_rss) {
  std::vector<std::size_t> first(std::min(most_listed, probability.size()));
  std::vector<std::size_t> all(probability.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  std::partial_sort_copy(all.begin(), all.end(), first.begin(), first.end(),
                         [&](std::size_t a, std::size_t b) { return probability[a] > probability[b]; });
  std::vector<RankedModel> models;
  for (const std::size_t terms : first) {
    if (!(probability[terms] > 0.0)) break;
    RankedModel model{question.sure, std::exp(log_rss[terms]), probability[terms]};
    for (std::size_t i = 0; i < question.open.size(); ++i)
      if ((terms >> i & 1U) != 0) model.terms.push_back(question.open[i]);
    std::sort(model.terms.begin(), model.terms.end());
    models.push_back(std::move(model));
  }
  return models;
}

}  // namespace

ModelRanking ranked_models(const UnitProblem& problem, const std::vector<Index>& kept) {
  const Question question = question_of(problem, kept);
  const std::vector<double> log_rss = Subsets(triangle_beyond(problem, question), problem.poll).log_rss;
  const auto by_selection = scores(problem, log_rss, question.sure.size(), std::numeric_limits<double>::infinity());
  ModelRanking ranking;
  ranking.all = std::ssize(question.open) == problem.num_terms();
  for (const double score : by_selection) ranking.num_models += std::isfinite(score) ? 1.0 : 0.0;
  ranking.best = best_models(question, probabilities(by_selection), log_rss);

  const std::vector<double> probability =
      probabilities(scores(problem, log_rss, question.sure.size(), largest_expected * largest_expected));
  ranking.inclusion = VectorXd::Constant(problem.num_terms(), std::numeric_limits<double>::quiet_NaN());
  ranking.inclusion(question.sure).setOnes();
  ranking.inclusion(question.open) = inclusion_of(probability, question.open.size());
  return ranking;
}

}  // namespace ident
