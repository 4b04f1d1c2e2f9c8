#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

// A statistical problem, stated. With s the states, c the coefficients, k one sample of a record:
//
//   s_k+1 = Phi(s_k; c) + w_k,   w_k ~ N(0, diag(q))      the equation over one sample, and what it does not explain
//   y_jk  = g_j q_j(t_k - tau_j) + b_j + e_jk,  e ~ N(0, r_j)    q_j: a state, its rate, or a state z beside a state x
//                                                                (z' = x' - c z behind an AC coupling, z' = x' and a
//                                                                random walk where it wanders); any may be missing;
//                                                                sqrt(r_j) times the record's own noise_factor
//
// c has a flat prior; gain g, lag tau, offset b and the corner of an AC coupling have normal ones.

namespace ident::state_space {

/// A count or a place that is not negative.
[[nodiscard]] constexpr std::size_t as_size(auto n) {
  return static_cast<std::size_t>(n);
}

/// A product that stands on the right of a state's equation, with a coefficient that is known or sought.
struct Term {
  std::string text;  ///< of states, inputs and t: "x^2*v", "sgn(v)"
  int state = 1;     ///< whose rate it adds to
  std::optional<double> known = {};
};

/// The term by which a state follows an input with a lag of first order: "(f - z)".
[[nodiscard]] inline std::string lag_term(const std::string& input, const std::string& state) {
  return "(" + input + " - " + state + ")";
}

/// rate of each state = sum of coefficient x term.
struct Equations {
  std::vector<std::string> states = {"x", "v"};
  std::vector<std::string> inputs = {};
  std::vector<Term> terms = {};  ///< kinematics too, with a known coefficient
};

/// x' = v, v' = these terms.
[[nodiscard]] Equations oscillator(const std::vector<std::string>& terms, std::vector<std::string> inputs = {});

/// What is known of a number beforehand.
struct Prior {
  double mean = 0.0, std = 0.0;  ///< std 0: it is the mean; infinite: nothing is known
};
inline constexpr double unknown = std::numeric_limits<double>::infinity();

/// A recorded channel: an output of the state.
struct Channel {
  std::string name = {};
  int state = 0;           ///< displacement: of x; velocity: of v
  bool rate = false;       ///< the rate of that state: of v, the acceleration
  double noise_std = 0.0;  ///< white, of a sample; 0: estimated, within a factor of e of what its spectrum ends in
  Prior gain = {1.0, 0.0}, offset = {}, lag_s = {};
  Prior corner_rad_s = {};  ///< of a first-order AC coupling; mean 0: there is none
  /// Its zero is a random walk. Of a displacement that is recorded as such, without an AC coupling.
  bool wanders = false;
  double wander_std = 0.0;  ///< its step from sample to sample; 0: estimated
  /// It shows a state of its own beside the one that it is of.
  [[nodiscard]] bool has_own_state() const { return wanders || corner_rad_s.mean > 0.0; }
};

/// Channels recorded together at equal intervals, and inputs, which are known without gaps.
struct Record {
  Eigen::MatrixXd channels;                ///< samples x channels; NaN: missing
  Eigen::MatrixXd inputs;                  ///< samples x inputs
  std::vector<double> noise_factors = {};  ///< of each channel's noise in this record; empty, or fewer: 1
  double begin_s = 0.0;                    ///< t of the first sample
  [[nodiscard]] double noise_factor(std::size_t channel) const {
    return channel < noise_factors.size() ? noise_factors[channel] : 1.0;
  }
};

struct Problem {
  Equations equations;
  std::vector<Channel> channels;
  std::vector<Record> records;
  std::vector<double> input_noise_std = {};  ///< of a sample, white; empty: inputs are exact
  double sample_rate_hz = 0.0;
  int steps = 1;                                                ///< of the integration a sample, to begin with
  double flat_to_hz = std::numeric_limits<double>::infinity();  ///< of the channels: above it a filter took their noise
};

/// Throws std::invalid_argument that says what does not fit: sizes, indices, a rate that is not positive, a record of
/// fewer than 8 samples, an input or a channel that is infinite, a channel without any sample.
void require_sound(const Problem& problem);

}  // namespace ident::state_space
