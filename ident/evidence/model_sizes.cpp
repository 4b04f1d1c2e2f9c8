#include "ident/evidence/model_sizes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dsp/filter/strongest_line.hpp"
#include "dsp/values/linear.hpp"
#include "ident/evidence/range_data.hpp"
#include "ident/selection/select_size.hpp"
#include "ident/validate/range_result.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double beyond_candidates = 0.02;  // of a unit-norm probe that lies beyond all candidates

/// At most a quarter of the period of the motion: rows closer than that share their misfit.
Index quarter_period(const EvidenceRows& rows) {
  const dsp::Motion& signals = *rows.recordings[rows.records().front().recording].signals;
  const dsp::Signal* x = signals.find("x");
  const double rate_hz = signals.sample_rate_hz;
  const double line_hz = dsp::strongest_line(x != nullptr ? x->values : rows.range.train, rate_hz).frequency_hz;
  return line_hz > 0.0 ? std::max<Index>(1, static_cast<Index>(rate_hz / line_hz / 4.0)) : rows.size();
}

}  // namespace

std::vector<ModelSizes::Probed> ModelSizes::probed(const EvidenceRows& rows, const StateSpace& state) {
  const Index q = state.num_probes(), b = rows.num_terms();
  std::vector<Probed> result;
  for (const RecordRows& record : rows.records()) {
    const RFactor factor =
        without_sensors(rows.regression(
                            q, [&](Index first, Eigen::Ref<MatrixXd> block) { state.read_probes(first, block); },
                            Eigen::RowVectorXd::Ones(q), &record),
                        rows.noise_std);
    // The candidates first: probes then count beyond them only.
    MatrixXd columns(factor.R.rows(), q + b + 1);
    columns << factor.R.middleCols(q, b), factor.R.leftCols(q), factor.R.rightCols(1);
    const MatrixXd R = triangle(columns);
    MatrixXd candidates(R.rows(), b + 1);
    candidates << R.leftCols(b), R.rightCols(1);
    Probed one{{triangle(candidates), b, record.last - record.first}};
    const double target_norm = one.candidates.R.col(b).stableNorm();
    const double unit = target_norm > 0.0 ? target_norm : 1.0;
    const VectorXd norms = R.middleCols(b, q).colwise().stableNorm();
    MatrixXd beyond = R.block(b, b, q, q);
    for (Index j = 0; j < q; ++j) beyond.col(j) *= norms(j) > 0.0 ? 1.0 / norms(j) : 0.0;
    const VectorXd target = R.col(b + q).segment(b, q) / unit;
    const auto [sizes, axes] = dsp::left_singular(beyond);
    one.num_probes = (sizes.array() > beyond_candidates).count();
    const double last = R(b + q, b + q) / unit;
    one.rss = last * last + target.squaredNorm() - (axes.leftCols(one.num_probes).transpose() * target).squaredNorm();
    if (rows.records().size() > 1) one.triangle = R;
    result.push_back(std::move(one));
  }
  return result;
}

RecordProblems ModelSizes::problems_of(const std::vector<Probed>& records, const EvidenceRows& rows) {
  std::vector<RFactor> factors;
  for (const Probed& record : records) factors.push_back(record.candidates);
  return RecordProblems(factors, rows.options.poll);
}

ModelSizes::ModelSizes(const EvidenceRows& rows, const StateSpace& state, const IndependentRows& independence)
    : ModelSizes(rows, state, independence, probed(rows, state)) {}

ModelSizes::ModelSizes(const EvidenceRows& rows, const StateSpace& state, const IndependentRows& independence,
                       const std::vector<Probed>& records)
    : rows_(rows), independence_(independence), problems_(problems_of(records, rows)) {
  for (const Probed& record : records) {
    most_probes_ = std::max(most_probes_, record.num_probes);
    if (records.size() > 1) triangles_.push_back(record.triangle);
  }
  has_inputs_ = state.has_inputs();
  rss_of_all_ = records.front().rss;
  all_leave_ = rows.residual(problems_, all_columns(rows.num_terms()));
  const VectorXd r = independence.autocorrelation(all_leave_);
  fraction_of_all_ = independence.fraction_by(r);
  Index apart = independence.first_lag_within_chance(r);
  if (apart > 1) apart = std::min(apart, quarter_period(rows));
  if (records.size() == 1 && fraction_of_all_ < white_enough) noise_fraction_ = least_fraction(r);
  pairs_ = state.revisits(apart, rows.range.train_samples, rows.range.first_rows);
}

