#include "ident/selection/evidence_data.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ident/range_data.hpp"
#include "ident/rows_of_terms.hpp"
#include "ident/selection/autoregression.hpp"
#include "ident/selection/evidence_rows.hpp"
#include "ident/selection/model_sizes.hpp"
#include "ident/selection/record_coefficients.hpp"
#include "ident/selection/settled_model.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// How much a reader takes each term for: the constant for nothing, a signal or a sign for one, a product for its
/// degree.
VectorXd complexity(const std::vector<const Term*>& terms) {
  VectorXd result(std::ssize(terms));
  for (Index i = 0; i < result.size(); ++i) {
    const Term& term = *terms[static_cast<std::size_t>(i)];
    result(i) = term.name == "1" ? 0.0 : std::max(1.0, term.expression.band_factor());
  }
  return result;
}

/// By what the rows count.
RFactor thinned_to(RFactor data, double fraction) {
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
VectorXd target_beside_sensors(const EvidenceRows& rows) {
  if (!rows.range.sensors) return rows.range.train;
  const std::vector<Row>& train = rows.result.rows.train;
  const Fit found = fit_fast_rvm(rows.range.data, {.poll = rows.options.poll});
  std::vector<Index> terms;
  for (const Index position : found.relevant) terms.push_back(rows.range.terms[static_cast<std::size_t>(position)]);
  VectorXd left = rows.range.train;
  RowsOfTerms(train, rows.recordings, terms).for_each_block([&](Index first, const MatrixXd& phi) {
    left.segment(first, phi.rows()) -= phi * found.mean;
  });
  double fraction = 1.0;
  const SensorPosterior beside = sensors_beside(found, found.relevant, rows.range, train, nullptr, left, fraction);
  return rows.range.train - rows.range.sensors->effect(train, beside.sensor_mean);
}

/// Whitens the rows where that makes the residual of all terms white.
void whiten(EvidenceRows& rows, const IndependentRows& independence) {
  const auto is_white = [&] {
    const RecordProblems problems(rows.factors(), rows.options.poll);
    return !(independence.fraction(rows.residual(problems, all_columns(rows.num_terms()))) < white_enough);
  };
  if (is_white()) return;
  rows.weighting.rho =
      autoregression(rows.size(), rows.num_terms(), rows.largest(rows.target), rows.reader(rows.target),
                     rows.weighting.begins, rows.options.num_threads, rows.range.first_rows);
  if (!is_white()) rows.weighting.rho = 0.0;  // it is no such noise
}

/// Gives each of several records the weight that makes what all terms leave of it as large as in all together.
void weigh_records(EvidenceRows& rows) {
  if (rows.records().size() < 2) return;
  const auto b = static_cast<double>(rows.num_terms());
  std::vector<double> variance;
  double pooled = 0.0;
  for (const RFactor& factor : rows.factors()) {
    const auto n = static_cast<double>(factor.num_samples);
    const double norm = factor.R.col(factor.num_terms).stableNorm(),
                 left = factor.R(factor.num_terms, factor.num_terms);
    if (!(left * left > rounding_power * norm * norm) || n <= b + 1.0) return;  // exact data have no noise to weigh by
    variance.push_back(left * left / (n - b));
    pooled += n / static_cast<double>(rows.size()) * variance.back();
  }
  for (const double own : variance) rows.weighting.weight.push_back(std::sqrt(pooled / own));
}

/// The range's regression with its sensors on weighted rows, of all records or of one.
SensorRegression sensor_regression(const EvidenceRows& rows, const RecordRows* record = nullptr) {
  const RangeData& range = rows.range;
  const std::vector<Row>& train = rows.result.rows.train;
  SensorRegression regression = range.joint;
  regression.joint = rows.factor(
      range.joint.num_sensors(), range.sensors->largest(train),
      [&](Index first, Eigen::Ref<MatrixXd> block) { range.sensors->read(train, first, block); }, range.train, record);
  for (std::size_t i = 0; i < range.means.recordings.size(); ++i)
    for (std::size_t k = 0; k < rows.records().size(); ++k) {
      const RecordRows& one = rows.records()[k];
      if (one.recording != range.means.recordings[i] || (record != nullptr && record->first != one.first)) continue;
      const double weight = rows.weighting.weight.empty() ? 1.0 : rows.weighting.weight[k];
      // The mean of an autoregression is that of its innovations over 1 - rho.
      add_rows(regression, weight * (1.0 - rows.weighting.rho) * range.means.rows.row(static_cast<Index>(i)));
    }
  return regression;
}

/// The records as what their sensors leave of them, each its own: those explain no more than is known of them lets
/// them.
RecordProblems beside_sensors(const EvidenceRows& rows, double fraction) {
  const double noise = noise_beside_all(sensor_regression(rows)) / std::sqrt(fraction);
  std::vector<RFactor> factors;
  for (const RecordRows& record : rows.records())
    factors.push_back(without_sensors(sensor_regression(rows, &record), noise));
  return RecordProblems(factors, rows.options.poll);
}

/// Fills in what follows from the rows, their size and the model.
void form_data(EvidenceData& evidence, const EvidenceRows& rows) {
  const RangeData& range = rows.range;
  evidence.weighting = rows.weighting;
  const double fraction = evidence.size.fraction();
  if (!range.sensors) {
    if (rows.weighting.changes_rows()) evidence.data = rows.factor(0, Eigen::RowVectorXd(), {}, range.train);
  } else {
    if (rows.weighting.changes_rows()) {
      evidence.joint = sensor_regression(rows);
      evidence.noise_std = noise_beside_all(evidence.joint);
    }
    evidence.data = without_sensors(evidence.joint, evidence.noise_std / std::sqrt(fraction));
  }
  if (fraction < white_enough) {
    evidence.data = thinned_to(std::move(evidence.data), fraction);
    if (rows.records().size() < 2)
      evidence.terms = without_idle(evidence.data, std::move(*evidence.terms), rows.options.poll);
  }
}

}  // namespace

