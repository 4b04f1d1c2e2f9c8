#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "ident/columns/columns.hpp"
#include "ident/fit.hpp"
#include "ident/ranges/ranges.hpp"
#include "ident/sensors/sensor_fit.hpp"
#include "ident/verdict.hpp"

namespace ident {

struct IdentifyOptions;
struct RangeData;

/// What the likelihood of the samples as they were recorded makes of a range: the second stage, which selects among the
/// candidates of a regression and gives coefficients and intervals (state_space).
struct Likelihood {
  std::string silent_because;       ///< not empty: it does not speak, and nothing else is filled in
  bool is_restless = false;         ///< its search did not come to an end, though not for what the terms lack
  std::vector<Eigen::Index> terms;  ///< of the library, ascending
  Eigen::VectorXd mean;             ///< of their coefficients
  Eigen::MatrixXd covariance;       ///< with parameters of the channels unknown
  Eigen::VectorXd gain;             ///< by how much -2 log likelihood falls with each term of the library; NaN: none
  struct Value {
    double mean = 0.0, std = 0.0;
  };
  Value zero, lag_s;                    ///< of x as it was recorded
  std::vector<SensorEstimate> sensors;  ///< all parameters of the channels
  double num_samples = 0.0;             ///< recorded, of all channels
  /// How far the zero of a channel that wanders goes in a second (state_space::Channel).
  struct Wander {
    std::string channel, unit;
    double std = 0.0;
  };
  std::vector<Wander> wanders;
  double cost = 0.0;                   ///< -2 log likelihood, with the price of terms and wanders
  double price = 0.0;                  ///< by which -2 log likelihood must fall for a term to be kept
  double gain_of_process_noise = 0.0;  ///< by how much that falls where the equation need not hold exactly
  double unexplained_std = 0.0;  ///< m/s^2: white, within the band of the columns, what the equation does not explain
  /// A recorded signal or a usual form that is no candidate, with which the equation is better by odds of 150; the
  /// best.
  std::optional<Explanation> missing;
  [[nodiscard]] bool speaks() const { return silent_because.empty(); }
  /// What the equation does not explain is there with odds of 20,000: no interval of it alone may be shown.
  [[nodiscard]] bool has_unexplained() const { return gain_of_process_noise > beyond_doubt; }
  static constexpr double beyond_doubt = 20.0;
};

/// Of the training rows of a range: `data` has its candidates. It speaks for one equation for a body whose relative
/// displacement, velocity or acceleration was recorded, with inputs that were recorded too or none, and where the fit
/// reached the channels' own noise.
/// Where something remains that the equation does not explain, or the fit did not reach the channels' noise, the zeros
/// of displacements and velocities may wander, if that makes the record likelier by the price of a term each. What a
/// term is worth is counted by the wider interval of
/// the regression, which knows how seldom a misfit comes back, and terms that are not worth their price then are left
/// out.
[[nodiscard]] Likelihood likelihood_of(const Range& range, const RangeRows& rows, const RangeData& data,
                                       const std::vector<Columns>& recordings, const IdentifyOptions& options);

/// The equation, its coefficients as they were found, through the recorded samples of further rows: where it begins is
/// found with them, as in a free run it is known.
struct RecordedRun {
  std::string channel;                 ///< recorded of x, the derivative of lowest order
  double nmse = 0.0, noise = 0.0;      ///< what it leaves of the channel, and the channel's noise: of its variance
  double gain_of_process_noise = 0.0;  ///< as of Likelihood
  double unexplained_std = 0.0;
};
/// Nothing where it cannot be told.
[[nodiscard]] std::optional<RecordedRun> run_through(const Likelihood& likelihood, const Range& range,
                                                     const std::vector<Row>& rows, const RangeData& data,
                                                     const std::vector<Columns>& recordings, int num_threads);

}  // namespace ident
