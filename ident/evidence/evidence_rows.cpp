#include "ident/evidence/evidence_rows.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ident/evidence/range_data.hpp"
#include "ident/ranges/rows_of_terms.hpp"
#include "ident/selection/autoregression.hpp"
#include "ident/validate/range_result.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Least-squares coefficients of these candidates.
VectorXd least_squares(const UnitProblem& problem, const std::vector<Index>& positions) {
  const VectorXd lambda = VectorXd::Constant(std::ssize(positions), flat_lambda);
  const VectorXd mean = posterior(problem, positions, lambda).mean.col(0);
  // A column that is zero in a record has no coefficient there.
  const VectorXd norm = problem.column_norm(positions).unaryExpr([](double one) { return one > 0.0 ? one : 1.0; });
  return (mean.array() * problem.target_norm(0) / norm.array()).matrix();
}

}  // namespace

EvidenceRows::EvidenceRows(const RangeData& its_range, const RangeResult& its_result,
                           const std::vector<Columns>& its_recordings, const IdentifyOptions& its_options)
    : range(its_range),
      result(its_result),
      recordings(its_recordings),
      options(its_options),
      weighting{run_begins(its_range.train_samples, its_range.first_rows), {}} {
  for (std::size_t i = 0; i < range.first_rows.size(); ++i) {
    const Index first = range.first_rows[i];
    const Index last = i + 1 < range.first_rows.size() ? range.first_rows[i + 1] : size();
    weighting.records.push_back({first, last, result.rows.train[static_cast<std::size_t>(first)].recording});
  }
}

Index EvidenceRows::size() const {
  return range.train.size();
}

Index EvidenceRows::num_terms() const {
  return std::ssize(range.terms);
}

RowReader EvidenceRows::reader(const VectorXd& target) const {
  return [this, &target, columns = RowsOfTerms(result.rows.train, recordings, range.terms)](
             Index first, Eigen::Ref<MatrixXd> block) {
    if (options.poll) options.poll();
    columns.read(first, block.leftCols(num_terms()));
    block.rightCols(1) = target.segment(first, block.rows());
  };
}

Eigen::RowVectorXd EvidenceRows::largest(const VectorXd& target) const {
  Eigen::RowVectorXd values(num_terms() + 1);
  values << range.scale(range.terms).transpose(), target.cwiseAbs().maxCoeff();
  return values;
}

SensorRegression EvidenceRows::regression(Index num_front, const RowReader& read_front,
                                          const Eigen::RowVectorXd& largest_front, const RecordRows* record) const {
  const std::vector<Row>& train = result.rows.train;
  const Index num_sensors = range.joint.num_sensors(), before = num_sensors + num_front;
  RowReader read = [&, num_sensors, before, own = reader(range.train)](Index first, Eigen::Ref<MatrixXd> block) {
    own(first, block.rightCols(num_terms() + 1));
    if (num_sensors > 0) range.sensors->read(train, first, block.leftCols(num_sensors));
    if (before > num_sensors) read_front(first, block.middleCols(num_sensors, before - num_sensors));
  };
  Eigen::RowVectorXd greatest(before + num_terms() + 1);
  greatest << (num_sensors > 0 ? range.sensors->largest(train) : Eigen::RowVectorXd()), largest_front,
      largest(range.train);
  greatest *= weighting.largest_weight();
  read = weighting.weighted(std::move(read));
  const Index first_row = record != nullptr ? record->first : 0;
  const Index count = record != nullptr ? record->last - first_row : size();
  const RowReader from_first = [&](Index first, Eigen::Ref<MatrixXd> block) { read(first_row + first, block); };
  SensorRegression formed{
      r_factor(count, before + num_terms(), greatest, first_row == 0 ? read : from_first, options.num_threads),
      range.joint.prior_std, range.joint.sources};
  add_means(formed, num_front, record);
  return formed;
}

