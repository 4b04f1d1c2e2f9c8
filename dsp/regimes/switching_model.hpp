#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <vector>

namespace dsp {

/// What a sequence of observations says of two states, 0 and 1, between which a system switches at random.
struct StateSequence {
  std::vector<int> states;             ///< the most probable sequence (Viterbi)
  Eigen::VectorXd probability;         ///< of state 1 at each observation, given all of them (forward-backward)
  Eigen::VectorXd switch_probability;  ///< that the state at each observation is not that at the one before; 0 first
  double expected_switches = 0.0;
};

/// A hidden Markov model with these log-likelihoods (num_observations x 2), the same probability of a switch at each
/// step, and none but an even guess of the state where an observation `begins_anew`. [Rab89]
[[nodiscard]] StateSequence most_probable_states(const Eigen::MatrixX2d& log_likelihoods,
                                                 const std::vector<bool>& begins_anew, double switch_probability);

/// Probability of what was seen so often in so many trials, which may be expectations; of what was never seen, what one
/// trial more could show: the mean under Jeffreys' prior.
[[nodiscard]] double probability_of(double times, double trials);

/// Expectation maximisation of the probability of a switch, from that of what so many observations never showed, until
/// the probabilities of the states settle. `pass` gives the states under one, and may estimate more from them for its
/// next call.
[[nodiscard]] StateSequence fit_hmm(std::size_t num_observations,
                                    const std::function<StateSequence(double switch_probability)>& pass);

}  // namespace dsp
