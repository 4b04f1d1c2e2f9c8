#include "ident/selection/evidence_data.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "dsp/filter/strongest_line.hpp"
#include "ident/range_data.hpp"
#include "ident/rows_of_terms.hpp"
#include "ident/selection/autoregression.hpp"
#include "ident/selection/best_subsets.hpp"
#include "ident/selection/state_space.hpp"
#include "ident/validate/independent_rows.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Above this fraction of the rows a residual is white: chance correlations of white ones cost up to a tenth.
constexpr double white_enough = 0.9;
// Power of a residual, as a fraction of the target's, that is rounding of sums over up to 1e6 rows, not structure.
constexpr double rounding = 1e-24;
// What a term must gain in twice the log evidence however likely it was beforehand: what it costs in prediction.
constexpr double least_gain = 2.0;
constexpr Index largest_model = 60;  // candidates that are tried together: a path grows with the cube of its length

/// The candidates and the target on the training rows, without what the sensors add to it.
struct Rows {
  const RangeData& range;
  const RangeResult& result;
  const std::vector<Columns>& recordings;
  const IdentifyOptions& options;
  VectorXd target;
  std::vector<unsigned char> begins;
  double rho = 0.0;

  [[nodiscard]] Index size() const { return target.size(); }
  [[nodiscard]] Index num_terms() const { return std::ssize(range.terms); }
  /// Rows of [Phi t], as they are.
  [[nodiscard]] RowReader reader(const VectorXd& its_target) const {
    return [this, &its_target, columns = RowsOfTerms(result.rows.train, recordings, range.terms)](
               Index first, Eigen::Ref<MatrixXd> block) {
      if (options.poll) options.poll();
      columns.read(first, block.leftCols(num_terms()));
      block.rightCols(1) = its_target.segment(first, block.rows());
    };
  }
  /// Greatest magnitude in each of their columns.
  [[nodiscard]] Eigen::RowVectorXd largest(const VectorXd& its_target) const {
    Eigen::RowVectorXd values(num_terms() + 1);
    values << range.scale(range.terms).transpose(), its_target.cwiseAbs().maxCoeff();
    return values;
  }
  /// R of [front Phi t], `read_front` writing the first columns; whitened.
  [[nodiscard]] RFactor factor(Index num_front, const Eigen::RowVectorXd& largest_front, const RowReader& read_front,
                               const VectorXd& its_target) const {
    RowReader read = [&, num_front, own = reader(its_target)](Index first, Eigen::Ref<MatrixXd> block) {
      own(first, block.rightCols(num_terms() + 1));
      if (num_front > 0) read_front(first, block.leftCols(num_front));
    };
    Eigen::RowVectorXd greatest(num_front + num_terms() + 1);
    greatest << largest_front, largest(its_target);
    if (rho != 0.0) read = whitened(std::move(read), begins, rho);
    return r_factor(size(), num_front + num_terms(), greatest, read, options.num_threads);
  }
  /// Of a term of the library, whitened.
  [[nodiscard]] VectorXd column(Index term) const {
    VectorXd values(size());
    RowsOfTerms(result.rows.train, recordings, {term}).for_each_block([&](Index first, const MatrixXd& phi) {
      values.segment(first, phi.rows()) = phi.col(0);
    });
    return rho == 0.0 ? values : whitened_values(values, begins, rho);
  }
  /// What these coefficients of candidates leave, whitened.
  [[nodiscard]] VectorXd residual(const std::vector<Index>& positions, const VectorXd& mean) const {
    std::vector<Index> terms;
    for (const Index position : positions) terms.push_back(range.terms[static_cast<std::size_t>(position)]);
    VectorXd left = target;
    RowsOfTerms(result.rows.train, recordings, terms).for_each_block([&](Index first, const MatrixXd& phi) {
      left.segment(first, phi.rows()) -= phi * mean;
    });
    return rho == 0.0 ? left : whitened_values(left, begins, rho);
  }
  /// Least-squares coefficients of these candidates.
  [[nodiscard]] static VectorXd coefficients(const UnitProblem& problem, const std::vector<Index>& positions) {
    const VectorXd lambda = VectorXd::Constant(std::ssize(positions), flat_lambda);
    const VectorXd mean = posterior(problem, positions, lambda).mean.col(0);
    return (mean.array() * problem.target_norm(0) / problem.column_norm(positions).array()).matrix();
  }
};

/// At most a quarter of the period of the motion: rows closer than that share their misfit.
Index quarter_period(const Rows& rows) {
  const Row& row = rows.result.rows.train.front();
  const dsp::Motion& signals = *rows.recordings[row.recording].signals;
  const dsp::Signal* x = signals.find("x");
  const double rate_hz = signals.sample_rate_hz;
  const double line_hz = dsp::strongest_line(x != nullptr ? x->values : rows.target, rate_hz).frequency_hz;
  return line_hz > 0.0 ? std::max<Index>(1, static_cast<Index>(rate_hz / line_hz / 4.0)) : rows.size();
}

