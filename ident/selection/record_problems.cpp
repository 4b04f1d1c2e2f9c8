#include "ident/selection/record_problems.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace ident {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

RecordProblems::RecordProblems(UnitProblem one) : weight(VectorXd::Ones(1)) {
  records.push_back(std::move(one));
}

RecordProblems::RecordProblems(const std::vector<RFactor>& factors, const Poll& poll) {
  if (factors.empty()) throw std::invalid_argument("RecordProblems: there is no record");
  VectorXd norm(std::ssize(factors));
  for (std::size_t r = 0; r < factors.size(); ++r) {
    if (factors[r].num_terms != factors.front().num_terms || factors[r].num_targets() != 1)
      throw std::invalid_argument("RecordProblems: records of one library and one target are needed");
    records.push_back(unit_problem(factors[r], poll));
    norm(static_cast<Index>(r)) = records.back().target_norm(0);
  }
  const double largest = norm.maxCoeff();  // squares of the norms may overflow
  weight = VectorXd::Ones(norm.size()) / static_cast<double>(norm.size());
  if (largest > 0.0) weight = (norm / largest).cwiseAbs2() / (norm / largest).squaredNorm();
}

Index RecordProblems::num_samples() const {
  Index sum = 0;
  for (const UnitProblem& record : records) sum += record.num_samples;
  return sum;
}

double shared_rss(const RecordProblems& problems, const std::vector<Index>& common,
                  const std::vector<Index>& differing) {
  const Index num_common = std::ssize(common), num_own = std::ssize(differing), width = num_common + 1;
  VectorXd largest = VectorXd::Zero(num_common);  // norm of a common column
  for (const UnitProblem& record : problems.records)
    for (Index j = 0; j < num_common; ++j)
      largest(j) = std::max(largest(j), record.column_norm(common[static_cast<std::size_t>(j)]));
  MatrixXd stacked = MatrixXd::Zero(width * std::ssize(problems.records), width);
  for (std::size_t r = 0; r < problems.records.size(); ++r) {
    const UnitProblem& record = problems.records[r];
    MatrixXd rows(record.A.rows(), num_own + width);
    for (Index j = 0; j < num_own; ++j) rows.col(j) = record.A.col(differing[static_cast<std::size_t>(j)]);
    // The common columns in one unit and the target in its own, both over the root of the squares of all targets.
    const double of_target = std::sqrt(problems.weight(static_cast<Index>(r)));
    for (Index j = 0; j < num_common; ++j) {
      const Index term = common[static_cast<std::size_t>(j)];
      rows.col(num_own + j) = record.A.col(term) * (largest(j) > 0.0 ? record.column_norm(term) / largest(j) : 0.0);
    }
    rows.rightCols(1) = record.Y.col(0) * of_target;
    const MatrixXd R = rows.cols() > 1 ? triangle(rows) : MatrixXd::Constant(1, 1, rows.norm());
    stacked.middleRows(width * static_cast<Index>(r), width) = R.bottomRightCorner(width, width);
  }
  if (width == 1) return stacked.squaredNorm();
  const MatrixXd R = triangle(stacked);
  return R(num_common, num_common) * R(num_common, num_common);
}

}  // namespace ident
