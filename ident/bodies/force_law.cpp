#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include "dsp/values/constants.hpp"
#include "dsp/values/linear.hpp"
#include "ident/bodies/choice.hpp"
#include "ident/regression/r_factor.hpp"
#include "ident/state_space/output_error.hpp"
#include "ident/state_space/start.hpp"
#include "ident/validate/independent_rows.hpp"
#include "ident/validate/metrics.hpp"

// The force that an imposed motion takes, with a memory or without.

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using std::size_t;

/// Some of the candidates, fitted.
struct Law {
  std::vector<int> terms;    ///< ascending
  std::vector<double> mean;  ///< of each
  state_space::OutputError fit;
  double score = std::numeric_limits<double>::infinity();  ///< -2 log likelihood and the price of the terms
  [[nodiscard]] MatrixXd inverse_curvature() const {
    const MatrixXd R = dsp::inverse_of_upper(dsp::Qr(fit.slopes).triangle());
    return R * R.transpose();
  }
};

class Search {
 public:
  Search(const Choice& choice, int num_threads) : choice_(choice), num_threads_(num_threads) {
    std::vector<Index> samples, first_rows;
    Index at = 0;
    for (const state_space::Record& record : choice.statement.problem.records) {
      first_rows.push_back(std::ssize(samples));
      for (Index k = 0; k < record.channels.rows(); ++k) samples.push_back(at++);
      ++at;  // no lag reaches from one record to the next
    }
    num_rows_ = static_cast<double>(samples.size());
    rows_.emplace(samples, first_rows);
  }
  /// Least squares on these terms, from these values; nothing where they run away.
  [[nodiscard]] std::optional<Law> law(const std::vector<int>& terms, const std::vector<double>& from) const;
  /// From the law of all terms down to that of the best score.
  [[nodiscard]] Law best_of(Law law);
  /// Rows count by the residual of this law, for all scores.
  void count_rows(const Law& law) { num_independent_ = rows_->fraction(law.fit.residual) * num_rows_; }
  [[nodiscard]] double price() const {
    return std::log(num_independent_) + 2.0 * std::log(static_cast<double>(choice_.candidates.size()));
  }
  [[nodiscard]] double num_independent() const { return num_independent_; }
  [[nodiscard]] bool remembers(const std::vector<int>& terms) const {
    return std::any_of(terms.begin(), terms.end(), [&](int i) { return is_of_z(i); });
  }
  [[nodiscard]] bool is_of_z(int term) const { return choice_.candidates[static_cast<size_t>(term)].body > 1; }
  [[nodiscard]] double score_of(const Law& law) const;

 private:
  [[nodiscard]] std::optional<Law> without(const Law& law, size_t place, const MatrixXd& inverse) const;

  const Choice& choice_;
  int num_threads_;
  double num_rows_ = 0.0, num_independent_ = 1.0;
  std::optional<IndependentRows> rows_;
};

std::optional<Law> Search::law(const std::vector<int>& terms, const std::vector<double>& from) const {
  BodiesLayout layout = choice_.layout;
  if (!remembers(terms)) layout.inner = Inner::none;
  std::vector<BodyTerm> named;
  for (const int i : terms) named.push_back(choice_.candidates[static_cast<size_t>(i)]);
  state_space::Problem problem = choice_.statement.problem;
  problem.equations = equations_of(layout, named);
  std::optional<state_space::OutputError> fit = state_space::output_error(
      problem, {.coefficients = from,
                .free_states = layout.inner == Inner::none ? std::vector<int>{} : std::vector<int>{1},
                .num_threads = num_threads_});
  if (!fit) return std::nullopt;
  Law law{.terms = terms, .mean = {}, .fit = std::move(*fit)};
  law.mean.assign(law.fit.point.parameters.begin(),
                  law.fit.point.parameters.begin() + static_cast<std::ptrdiff_t>(terms.size()));
  law.score = score_of(law);
  return law;
}

double Search::score_of(const Law& law) const {
  const double per_row = law.fit.squares() / num_rows_;
  const auto num_paid = static_cast<double>(law.terms.size() + (remembers(law.terms) ? 1 : 0));  // z itself
  return num_independent_ * std::log(per_row) + price() * num_paid;
}