/// Effective sizes of models, by what they leave.
class ModelSizes {
 public:
  ModelSizes(const Rows& rows, const StateSpace& state, const IndependentRows& independence)
      : rows_(rows), independence_(independence) {
    const Index q = state.num_probes();
    const RFactor probed = rows.factor(
        q, Eigen::RowVectorXd::Ones(q),
        [&](Index first, Eigen::Ref<MatrixXd> block) { state.read_probes(first, block); }, rows.target);
    // The candidates first: probes then count beyond them only.
    const Index b = rows.num_terms();
    MatrixXd columns(probed.R.rows(), q + b + 1);
    columns << probed.R.middleCols(q, b), probed.R.leftCols(q), probed.R.rightCols(1);
    const MatrixXd R = triangle(columns);
    problem_ = unit_problem(candidates(R), rows.options.poll);
    const VectorXd norms = R.middleCols(b, q).colwise().stableNorm();
    MatrixXd beyond = R.block(b, b, q, q);
    for (Index j = 0; j < q; ++j) beyond.col(j) *= norms(j) > 0.0 ? 1.0 / norms(j) : 0.0;
    const VectorXd target = R.col(b + q).segment(b, q) / problem_.target_norm(0);
    const Eigen::JacobiSVD<MatrixXd> svd(beyond, Eigen::ComputeThinU);
    constexpr double independent = 0.02;  // of a unit-norm probe that lies beyond all candidates
    num_probes_ = (svd.singularValues().array() > independent).count();
    const double last = R(b + q, b + q) / problem_.target_norm(0);
    rss_of_all_ =
        last * last + target.squaredNorm() - (svd.matrixU().leftCols(num_probes_).transpose() * target).squaredNorm();
    const std::vector<Index> all = all_columns(b);
    const VectorXd left = rows.residual(all, Rows::coefficients(problem_, all));
    const Index apart = std::min(independence.first_lag_within_chance(left), quarter_period(rows));
    if (independence.fraction(left) < white_enough) noise_fraction_ = least_fraction(left);
    pairs_ = state.revisits(apart, rows.range.train_samples, rows.range.first_rows);
  }
  [[nodiscard]] const UnitProblem& problem() const { return problem_; }
  [[nodiscard]] EffectiveSize of(const Subset& model) const {
    const VectorXd left = rows_.residual(model.terms, Rows::coefficients(problem_, model.terms));
    EffectiveSize size;
    size.num_rows = static_cast<double>(rows_.size());
    size.num_uncorrelated = independence_.fraction(left) * size.num_rows;
    size.num_noise = std::max(size.num_uncorrelated, noise_fraction_ * size.num_rows);
    size.num_states = static_cast<double>(rows_.num_terms() + num_probes_);
    size.autoregression = rows_.rho;
    if (model.rss > rounding) {
      size.revisit_fraction = by_revisits(left);
      size.structural_fraction = std::fmax(size.revisit_fraction, by_probes(model, size));
    } else {
      size.num_uncorrelated = size.num_noise = size.num_rows;
    }
    return size;
  }

 private:
  [[nodiscard]] RFactor candidates(const MatrixXd& R) const {
    const Index b = rows_.num_terms();
    MatrixXd columns(R.rows(), b + 1);
    columns << R.leftCols(b), R.rightCols(1);
    return {triangle(columns), b, rows_.size()};
  }
  /// Of the rows, for the candidate to which noise as coloured as what all leave does most.
  [[nodiscard]] double least_fraction(const VectorXd& left) const {
    double least = 1.0;
    for (const Index term : rows_.range.terms) {
      if (rows_.options.poll) rows_.options.poll();
      least = std::min(least, independence_.fraction_for(rows_.column(term), left));
    }
    return least;
  }
  /// What does not differ between rows in the same state is a function of it; NaN: too few are.
  [[nodiscard]] double by_revisits(const VectorXd& left) const {
    const auto count = static_cast<double>(pairs_.size());
    if (count < 10.0) return std::numeric_limits<double>::quiet_NaN();
    const double unit = left.cwiseAbs().maxCoeff();  // squares of smaller ones may vanish
    if (!(unit > 0.0)) return 0.0;
    double within = 0.0, within_square = 0.0, all = 0.0;
    for (const auto& [i, j] : pairs_) {
      const double one = left(i) / unit, other = left(j) / unit;
      const double difference = 0.5 * (one - other) * (one - other);
      within += difference;
      within_square += difference * difference;
      all += 0.5 * (one * one + other * other);
    }
    within /= count, all /= count;
    if (!(all > 0.0)) return 0.0;
    const double variance = std::max(0.0, within_square / count - within * within);
    // Half of the rows are in two pairs: 1.5 times the deviation of independent ones, to be safe.
    const double error = 1.5 * std::sqrt(variance / count) / all;
    return std::clamp(1.0 - within / all - 2.0 * error, 0.0, 1.0);
  }
  /// What the left-out candidates and the probes explain beyond chance.
  [[nodiscard]] double by_probes(const Subset& model, const EffectiveSize& size) const {
    const auto k = static_cast<double>(model.terms.size());
    const double others = size.num_states - k, spare = size.num_uncorrelated - k;
    constexpr double fewest = 3.0;
    if (spare - others < fewest) return size.num_uncorrelated < white_enough * size.num_rows ? 1.0 : 0.0;
    const double noise = std::max(0.0, rss_of_all_) / (spare - others), left = model.rss / spare;
    return std::clamp(1.0 - noise / left - 2.0 * std::sqrt(2.0 * others) / spare, 0.0, 1.0);
  }

