#include "ident/bodies/loop.hpp"

#include "dsp/values/constants.hpp"
#include "ident/bodies/statement.hpp"
#include "ident/state_space/start.hpp"

namespace ident {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Loop loop_of(const BodiesModel& model, const MatrixXd& states, const state_space::Record& record, double sample_rate_hz,
             double noise_std) {
  const VectorXd displacement = record.channels.col(0);
  Loop loop{sample_rate_hz, states.row(0), states.bottomRows(1).transpose(),
            VectorXd::Constant(displacement.size(), dsp::nan)};
  if (!displacement.allFinite()) return loop;
  const double to_hz = state_space::cutoff_hz(displacement, sample_rate_hz, noise_std);
  const VectorXd acceleration = derived(displacement, sample_rate_hz, 2, to_hz);
  MatrixXd without_force = states.transpose();
  without_force.rightCols(1).setZero();
  loop.measured = rates_along(model, 1, without_force, record.inputs, sample_rate_hz, record.begin_s) - acceleration;
  return loop;
}

}  // namespace ident