void EvidenceRows::add_means(SensorRegression& formed, Index num_front, const RecordRows* record) const {
  for (std::size_t i = 0; i < range.means.recordings.size(); ++i)
    for (std::size_t k = 0; k < records().size(); ++k) {
      const RecordRows& one = records()[k];
      if (one.recording != range.means.recordings[i] || (record != nullptr && record->first != one.first)) continue;
      const double weight = weighting.weight.empty() ? 1.0 : weighting.weight[k];
      const Eigen::RowVectorXd mean = range.means.rows.row(static_cast<Index>(i));
      Eigen::RowVectorXd row(num_front + mean.size());
      row << mean.head(range.joint.num_sensors()), Eigen::RowVectorXd::Zero(num_front), mean.tail(num_terms() + 1);
      // The mean of an autoregression is that of its innovations over 1 - rho.
      add_rows(formed, weight * (1.0 - weighting.rho) * row);
    }
}

void EvidenceRows::form() {
  regressions.clear();
  if (!range.sensors && records().size() == 1 && !weighting.changes_rows()) {
    regressions.push_back({range.data, {}, {}});  // the rows as they are
    return;
  }
  for (const RecordRows& record : records()) regressions.push_back(regression(0, {}, Eigen::RowVectorXd(), &record));
}

void EvidenceRows::count_by(double fraction) {
  double squares = 0.0;
  for (const SensorRegression& record : regressions)
    squares += static_cast<double>(record.joint.num_samples) * std::pow(noise_beside_all(record), 2);
  noise_std = std::sqrt(squares / static_cast<double>(size()) / fraction);
}

RecordProblems EvidenceRows::problems() const {
  std::vector<RFactor> factors;
  for (const SensorRegression& record : regressions) factors.push_back(without_sensors(record, noise_std));
  return RecordProblems(factors, options.poll);
}

VectorXd EvidenceRows::column(Index term) const {
  VectorXd values(size());
  RowsOfTerms(result.rows.train, recordings, {term}).for_each_block([&](Index first, const MatrixXd& phi) {
    values.segment(first, phi.rows()) = phi.col(0);
  });
  return weighting.weighted(std::move(values));
}

std::vector<VectorXd> EvidenceRows::coefficients(const RecordProblems& problems,
                                                 const std::vector<Index>& positions) const {
  std::vector<VectorXd> of_each;
  for (const UnitProblem& record : problems.records) of_each.push_back(least_squares(record, positions));
  return of_each;
}

VectorXd EvidenceRows::target_beside_sensors(const RecordProblems& problems,
                                             const std::vector<Index>& positions) const {
  VectorXd target = range.train;
  if (!range.sensors) return target;
  const std::vector<VectorXd> mean = coefficients(problems, positions);
  for (std::size_t i = 0; i < records().size(); ++i) {
    const RecordRows& record = records()[i];
    const std::vector<Row> rows(result.rows.train.begin() + record.first, result.rows.train.begin() + record.last);
    target.segment(record.first, record.last - record.first) -=
        range.sensors->effect(rows, sensor_mean(regressions[i], positions, mean[i], noise_std));
  }
  return target;
}

VectorXd EvidenceRows::residual(const RecordProblems& problems, const std::vector<Index>& positions) const {
  std::vector<Index> terms;
  for (const Index position : positions) terms.push_back(range.terms[static_cast<std::size_t>(position)]);
  const std::vector<VectorXd> mean = coefficients(problems, positions);
  VectorXd left = target_beside_sensors(problems, positions);
  std::size_t record = 0;
  RowsOfTerms(result.rows.train, recordings, terms).for_each_block([&](Index first, const MatrixXd& phi) {
    for (Index from = first; from < first + phi.rows();) {
      while (records()[record].last <= from) ++record;
      const Index to = std::min(records()[record].last, first + phi.rows());
      left.segment(from, to - from) -= phi.middleRows(from - first, to - from) * mean[record];
      from = to;
    }
  });
  return weighting.weighted(std::move(left));
}

}  // namespace ident
