#pragma once
#include <vector>

#include "ident/state_space/linear.hpp"

namespace ident::state_space {

/// The states and their kinematics: state i is a position whose rate is state speed[i]; -1: it is not.
[[nodiscard]] std::vector<int> speeds_of(const Equations& equations);

/// A state that is neither a position nor a speed and acts on a speed by a known coefficient: it is of the size of that
/// speed's rate.
struct InnerForce {
  int state = 0, speed = 0;
  double coefficient = 1.0;
};
[[nodiscard]] std::vector<InnerForce> inner_forces(const Equations& equations);

/// With straight lines over what is missing (NaN); the nearest value at the ends.
[[nodiscard]] Eigen::VectorXd filled(Eigen::VectorXd values);

/// White noise of a sample of each channel as the upper end of its own spectrum has it, 0.25 to 0.45 of the sample
/// rate: its standard deviation, where noise_std is not given. Never below 1e-6 of the channel's own.
[[nodiscard]] std::vector<double> noise_floors(const Problem& problem);
/// Relative variance of the square of such a floor, times the samples it is of: a median over a fifth of the ordinates,
/// as uncertain under Hann's window as one of half as many.
inline constexpr double variance_of_floor = 1.44 * 1.44 * 1.9 / 0.2;

/// Gives records their noise_factors where a channel's noise differs between recordings (`recording_of`: of each
/// record) by more than four standard deviations of what their spectra tell of it.
void tell_noise_apart(Problem& problem, const std::vector<std::size_t>& recording_of);

/// Where the spectrum of a signal with such white noise a sample falls to thrice that noise, and 1.3 times as high:
/// above is no motion. At most 0.45 of the rate.
[[nodiscard]] double cutoff_hz(const Eigen::VectorXd& signal, double rate_hz, double noise_std);

/// A signal without what it has above the band in which it is more than its own noise: an input is known no better, and
/// noise in it would make its coefficient smaller. As it is where that noise is a tenth of its power or more: what is
/// as large at the upper end as below is a random input, not noise.
struct Input {
  Eigen::VectorXd signal;
  double noise_std = 0.0;  ///< white, of a sample as it was
  double to_hz;            ///< above, nothing of it is left; half the rate where it is as it was
};
[[nodiscard]] Input without_noise(const Eigen::VectorXd& signal, double rate_hz);

/// A problem in which every position has an origin: where neither it nor anything that fixes it is recorded, as of an
/// acceleration alone, x + x0 obeys an equation with more terms as well. A channel of zeros with three times its
/// standard deviation as noise, which no real motion contradicts, is added for each such position.
[[nodiscard]] Problem with_origins(Problem problem, const std::vector<double>& scales);

/// States from the channels alone: each position, speed and its rate from the recorded derivative of lowest order,
/// low-passed where its spectrum falls to its noise, differentiated or integrated; other states zero. A coupled state
/// begins as what it is coupled to.
struct Start {
  std::vector<std::vector<double>> states;  ///< of each record, as Point has them
  std::vector<double> scales;               ///< standard deviation of each state; of those not known 1
};
[[nodiscard]] Start start_of(const Linearisation& problem);

}  // namespace ident::state_space
