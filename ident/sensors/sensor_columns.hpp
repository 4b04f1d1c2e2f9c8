#pragma once
#include <Eigen/Core>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "dsp/prepare.hpp"
#include "ident/library/expression.hpp"
#include "ident/sensors/sensor_parameters.hpp"

namespace ident {

/// One column for each parameter (N x n_s, at the regression rate): the derivative of "equation - target" with respect
/// to it, through the column filter. To first order the target is Phi c + Psi eta + noise, eta the parameters' values.
/// Switches move with their signals. `poll` is called before each column and may throw to stop.
[[nodiscard]] Eigen::MatrixXd sensor_columns(const dsp::Prepared& prepared,
                                             const std::vector<SensorParameter>& parameters,
                                             const WeightedTerms& equation, const std::string& target,
                                             const std::function<void()>& poll = {});

}  // namespace ident