  const Rows& rows_;
  const IndependentRows& independence_;
  UnitProblem problem_;
  Index num_probes_ = 0;
  double noise_fraction_ = 1.0;
  double rss_of_all_ = 0.0;
  std::vector<RowPair> pairs_;
};

/// The model that is settled on, and its size.
struct Settled {
  Subset model;
  EffectiveSize size;
  std::vector<ModelOfSize> path;
};

double threshold(double num_effective, Index num_terms) {
  return gain_threshold(Selection::evidence, -1.0, std::max<Index>(2, std::lround(num_effective)), num_terms);
}

/// See evidence_data.
Settled settled_model(const ModelSizes& sizes, Index num_terms) {
  const std::vector<Subset> path = best_subsets(sizes.problem(), std::min(num_terms, largest_model));
  std::vector<std::optional<EffectiveSize>> known(path.size());
  const auto size_of = [&](std::size_t l) -> const EffectiveSize& {
    if (!known[l]) known[l] = sizes.of(path[l]);
    return *known[l];
  };
  std::size_t settled = 0;
  for (std::size_t l = 1; l < path.size(); ++l) {
    const double n = size_of(l).num_effective(), more = static_cast<double>(l - settled);
    const double gain = std::max(n - static_cast<double>(l), 0.0) *
                        std::log(path[settled].rss / std::max(path[l].rss, rounding * rounding));
    if (gain > std::max(least_gain * more, model_cost(n, num_terms, l) - model_cost(n, num_terms, settled)))
      settled = l;
  }
  std::vector<ModelOfSize> compared;
  for (std::size_t l = 0; l < path.size(); ++l)
    compared.push_back({path[l].terms, path[l].rss, l == 0 ? 0.0 : size_of(l).num_effective()});
  return {path[settled], size_of(settled), std::move(compared)};
}

/// How much a reader takes a term for: the constant for nothing, a signal or a sign for one, a product for its degree.
double complexity(const Term& term) {
  return term.name == "1" ? 0.0 : std::max(1.0, term.expression.band_factor());
}

/// Of models that differ by the exchange of one term and cannot be told apart, the simplest.
void prefer_simpler(Settled& settled, const UnitProblem& problem, const std::vector<const Term*>& terms) {
  const double spare = settled.size.num_effective() - static_cast<double>(settled.model.terms.size());
  if (spare < 2.0) return;
  const double limit = threshold(settled.size.num_effective(), problem.num_terms()), least = settled.model.rss;
  const auto weight = [&](Index term) { return complexity(*terms[static_cast<std::size_t>(term)]); };
  while (true) {
    std::optional<Subset> simpler;
    double most_saved = 0.0;
    for (const Index leaving : settled.model.terms)
      for (Index i = 0; i < problem.num_terms(); ++i) {
        const double saved = weight(leaving) - weight(i);
        if (!(saved > most_saved) || std::binary_search(settled.model.terms.begin(), settled.model.terms.end(), i))
          continue;
        std::vector<Index> exchanged = settled.model.terms;
        std::replace(exchanged.begin(), exchanged.end(), leaving, i);
        std::sort(exchanged.begin(), exchanged.end());
        const double rss = least_squares_rss(problem, exchanged);
        if (spare * std::log(rss / least) >= limit) continue;
        simpler = Subset{std::move(exchanged), rss};
        most_saved = saved;
      }
    if (!simpler) return;
    settled.model = std::move(*simpler);
  }
}

