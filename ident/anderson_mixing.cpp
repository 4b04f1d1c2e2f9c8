#include "ident/anderson_mixing.hpp"

#include <Eigen/QR>

namespace ident {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd with_column(const MatrixXd& columns, const VectorXd& latest) {
  MatrixXd result(latest.size(), columns.cols() + 1);
  result << columns, latest;
  return result;
}

}  // namespace

VectorXd AndersonMixing::next(const VectorXd& x, const VectorXd& g) {
  const VectorXd step = scale_.cwiseProduct(g - x);
  VectorXd result = g;
  if (last_step_.size() > 0) {
    steps_ = with_column(steps_, step - last_step_);
    gs_ = with_column(gs_, g - last_g_);
    result -= gs_ * Eigen::CompleteOrthogonalDecomposition<MatrixXd>(steps_).solve(step);
  }
  last_step_ = step;
  last_g_ = g;
  return result;
}

}  // namespace ident