EffectiveSize ModelSizes::of(const Subset& model) const {
  const bool is_all = std::ssize(model.terms) == rows_.num_terms();
  const VectorXd left = is_all ? all_leave_ : rows_.residual(problems_, model.terms);
  EffectiveSize size;
  size.num_rows = static_cast<double>(rows_.size());
  size.num_uncorrelated = (is_all ? fraction_of_all_ : independence_.fraction(left)) * size.num_rows;
  // Of one record, noise beside the band of the candidates takes nothing away. Coefficients of each of several answer
  // that record's misfit, of which f is the share in all that is left and not in that band: all correlation counts.
  size.num_noise = size.num_uncorrelated;
  if (rows_.records().size() == 1) size.num_noise = std::max(size.num_noise, noise_fraction_ * size.num_rows);
  size.num_states = static_cast<double>(rows_.num_terms() + most_probes_);
  size.has_inputs = has_inputs_;
  size.autoregression = rows_.weighting.rho;
  if (model.rss > rounding_power) {
    set_revisits(left, size);
    size.structural_fraction = std::fmax(size.state_dependent_fraction, explained_by_extra_functions(model, size));
  } else {
    size.num_uncorrelated = size.num_noise = size.num_rows;
  }
  return size;
}

/// Of the rows, for the candidate to which noise as coloured as what all leave (autocorrelation r) does most.
double ModelSizes::least_fraction(const VectorXd& r) const {
  double least = 1.0;
  for (const Index term : rows_.range.terms) {
    if (rows_.options.poll) rows_.options.poll();
    least = std::min(least, independence_.fraction_beside(r, rows_.column(term)));
  }
  return least;
}

/// What does not differ between rows in the same state is a function of it; not known where too few are.
void ModelSizes::set_revisits(const VectorXd& left, EffectiveSize& size) const {
  const auto count = static_cast<double>(pairs_.size());
  if (count < 10.0) return;
  size.state_dependent_fraction = 0.0;
  const double unit = left.cwiseAbs().maxCoeff();  // squares of smaller ones may vanish
  if (!(unit > 0.0)) return;
  double within = 0.0, within_square = 0.0, all = 0.0;
  for (const auto& [i, j] : pairs_) {
    const double one = left(i) / unit, other = left(j) / unit;
    const double difference = 0.5 * (one - other) * (one - other);
    within += difference;
    within_square += difference * difference;
    all += 0.5 * (one * one + other * other);
  }
  within /= count, all /= count;
  if (!(all > 0.0)) return;
  const double variance = std::max(0.0, within_square / count - within * within);
  // Half of the rows are in two pairs: 1.5 times the deviation of independent ones, to be safe.
  size.revisit_error = 2.0 * 1.5 * std::sqrt(variance / count) / all;
  size.state_dependent_fraction = std::clamp(1.0 - within / all - size.revisit_error, 0.0, 1.0);
}

/// Of several records: the model's terms have coefficients in each, what is beside them is one function of the state in
/// all, so that few coefficients answer what would take many if each record had its own.
ModelSizes::Rest ModelSizes::beside_common_functions(const Subset& model) const {
  const Index b = rows_.num_terms(), k = std::ssize(model.terms);
  std::vector<Index> others;
  for (Index j = 0; j < triangles_.front().cols() - 1; ++j)
    if (j >= b || !std::binary_search(model.terms.begin(), model.terms.end(), j)) others.push_back(j);
  const Index q = std::ssize(others), width = q + 1;
  MatrixXd stacked(width * std::ssize(triangles_), width);
  VectorXd squares = VectorXd::Zero(width);
  for (std::size_t r = 0; r < triangles_.size(); ++r) {
    MatrixXd columns(triangles_[r].rows(), k + width);
    columns << triangles_[r](Eigen::all, model.terms), triangles_[r](Eigen::all, others), triangles_[r].rightCols(1);
    squares += columns.rightCols(width).colwise().squaredNorm().transpose();
    stacked.middleRows(width * static_cast<Index>(r), width) = triangle(columns).bottomRightCorner(width, width);
  }
  for (Index j = 0; j < width; ++j) stacked.col(j) *= squares(j) > 0.0 ? 1.0 / std::sqrt(squares(j)) : 0.0;
  const MatrixXd R = triangle(stacked);
  const auto [sizes, axes] = dsp::left_singular(R.topLeftCorner(q, q));
  const Index dimensions = (sizes.array() > beyond_candidates).count();
  const VectorXd target = R.col(q).head(q);
  return {R(q, q) * R(q, q) + target.squaredNorm() - (axes.leftCols(dimensions).transpose() * target).squaredNorm(),
          static_cast<double>(dimensions)};
}

/// What the left-out candidates and the probes explain beyond chance.
double ModelSizes::explained_by_extra_functions(const Subset& model, const EffectiveSize& size) const {
  const auto terms = static_cast<double>(model.terms.size());
  const Rest rest = triangles_.empty() ? Rest{rss_of_all_, size.num_states - terms} : beside_common_functions(model);
  const double spare = size.num_uncorrelated - problems_.num_records() * terms;
  constexpr double fewest = 3.0;
  if (spare - rest.dimensions < fewest) return size.num_uncorrelated < white_enough * size.num_rows ? 1.0 : 0.0;
  const double noise = std::max(0.0, rest.rss) / (spare - rest.dimensions), left = model.rss / spare;
  return std::clamp(1.0 - noise / left - 2.0 * std::sqrt(2.0 * rest.dimensions) / spare, 0.0, 1.0);
}

}  // namespace ident