bool EvidenceData::as_they_are() const {
  return size.autoregression == 0.0 && size.fraction() >= white_enough && weighting.records.size() < 2;
}

EvidenceData evidence_data(const RangeData& range, const RangeResult& result, const std::vector<Columns>& recordings,
                           const CandidateLibrary& library, const IdentifyOptions& options) {
  const auto n = static_cast<double>(range.train.size());
  EvidenceData evidence{range.data, {n, n}, std::nullopt, {}, {}, range.joint, range.noise_std, {}};
  if (range.train.size() <= std::ssize(range.terms) + 1 || range.train.isZero(0.0)) return evidence;
  EvidenceRows rows(range, result, recordings, options);
  rows.target = target_beside_sensors(rows);
  std::vector<const Term*> terms;
  for (const Index j : range.terms) terms.push_back(&library.terms[static_cast<std::size_t>(j)]);
  const StateSpace state(terms, result.rows.train, recordings, options.target);
  const IndependentRows independence(range.train_samples, range.first_rows);
  whiten(rows, independence);
  weigh_records(rows);

  const ModelSizes sizes(rows, state, independence);
  Settled settled = settled_model(sizes.problems(), [&](const Subset& model) { return sizes.of(model); });
  evidence.size = settled.size;
  evidence.path = std::move(settled.path);
  for (ModelOfSize& model : evidence.path)
    for (Index& term : model.terms) term = range.terms[static_cast<std::size_t>(term)];
  const bool several = rows.records().size() > 1, white = evidence.size.fraction() >= white_enough;
  if (white && rows.weighting.rho == 0.0 && !several) return evidence;
  if (!white) prefer_simpler(settled, sizes.problems(), complexity(terms));
  if (!white || several) evidence.terms = settled.model.terms;
  if (several) {
    const auto coefficients = [&](const RecordProblems& problems) {
      return record_coefficients(problems, settled.model.terms, evidence.size);
    };
    RecordCoefficients found =
        coefficients(range.sensors ? beside_sensors(rows, evidence.size.fraction()) : sizes.problems());
    evidence.terms = std::move(found.terms);
    evidence.differing = std::move(found.differing);
  }
  form_data(evidence, rows);
  return evidence;
}

EvidenceData evidence_by_record(const EvidenceData& found, const std::vector<Index>& terms, const RangeData& range,
                                const RangeResult& result, const std::vector<Columns>& recordings,
                                const IdentifyOptions& options) {
  EvidenceData evidence{range.data, found.size, terms, {}, {}, range.joint, range.noise_std, {}};
  EvidenceRows rows(range, result, recordings, options);
  rows.weighting = found.weighting;
  form_data(evidence, rows);
  return evidence;
}

}  // namespace ident