// The others begin where the quadratic about the law has them once this one is zero.
std::optional<Law> Search::without(const Law& law, size_t place, const MatrixXd& inverse) const {
  std::vector<int> terms = law.terms;
  std::vector<double> from = law.mean;
  const auto at = static_cast<Index>(place);
  for (size_t i = 0; i < from.size(); ++i)
    from[i] -= inverse(static_cast<Index>(i), at) / inverse(at, at) * law.mean[place];
  terms.erase(terms.begin() + static_cast<std::ptrdiff_t>(place));
  from.erase(from.begin() + static_cast<std::ptrdiff_t>(place));
  return this->law(terms, from);
}

Law Search::best_of(Law law) {
  constexpr double far_above = 4.0;  // prices: no later one has made up for as much
  law.score = score_of(law);
  Law best = law;
  while (law.terms.size() > 1) {
    const MatrixXd inverse = law.inverse_curvature();
    if (!inverse.allFinite()) break;
    size_t least = 0;
    const auto rise = [&](size_t i) {
      return law.mean[i] * law.mean[i] / inverse(static_cast<Index>(i), static_cast<Index>(i));
    };
    for (size_t i = 1; i < law.terms.size(); ++i)
      if (rise(i) < rise(least)) least = i;
    std::optional<Law> fewer = without(law, least, inverse);
    if (!fewer) break;
    law = std::move(*fewer);
    if (law.score < best.score) best = law;
    if (law.score > best.score + far_above * price()) break;
  }
  return best;
}

/// Where a search for z begins: a force that follows the motion with a stiffness and turns into a yield force of the
/// size of f after these parts of the stroke, z' = k (v - (z^2 v + |v| z |z|) / (2 F^2)) [Wen76].
std::vector<std::vector<double>> yielding(const Choice& choice, const std::vector<int>& terms) {
  double squares = 0.0, stroke = 0.0, count = 0.0;
  for (const state_space::Record& record : choice.statement.problem.records) {
    const auto f = record.channels.col(0);
    squares += (f.array() - f.mean()).square().sum(), count += static_cast<double>(f.size());
    stroke = std::max(stroke, record.inputs.col(0).cwiseAbs().maxCoeff());
  }
  const double yield = std::numbers::sqrt2 * std::sqrt(squares / count);
  std::vector<std::vector<double>> starts;
  for (const double part : {0.05, 0.15, 0.4}) {
    const double stiffness = yield / (part * stroke), bends = -0.5 * stiffness / (yield * yield);
    std::vector<double>& start = starts.emplace_back(terms.size(), 0.0);
    for (size_t i = 0; i < terms.size(); ++i) {
      const BodyTerm& term = choice.candidates[static_cast<size_t>(terms[i])];
      if (term.body == 1) continue;
      if (term.name == "v") start[i] = stiffness;
      if (term.name == "z^2*v" || term.name == "z*abs(z)*abs(v)") start[i] = bends;
    }
  }
  return starts;
}

/// Samples as dense as this say all of a force that follows the motion.
Index thinned_by(const BodiesRecord& record, const std::vector<dsp::IndexRange>& train) {
  constexpr double a_period = 128.0, least = 3000.0;
  const VectorXd x = record.input_samples.col(0).array() - record.input_samples.col(0).mean();
  const auto v = std::find(record.inputs.begin(), record.inputs.end(), "v") - record.inputs.begin();
  const double hz = record.input_samples.col(v).norm() / x.norm() / dsp::two_pi;
  Index count = 0;
  for (const dsp::IndexRange& one : train) count += one.last - one.first;
  const double factor = std::min(record.sample_rate_hz / (a_period * hz), static_cast<double>(count) / least);
  return std::isfinite(factor) ? std::max<Index>(1, static_cast<Index>(factor)) : 1;
}

/// By how much process noise would raise the likelihood at least: what is left, over white noise of the size that the
/// end of the spectrum of f shows.
double gain_beyond_noise(double variance, double floor, double num_independent) {
  const double ratio = variance / (floor * floor);
  return ratio > 1.0 ? num_independent * (ratio - 1.0 - std::log(ratio)) : 0.0;
}

