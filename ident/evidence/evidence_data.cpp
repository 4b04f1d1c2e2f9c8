#include "ident/evidence/evidence_data.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ident/evidence/evidence_rows.hpp"
#include "ident/evidence/model_sizes.hpp"
#include "ident/evidence/range_data.hpp"
#include "ident/selection/autoregression.hpp"
#include "ident/selection/record_coefficients.hpp"
#include "ident/selection/select_size.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// By what the rows count.
RFactor thinned_to(RFactor data, double fraction) {
  const auto n = std::max<Index>(2, std::lround(fraction * static_cast<double>(data.num_samples)));
  data.R *= std::sqrt(static_cast<double>(n) / static_cast<double>(data.num_samples));
  data.num_samples = n;
  return data;
}

/// Forms the regressions and settles the noise of the sensors: sensors, hence residual of all terms, hence by what
/// fraction its rows count, hence sensors. That fraction.
double formed(EvidenceRows& rows, const IndependentRows& independence) {
  rows.form();
  double fraction = 1.0;
  for (int pass = 0; pass < (rows.range.sensors ? 2 : 1); ++pass) {
    rows.count_by(fraction);
    fraction = independence.fraction(rows.residual(rows.problems(), all_columns(rows.num_terms())));
  }
  return fraction;
}

/// Whitens the rows where that makes the residual of all terms white.
void whiten(EvidenceRows& rows, const IndependentRows& independence) {
  if (!(formed(rows, independence) < white_enough)) return;
  const VectorXd target = rows.target_beside_sensors(rows.problems(), all_columns(rows.num_terms()));
  rows.weighting.rho = autoregression(rows.size(), rows.num_terms(), rows.largest(target), rows.reader(target),
                                      rows.weighting.begins, rows.options.num_threads, rows.range.first_rows);
  if (!(formed(rows, independence) < white_enough)) return;
  rows.weighting.rho = 0.0;  // it is no such noise
  rows.count_by(formed(rows, independence));
}

/// Gives each of several records the weight that makes what all terms leave of it as large as in all together.
void weigh_records(EvidenceRows& rows, const IndependentRows& independence) {
  if (rows.records().size() < 2) return;
  const auto b = static_cast<double>(rows.num_terms());
  std::vector<double> variance;
  double pooled = 0.0;
  for (const SensorRegression& record : rows.regressions) {
    const auto n = static_cast<double>(record.joint.num_samples);
    const double norm = record.joint.R.rightCols(1).stableNorm(), left = noise_beside_all(record);
    if (!(left * left * n > rounding_power * norm * norm) || n <= b + 1.0) return;  // exact data have no noise
    variance.push_back(left * left);
    pooled += n / static_cast<double>(rows.size()) * variance.back();
  }
  for (const double own : variance) rows.weighting.weight.push_back(std::sqrt(pooled / own));
  rows.count_by(formed(rows, independence));
}

/// Whether what the filters of a preparation leave is in the rows; a table has none.
bool is_filtered(const EvidenceRows& rows) {
  return std::any_of(rows.records().begin(), rows.records().end(),
                     [&](const RecordRows& record) { return rows.recordings[record.recording].prepared != nullptr; });
}

/// Fills in what follows from the rows, their size and the model.
void form_data(EvidenceData& evidence, const EvidenceRows& rows) {
  const RangeData& range = rows.range;
  evidence.weighting = rows.weighting;
  const double fraction = evidence.size.fraction();
  if (rows.weighting.changes_rows()) {
    evidence.joint = rows.regression(0, {}, Eigen::RowVectorXd());
    evidence.noise_std = noise_beside_all(evidence.joint);
    if (!range.sensors) evidence.data = evidence.joint.joint;
  }
  if (range.sensors) evidence.data = without_sensors(evidence.joint, evidence.noise_std / std::sqrt(fraction));
  if (fraction < white_enough) evidence.data = thinned_to(std::move(evidence.data), fraction);
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
  std::vector<const Term*> terms;
  for (const Index j : range.terms) terms.push_back(&library.terms[static_cast<std::size_t>(j)]);
  const StateSpace state(terms, result.rows.train, recordings, options.target);
  const IndependentRows& independence = *range.independence;
  whiten(rows, independence);
  weigh_records(rows, independence);

  const ModelSizes sizes(rows, state, independence);
  const double complete = is_filtered(rows) ? filtered_power : rounding_power;
  Settled settled = select_size(
      sizes.problems(), [&](const Subset& model) { return sizes.of(model); }, complete);
  evidence.size = settled.size;
  evidence.path = std::move(settled.path);
  for (ModelOfSize& model : evidence.path)
    for (Index& term : model.terms) term = range.terms[static_cast<std::size_t>(term)];
  const bool several = rows.records().size() > 1,
             white = evidence.size.fraction() >= white_enough && !(settled.model.rss <= complete);
  if (white && rows.weighting.rho == 0.0 && !several) return evidence;
  if (!white) prefer_simpler(settled, sizes.problems(), degrees(library, range.terms));
  if (!white || several) evidence.terms = settled.model.terms;
  if (several) {
    RecordCoefficients found = record_coefficients(sizes.problems(), settled.model.terms, evidence.size);
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
