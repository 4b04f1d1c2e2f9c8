#pragma once
#include <Eigen/Core>
#include <vector>

#include "ident/columns/columns.hpp"
#include "ident/equation/model.hpp"
#include "ident/ranges/ranges.hpp"
#include "ident/regression/fit.hpp"
#include "ident/regression/r_factor.hpp"

// Least squares takes its regressors as they are. Noise in them biases the coefficients, however many rows there are:
// with normal matrix G = Phi'Phi, of which N is noise, by G^-1 (n - N beta), n the part that it shares with the target.

namespace ident {

/// Power of a residual, as a fraction of the target's, that sensors themselves may make: few are linear to 0.3 %.
inline constexpr double sensor_linearity = 1e-5;

/// What white noise of the recorded channels does to an equation.
struct RegressorNoise {
  Eigen::VectorXd bias;       ///< of each coefficient, by noise that is known
  double x_std = 0.0;         ///< of the noise of x within the band of the columns
  double v_as_x_std = 0.0;    ///< of that of v, times the ratio of the standard deviations of x and v
  double residual_std = 0.0;  ///< of what it leaves in the residual, at most: the target's noise and that of the terms
  double known_std = 0.0;     ///< of that, by noise that is known
  double residual_power = 0.0;  ///< mean square of the residual
  double band_hz = 0.0;         ///< where the band of the columns ends
  double needed_hz = 0.0;       ///< up to here the target is more than noise
  double motion_power = 0.0;    ///< of residual_power, what lies below needed_hz
  double motion_std = 0.0;      ///< of residual_std, what lies there
};

/// Of a model fitted to rows of these recordings, which leaves this residual there; `kept`: R factor of its terms. Rows
/// of a table have no noise that is known: everything is zero.
[[nodiscard]] RegressorNoise regressor_noise(const Model& model, const RFactor& kept, const std::vector<Row>& rows,
                                             const std::vector<Columns>& recordings,
                                             const Eigen::Ref<const Eigen::VectorXd>& residual, const Poll& poll = {});

/// Mean square of what noise of the channels of one recording leaves in the residual of a model, at most, below each of
/// these frequencies in Hz.
[[nodiscard]] Eigen::VectorXd noise_below(const Model& model, std::size_t recording, const std::vector<Row>& rows,
                                          const std::vector<Columns>& recordings,
                                          const Eigen::Ref<const Eigen::VectorXd>& to_hz);

}  // namespace ident
