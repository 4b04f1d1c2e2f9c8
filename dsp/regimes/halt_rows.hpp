#pragma once
#include <Eigen/Core>

namespace dsp {

/// Logarithm of how much more probable a halt makes a sign of it than none does: normal with this standard deviation
/// about zero, or less, without one; anything up to `most` with one.
[[nodiscard]] double log_ratio_of_halt(double sign, double std, double most);

/// The probability that the motion halts at each of consecutive reversals, from the logarithm of how much more probable
/// a halt makes what is seen there. Halts come in rows: a switching model of two states, plain motion, in which none
/// halts, and rows, in which each does with one probability; that and the probability of a switch follow from the
/// record by expectation maximisation. A weak halt is carried by its neighbours; a lone one must be as clear as two
/// switches are rare.
[[nodiscard]] Eigen::VectorXd halt_probabilities(const Eigen::VectorXd& log_ratios);

}  // namespace dsp
