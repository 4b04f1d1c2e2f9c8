#pragma once
#include <Eigen/Core>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dsp/prepare.hpp"
#include "dsp/prepare/filtered_stretch.hpp"
#include "ident/columns/block_means.hpp"
#include "ident/library/expression.hpp"
#include "ident/sensors/sensor_parameters.hpp"

namespace ident {

/// The accelerations of a recording as the regression has them: at its rate, through the column filter.
[[nodiscard]] dsp::Motion regression_accelerations(const dsp::Prepared& prepared);

struct SensorColumns {
  Eigen::MatrixXd values;  ///< N x shapes, at the regression rate
  BlockMeans means;        ///< ahead of the column filter, where that takes means away that the recording knows
};

/// One column for each shape: the derivative of "equation - target" with respect
/// to a value of it, through the column filter. To first order the target is Phi c + Psi eta + noise, eta the values of
/// parameters, each with the column of its shape times its course. Switches move with their signals. `accelerations`:
/// those of regression_accelerations. Beside the stretch that is wanted values may be anything. `poll` is called before
/// each shape and may throw to stop.
[[nodiscard]] SensorColumns sensor_columns(const dsp::Prepared& prepared, const dsp::Motion& accelerations,
                                           const std::vector<std::shared_ptr<const SensorShape>>& shapes,
                                           const WeightedTerms& equation, const std::string& target,
                                           const dsp::Stretch& wanted = {}, const std::function<void()>& poll = {});

}  // namespace ident
