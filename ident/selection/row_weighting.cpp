#include "ident/selection/row_weighting.hpp"

#include <algorithm>
#include <utility>

#include "ident/selection/autoregression.hpp"

namespace ident {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

double RowWeighting::largest_weight() const {
  return weight.empty() ? 1.0 : *std::max_element(weight.begin(), weight.end());
}

VectorXd RowWeighting::weighted(VectorXd values) const {
  if (rho != 0.0) values = whitened_values(values, begins, rho);
  for (std::size_t i = 0; i < weight.size(); ++i)
    values.segment(records[i].first, records[i].last - records[i].first) *= weight[i];
  return values;
}

RowReader RowWeighting::weighted(RowReader read) const {
  if (rho != 0.0) read = whitened(std::move(read), begins, rho);
  if (weight.empty()) return read;
  return [this, unweighted = std::move(read)](Index first, Eigen::Ref<MatrixXd> block) {
    unweighted(first, block);
    for (std::size_t i = 0; i < records.size(); ++i) {
      const Index from = std::max(records[i].first, first), to = std::min(records[i].last, first + block.rows());
      if (from < to) block.middleRows(from - first, to - from) *= weight[i];
    }
  };
}

}  // namespace ident
