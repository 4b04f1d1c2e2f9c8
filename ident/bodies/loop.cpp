#include "ident/bodies/loop.hpp"

#include "dsp/constants.hpp"
#include "ident/bodies/statement.hpp"
#include "ident/state_space/model.hpp"
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
  const std::vector<double> known(model.mean.begin(), model.mean.end());
  const state_space::Problem problem{
      .equations = equations_of(model.layout, model.terms, known), .channels = {}, .records = {}};
  const state_space::Model compiled(problem);
  state_space::Rates<1> rates(compiled);
  const Index inner = states.rows() - 1;
  for (Index k = 0; k < displacement.size(); ++k) {
    for (Index i = 0; i < inner; ++i) *rates.state(static_cast<int>(i)) = states(i, k);
    *rates.state(static_cast<int>(inner)) = 0.0;
    for (Index i = 0; i < record.inputs.cols(); ++i) *rates.input(static_cast<int>(i)) = record.inputs(k, i);
    *rates.input(static_cast<int>(record.inputs.cols())) = record.begin_s + static_cast<double>(k) / sample_rate_hz;
    rates.evaluate({});  // for the values of the switches, which say their sides
    for (int i = 0; i < compiled.num_switches(); ++i) *rates.sides(i) = *rates.switch_value(i) < 0.0 ? -1.0 : 1.0;
    rates.evaluate({});
    loop.measured(k) = *rates.rate(1) - acceleration(k);
  }
  return loop;
}

}  // namespace ident
