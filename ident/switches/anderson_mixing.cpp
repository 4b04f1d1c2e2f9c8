#include "ident/switches/anderson_mixing.hpp"

#include <algorithm>
#include <utility>

#include "dsp/values/linear.hpp"

namespace ident {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd AndersonMixing::next(const VectorXd& x, const VectorXd& g) {
  const VectorXd step = scale_.cwiseProduct(g - x);
  VectorXd result = g;
  if (last_step_.size() > 0) {
    // As many as x has dimensions: with more the oldest and largest would count as much as the latest.
    const Index kept = std::min<Index>(steps_.cols(), std::max<Index>(0, (g.array() != 0.0).count() - 1));
    MatrixXd steps(g.size(), kept + 1), gs(g.size(), kept + 1);
    if (kept > 0) {  // else there is no matrix yet
      steps.leftCols(kept) = steps_.rightCols(kept);
      gs.leftCols(kept) = gs_.rightCols(kept);
    }
    steps.rightCols(1) = step - last_step_;
    gs.rightCols(1) = g - last_g_;
    result -= gs * dsp::least_squares(steps, step);
    steps_ = std::move(steps);
    gs_ = std::move(gs);
  }
  last_step_ = step;
  last_g_ = g;
  return result;
}

}  // namespace ident