/// By what the rows count.
RFactor weighted(RFactor data, double fraction) {
  const auto n = std::max<Index>(2, std::lround(fraction * static_cast<double>(data.num_samples)));
  data.R *= std::sqrt(static_cast<double>(n) / static_cast<double>(data.num_samples));
  data.num_samples = n;
  return data;
}

/// These terms less those that the sensors take the place of, beside which `data` is.
std::vector<Index> without_idle(const RFactor& data, std::vector<Index> terms, const Poll& poll) {
  const UnitProblem problem = unit_problem(data, poll);
  while (!terms.empty()) {
    Subset fewer = without_weakest(problem, terms);
    const double spare = std::max(0.0, static_cast<double>(data.num_samples) - static_cast<double>(terms.size()));
    if (spare * std::log(fewer.rss / least_squares_rss(problem, terms)) >= least_gain) break;
    terms = std::move(fewer.terms);
  }
  return terms;
}

/// The target without what the sensors make of it beside the white rule's equation.
VectorXd target_beside_sensors(const Rows& rows) {
  if (!rows.range.sensors) return rows.range.train;
  const Fit found = fit_fast_rvm(rows.range.data, {.poll = rows.options.poll});
  double fraction = 1.0;
  const VectorXd left = rows.residual(found.relevant, found.mean);
  const SensorPosterior beside =
      sensors_beside(found, found.relevant, rows.range, rows.result.rows.train, nullptr, left, fraction);
  return rows.range.train - rows.range.sensors->effect(rows.result.rows.train, beside.sensor_mean);
}

}  // namespace

bool EvidenceData::as_they_are() const {
  return size.autoregression == 0.0 && size.fraction() >= white_enough;
}

EvidenceData evidence_data(const RangeData& range, const RangeResult& result, const std::vector<Columns>& recordings,
                           const CandidateLibrary& library, const IdentifyOptions& options) {
  const auto n = static_cast<double>(range.train.size());
  EvidenceData evidence{range.data, {n, n}, std::nullopt, {}, range.joint, range.noise_std, {}};
  if (range.train.size() <= std::ssize(range.terms) + 1 || range.train.isZero(0.0)) return evidence;
  Rows rows{range, result, recordings, options, range.train, run_begins(range.train_samples, range.first_rows)};
  rows.target = target_beside_sensors(rows);
  std::vector<const Term*> terms;
  for (const Index j : range.terms) terms.push_back(&library.terms[static_cast<std::size_t>(j)]);
  const StateSpace state(terms, result.rows.train, recordings, options.target);
  const IndependentRows independence(range.train_samples, range.first_rows);

  const RFactor plain = rows.factor(0, Eigen::RowVectorXd(), {}, rows.target);
  const auto full_residual = [&] {
    const UnitProblem problem =
        unit_problem(rows.rho == 0.0 ? plain : rows.factor(0, Eigen::RowVectorXd(), {}, rows.target));
    const std::vector<Index> all = all_columns(rows.num_terms());
    return rows.residual(all, Rows::coefficients(problem, all));
  };
  if (independence.fraction(full_residual()) < white_enough) {
    rows.rho = autoregression(rows.size(), rows.num_terms(), rows.largest(rows.target), rows.reader(rows.target),
                              rows.begins, options.num_threads);
    if (independence.fraction(full_residual()) < white_enough) rows.rho = 0.0;  // it is no such noise
  }
  const ModelSizes sizes(rows, state, independence);
  Settled settled = settled_model(sizes, rows.num_terms());
  evidence.size = settled.size;
  evidence.path = std::move(settled.path);
  if (evidence.as_they_are()) return evidence;
  if (evidence.size.fraction() < white_enough) {
    prefer_simpler(settled, sizes.problem(), terms);
    evidence.terms = settled.model.terms;
  }
  evidence.begins = rows.begins;
  if (!range.sensors) {
    if (rows.rho != 0.0) evidence.data = rows.factor(0, Eigen::RowVectorXd(), {}, range.train);
  } else {
    if (rows.rho != 0.0) {
      const std::vector<Row>& train = result.rows.train;
      evidence.joint.joint = rows.factor(
          range.joint.num_sensors(), range.sensors->largest(train),
          [&](Index first, Eigen::Ref<MatrixXd> block) { range.sensors->read(train, first, block); }, range.train);
      evidence.noise_std = noise_beside_all(evidence.joint);
    }
    evidence.data = without_sensors(evidence.joint, evidence.noise_std / std::sqrt(evidence.size.fraction()));
  }
  if (evidence.size.fraction() < white_enough) {
    evidence.data = weighted(std::move(evidence.data), evidence.size.fraction());
    evidence.terms = without_idle(evidence.data, std::move(*evidence.terms), options.poll);
  }
  return evidence;
}

}  // namespace ident
