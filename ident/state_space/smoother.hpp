#pragma once
#include <vector>

#include "ident/state_space/linear.hpp"
#include "ident/state_space/triangle.hpp"

namespace ident::state_space {

/// Standard deviations.
struct Noise {
  std::vector<double> process;  ///< of what a step leaves open in each state
  std::vector<double> channel;  ///< of a sample of each channel
};

/// The rows that a record's elimination leaves on each sample, for the way back.
struct Eliminated {
  int num_states = 0, num_parameters = 0;
  std::vector<std::vector<double>> rows;  ///< of each record: samples x states x (states, next states, parameters, 1)
};

/// A linear problem solved for all states, with the parameters left in a triangle.
struct Smoothed {
  double cost = 0.0;             ///< weighted squares, priors with them, at the point
  double log_determinant = 0.0;  ///< log |H_ss|, of the states' information
  double log_noise = 0.0;        ///< sum of the logarithms of the variances of all rows
  Triangle parameters;           ///< least squares for a step of the parameters, states gone: its left_over is the
                                 ///< least cost of the linear problem
  Eliminated eliminated;         ///< empty unless asked for
  /// -2 log likelihood up to a constant: states integrated out, parameters at their best (Laplace).
  [[nodiscard]] double J() const { return parameters.left_over() + log_determinant + log_noise; }
};

/// Square-root information smoother: the rows of outputs and steps, each over its standard deviation, brought to a
/// triangle by Givens rotations and Householder reflections, sample after sample. No covariance and no normal equation
/// is formed: weights may span eight decades. The transition need not be invertible. [Bierman 1977, ch. V, X]
/// Records on up to num_threads threads, the same bits on any.
[[nodiscard]] Smoothed smooth(const Linear& linear, const Noise& noise, bool keep_rows, int num_threads);

/// The step of the states that belongs to a step of the parameters, of each record; without `from_residuals` the part
/// that answers to the parameters alone, so that of a unit step it is ds/dtheta of the smoothed states.
[[nodiscard]] std::vector<std::vector<double>> states_step(const Eliminated& eliminated,
                                                           const std::vector<double>& parameters, bool from_residuals,
                                                           int num_threads);

/// Normalised innovations of every channel at fixed parameters, of each record samples x channels: what each sample is
/// off from what all before it foretell, over its standard deviation. NaN where it is missing or nothing foretells it.
[[nodiscard]] std::vector<std::vector<double>> innovations(const Linear& linear, const Noise& noise);

/// Slope of the log likelihood in every parameter, of each of so many stretches of the records one behind the other,
/// stretches x parameters: the sum of innovation times its slope, which are uncorrelated where the problem is right.
[[nodiscard]] std::vector<double> slopes_of_stretches(const Linear& linear, const Noise& noise, int num_stretches);

}  // namespace ident::state_space
