#include "ident/selection/evidence_rows.hpp"

#include <algorithm>
#include <utility>

#include "ident/identify.hpp"
#include "ident/range_data.hpp"
#include "ident/rows_of_terms.hpp"
#include "ident/selection/autoregression.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Least-squares coefficients of these candidates.
VectorXd coefficients(const UnitProblem& problem, const std::vector<Index>& positions) {
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
      target(its_range.train),
      weighting{run_begins(its_range.train_samples, its_range.first_rows), {}} {
  for (std::size_t i = 0; i < range.first_rows.size(); ++i) {
    const Index first = range.first_rows[i];
    const Index last = i + 1 < range.first_rows.size() ? range.first_rows[i + 1] : size();
    weighting.records.push_back({first, last, result.rows.train[static_cast<std::size_t>(first)].recording});
  }
}

Index EvidenceRows::num_terms() const {
  return std::ssize(range.terms);
}

RowReader EvidenceRows::reader(const VectorXd& its_target) const {
  return [this, &its_target, columns = RowsOfTerms(result.rows.train, recordings, range.terms)](
             Index first, Eigen::Ref<MatrixXd> block) {
    if (options.poll) options.poll();
    columns.read(first, block.leftCols(num_terms()));
    block.rightCols(1) = its_target.segment(first, block.rows());
  };
}

Eigen::RowVectorXd EvidenceRows::largest(const VectorXd& its_target) const {
  Eigen::RowVectorXd values(num_terms() + 1);
  values << range.scale(range.terms).transpose(), its_target.cwiseAbs().maxCoeff();
  return values;
}

RFactor EvidenceRows::factor(Index num_front, const Eigen::RowVectorXd& largest_front, const RowReader& read_front,
                             const VectorXd& its_target, const RecordRows* record) const {
  RowReader read = [&, num_front, own = reader(its_target)](Index first, Eigen::Ref<MatrixXd> block) {
    own(first, block.rightCols(num_terms() + 1));
    if (num_front > 0) read_front(first, block.leftCols(num_front));
  };
  Eigen::RowVectorXd greatest(num_front + num_terms() + 1);
  greatest << largest_front, largest(its_target);
  greatest *= weighting.largest_weight();
  read = weighting.weighted(std::move(read));
  const Index first_row = record != nullptr ? record->first : 0;
  const Index count = record != nullptr ? record->last - first_row : size();
  const RowReader from_first = [&](Index first, Eigen::Ref<MatrixXd> block) { read(first_row + first, block); };
  return r_factor(count, num_front + num_terms(), greatest, first_row == 0 ? read : from_first, options.num_threads);
}

std::vector<RFactor> EvidenceRows::factors() const {
  std::vector<RFactor> result_of_each;
  for (const RecordRows& record : records())
    result_of_each.push_back(factor(0, Eigen::RowVectorXd(), {}, target, &record));
  return result_of_each;
}

VectorXd EvidenceRows::column(Index term) const {
  VectorXd values(size());
  RowsOfTerms(result.rows.train, recordings, {term}).for_each_block([&](Index first, const MatrixXd& phi) {
    values.segment(first, phi.rows()) = phi.col(0);
  });
  return weighting.weighted(std::move(values));
}

VectorXd EvidenceRows::residual(const RecordProblems& problems, const std::vector<Index>& positions) const {
  std::vector<Index> terms;
  for (const Index position : positions) terms.push_back(range.terms[static_cast<std::size_t>(position)]);
  MatrixXd mean(std::ssize(positions), std::ssize(records()));  // of each record
  for (std::size_t i = 0; i < records().size(); ++i)
    mean.col(static_cast<Index>(i)) = coefficients(problems.records[i], positions);
  VectorXd left = target;
  std::size_t record = 0;
  RowsOfTerms(result.rows.train, recordings, terms).for_each_block([&](Index first, const MatrixXd& phi) {
    for (Index from = first; from < first + phi.rows();) {
      while (records()[record].last <= from) ++record;
      const Index to = std::min(records()[record].last, first + phi.rows());
      left.segment(from, to - from) -= phi.middleRows(from - first, to - from) * mean.col(static_cast<Index>(record));
      from = to;
    }
  });
  return weighting.weighted(std::move(left));
}

}  // namespace ident
