#pragma once
#include "ident/bodies/bodies.hpp"
#include "ident/state_space/problem.hpp"

namespace ident {

/// Of one of the records that equations with a z were fitted to: `states` as its fit has them, states x samples; the
/// displacement is its first channel, with white noise of so much a sample.
[[nodiscard]] Loop loop_of(const BodiesModel& model, const Eigen::MatrixXd& states, const state_space::Record& record,
                           double sample_rate_hz, double noise_std);

}  // namespace ident
