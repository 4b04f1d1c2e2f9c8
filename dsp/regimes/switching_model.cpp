#include "dsp/regimes/switching_model.hpp"

#include <array>
#include <cmath>
#include <utility>

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::Matrix2d;
using Eigen::RowVector2d;

Matrix2d transition(bool begins_anew, double switch_probability) {
  if (begins_anew) return Matrix2d::Constant(0.5);
  Matrix2d result;
  result << 1.0 - switch_probability, switch_probability, switch_probability, 1.0 - switch_probability;
  return result;
}

std::vector<int> viterbi(const Eigen::MatrixX2d& log_likelihoods, const std::vector<bool>& begins_anew,
                         double switch_probability) {
  const Index n = log_likelihoods.rows();
  std::vector<std::array<int, 2>> from(static_cast<std::size_t>(n));
  RowVector2d best = log_likelihoods.row(0);
  for (Index k = 1; k < n; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const Matrix2d steps = transition(begins_anew[at], switch_probability).array().log().matrix();
    RowVector2d next;
    for (int to = 0; to < 2; ++to) {
      const int other = 1 - to;
      from[at][static_cast<std::size_t>(to)] = best(other) + steps(other, to) > best(to) + steps(to, to) ? other : to;
      const int before = from[at][static_cast<std::size_t>(to)];
      next(to) = best(before) + steps(before, to) + log_likelihoods(k, to);
    }
    best = next;
  }
  std::vector<int> states(static_cast<std::size_t>(n));
  states.back() = best(1) > best(0) ? 1 : 0;
  for (std::size_t k = states.size(); --k > 0;) states[k - 1] = from[k][static_cast<std::size_t>(states[k])];
  return states;
}

}  // namespace

StateSequence most_probable_states(const Eigen::MatrixX2d& log_likelihoods, const std::vector<bool>& begins_anew,
                                   double switch_probability) {
  const Index n = log_likelihoods.rows();
  StateSequence result;
  result.probability = result.switch_probability = Eigen::VectorXd::Zero(n);
  if (n == 0) return result;
  // Up to a factor an observation, which cancels.
  Eigen::MatrixX2d likelihoods = (log_likelihoods.colwise() - log_likelihoods.rowwise().maxCoeff()).array().exp();
  Eigen::MatrixX2d forward(n, 2);
  forward.row(0) = likelihoods.row(0) / likelihoods.row(0).sum();
  for (Index k = 1; k < n; ++k) {
    const Matrix2d steps = transition(begins_anew[static_cast<std::size_t>(k)], switch_probability);
    forward.row(k) = (forward.row(k - 1) * steps).cwiseProduct(likelihoods.row(k));
    forward.row(k) /= forward.row(k).sum();
  }
  RowVector2d backward = RowVector2d::Ones();
  result.probability(n - 1) = forward(n - 1, 1);
  for (Index k = n - 1; k > 0; --k) {
    const bool anew = begins_anew[static_cast<std::size_t>(k)];
    const Matrix2d steps = transition(anew, switch_probability);
    const RowVector2d ahead = likelihoods.row(k).cwiseProduct(backward);
    const Matrix2d joint = forward.row(k - 1).transpose() * ahead;
    const Matrix2d pairs = joint.cwiseProduct(steps) / joint.cwiseProduct(steps).sum();
    result.switch_probability(k) = pairs(0, 1) + pairs(1, 0);
    if (!anew) result.expected_switches += result.switch_probability(k);
    backward = ahead * steps.transpose();
    backward /= backward.sum();
    const RowVector2d both = forward.row(k - 1).cwiseProduct(backward);
    result.probability(k - 1) = both(1) / both.sum();
  }
  result.states = viterbi(log_likelihoods, begins_anew, switch_probability);
  return result;
}

double probability_of(double times, double trials) {
  return (times + 0.5) / (trials + 1.0);
}

StateSequence fit_hmm(std::size_t num_observations, const std::function<StateSequence(double)>& pass) {
  constexpr int most_passes = 30;
  constexpr double settled = 1e-6;  // of a probability, far below what moves a state
  const auto trials = static_cast<double>(num_observations);
  StateSequence states = pass(probability_of(0.0, trials));
  for (int k = 1; k < most_passes && num_observations > 0; ++k) {
    StateSequence next = pass(probability_of(states.expected_switches, trials));
    const double change = (next.probability - states.probability).cwiseAbs().maxCoeff();
    states = std::move(next);
    if (change < settled) break;
  }
  return states;
}

}  // namespace dsp