/// As selections by the likelihood are.
void take(Choice& choice, const Law& law, const Search& search) {
  state_space::Fit& fit = choice.selection.fit;
  const auto k = std::ssize(law.terms);
  const double num_rows = static_cast<double>(law.fit.residual.size()), variance = law.fit.squares() / num_rows;
  const MatrixXd covariance =
      law.inverse_curvature().topLeftCorner(k, k) * (variance * num_rows / search.num_independent());
  BlockScores blocks(law.fit.slopes.cols(), law.fit.slopes.rows());
  blocks.add(law.fit.slopes, law.fit.residual);
  const MatrixXd scattered = robust_covariance(r_factor(law.fit.slopes, law.fit.residual), blocks);
  const auto row_by_row = [&](const MatrixXd& values) {
    std::vector<double> list;
    for (Index i = 0; i < k; ++i)
      for (Index j = 0; j < k; ++j) list.push_back(values(i, j));
    return list;
  };
  fit.covariance = row_by_row(covariance);
  if (scattered.size() > 0) fit.scattered = row_by_row(scattered);
  fit.parameters = law.terms;
  fit.point = {std::vector<double>(choice.candidates.size(), 0.0), law.fit.point.states};
  choice.selection.price = search.price();
  choice.selection.scores.assign(choice.candidates.size(), {});
  for (Index i = 0; i < k; ++i) {
    const auto place = static_cast<size_t>(i), term = static_cast<size_t>(law.terms[place]);
    fit.point.parameters[term] = law.mean[place];
    const double gain = law.mean[place] * law.mean[place] / covariance(i, i);
    choice.selection.scores[term] = {gain, 1.0 / (1.0 + std::exp(0.5 * (choice.selection.price - gain)))};
  }
  if (!search.remembers(law.terms)) choice.layout.inner = Inner::none;
  fit.noise.process.assign(static_cast<size_t>(choice.layout.num_states()), 0.0);
  fit.residual_std = {std::sqrt(variance)};
  fit.gain_of_process_noise = gain_beyond_noise(variance, fit.floors.front(), search.num_independent());
  fit.settled = law.fit.settled, fit.at_floor = true;
}

}  // namespace

Choice choose_force(const BodiesRecord& record, const BodiesOptions& options, BodiesResult& result) {
  Choice choice{.record = in_frame(record, Frame::ground)};
  choice.layout = {.num_bodies = 1, .inputs = choice.record.inputs, .inner = options.inner, .imposed = true};
  choice.layout.force_unit = record.channels.front().unit;
  choice.candidates = candidates_of(choice.layout, options.library);
  choice.statement = statement_of(choice.record, choice.layout, choice.candidates, {}, result.train,
                                  thinned_by(choice.record, result.train));
  if (choice.statement.problem.records.empty())
    throw dsp::Fault(dsp::FaultKind::input, "bodies.short",
                     record.name + ": too few samples are left to be fitted. Record longer");
  Search search(choice, options.num_threads);
  std::vector<int> all(choice.candidates.size()), plain;
  std::iota(all.begin(), all.end(), 0);
  for (const int i : all)
    if (!search.is_of_z(i)) plain.push_back(i);
  std::optional<Law> with, without = search.law(plain, {});
  if (options.inner == Inner::hysteresis)
    for (const std::vector<double>& start : yielding(choice, all))
      if (std::optional<Law> one = search.law(all, start); one && (!with || one->fit.squares() < with->fit.squares()))
        with = std::move(one);
  result.sought = options.inner;
  state_space::Fit& fit = choice.selection.fit;
  fit.floors = state_space::noise_floors(choice.statement.problem);
  fit.noise = {std::vector<double>(static_cast<size_t>(choice.layout.num_states()), 0.0), fit.floors};
  result.gain_of_inner = dsp::nan;
  if (!with && !without) return choice;  // its fit has not come to rest
  search.count_rows(with ? *with : *without);
  if (with) with = search.best_of(std::move(*with));
  if (without) without = search.best_of(std::move(*without));
  if (with && without) result.gain_of_inner = without->score - with->score;
  take(choice, with && !(result.gain_of_inner <= 0.0) ? *with : *without, search);
  return choice;
}

}  // namespace ident
