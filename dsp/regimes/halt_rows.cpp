#include "dsp/regimes/halt_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "dsp/regimes/switching_model.hpp"

namespace dsp {

using Eigen::Index;
using Eigen::VectorXd;

double log_ratio_of_halt(double sign, double std, double most) {
  const double certain = std::log(std::numeric_limits<double>::max());  // without noise: odds beyond any prior's
  if (!(std > 0.0)) return sign > 0.0 ? certain : -certain;
  const double stds = std::max(0.0, sign / std);
  return 0.5 * stds * stds + std::min(0.0, std::log(std::sqrt(2.0 * std::numbers::pi) * std / most));
}

VectorXd halt_probabilities(const VectorXd& log_ratios) {
  const Index n = log_ratios.size();
  const std::vector<bool> begins_anew(static_cast<std::size_t>(n), false);
  double halts = 0.5;  // probability of a halt at a reversal in a row
  VectorXd result = VectorXd::Zero(n);
  (void)fit_hmm(static_cast<std::size_t>(n), [&](double switch_probability) {
    const VectorXd odds = log_ratios.array() + std::log(halts / (1.0 - halts));
    Eigen::MatrixX2d log_likelihoods = Eigen::MatrixX2d::Zero(n, 2);
    for (Index k = 0; k < n; ++k)  // 1 - halts + halts ratio, whose logarithm may be far from 0
      log_likelihoods(k, 1) = std::log(1.0 - halts) + std::max(odds(k), 0.0) + std::log1p(std::exp(-std::abs(odds(k))));
    StateSequence states = most_probable_states(log_likelihoods, begins_anew, switch_probability);
    result = states.probability.array() / (1.0 + (-odds.array()).exp());
    halts = probability_of(result.sum(), states.probability.sum());
    return states;
  });
  return result;
}

}  // namespace dsp
