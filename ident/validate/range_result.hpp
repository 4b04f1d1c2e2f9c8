#pragma once
#include <Eigen/Core>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ident/columns/columns.hpp"
#include "ident/equation/model.hpp"
#include "ident/equation/verdict.hpp"
#include "ident/ranges/ranges.hpp"
#include "ident/records/range_factors.hpp"
#include "ident/regression/fit.hpp"
#include "ident/selection/effective_size.hpp"
#include "ident/sensors/sensor_fit.hpp"
#include "ident/validate/band_split.hpp"
#include "ident/validate/closed_orbit.hpp"
#include "ident/validate/crests.hpp"
#include "ident/validate/free_run.hpp"
#include "ident/validate/metrics.hpp"
#include "ident/validate/regressor_noise.hpp"
#include "ident/validate/unexplained.hpp"

namespace ident {

/// What the likelihood of the samples as they were recorded makes of a range: the second stage, which selects among the
/// candidates of a regression and gives coefficients and intervals (state_space).
struct Likelihood {
  std::string silent_because;       ///< not empty: it does not speak, and nothing else is filled in
  bool is_restless = false;         ///< its search did not come to an end, though not for what the terms lack
  std::vector<Eigen::Index> terms;  ///< of the library, ascending
  Eigen::VectorXd mean;             ///< of their coefficients
  /// With parameters of the channels unknown. Where something is unexplained, variances are as state_space::Fit::wider
  /// has them and, where rows of a regression do not count in full, no smaller than its own; where something is
  /// missing they hold what the coefficients are with it.
  Eigen::MatrixXd covariance;
  Eigen::VectorXd gain;  ///< by how much -2 log likelihood falls with each term of the library; NaN: none
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
  /// -2 log likelihood, with the price of terms and wanders; infinite where the channels stay far above their noise,
  /// NaN where the equation could not be run through them.
  double cost = 0.0;
  double price = 0.0;                  ///< by which -2 log likelihood must fall for a term to be kept
  double gain_of_process_noise = 0.0;  ///< by how much that falls where the equation need not hold exactly
  double unexplained_std = 0.0;  ///< m/s^2: white, within the band of the columns, what the equation does not explain
  /// A recorded signal or a usual form that is no candidate, with which the equation is better by odds of 150; the
  /// best.
  std::optional<Explanation> missing;
  /// By which coefficients change with it, that of S with t*S to what it is at the middle of the samples; empty
  /// without.
  Eigen::VectorXd moved;
  [[nodiscard]] bool speaks() const { return silent_because.empty(); }
  /// What the equation does not explain is there with odds of 20,000.
  [[nodiscard]] bool has_unexplained() const { return gain_of_process_noise > beyond_doubt; }
  static constexpr double beyond_doubt = 20.0;
};

/// The equation, its coefficients as they were found, through the recorded samples of further rows: where it begins is
/// found with them, as in a free run it is known.
struct RecordedRun {
  std::string channel;                 ///< recorded of x, the derivative of lowest order
  double nmse = 0.0, noise = 0.0;      ///< what it leaves of the channel, and the channel's noise: of its variance
  double gain_of_process_noise = 0.0;  ///< as of Likelihood
  double unexplained_std = 0.0;
};

/// A number that may be missing, with the reason.
struct Figure {
  double value = 0.0;
  std::string reason;  ///< not empty: there is no value
};

/// One method on one range, with all that is needed to judge it.
struct JudgedFit {
  Fit fit;  ///< terms are those of the library
  Model model;
  bool by_likelihood = false;  ///< of the recorded samples (RangeResult): terms, coefficients and intervals
  std::optional<RecordedRun> recorded_run;  ///< of the likelihood, where x was not recorded or its free run misses x
  std::vector<SensorEstimate> sensors;      ///< that took part; predictions and free run are with them
  double independent_fraction = 1.0;        ///< of the training rows, by the residual's autocorrelation
  EffectiveSize size;                       ///< of the rows as evidence; every row without Selection::evidence
  std::vector<ModelOfSize> path;            ///< that Selection::evidence compared; terms are those of the library
  std::vector<std::pair<std::string, std::string>> ties;  ///< candidates, or a candidate and a sensor's, that the rows
                                                          ///< do not tell apart; the kept one first
  Whiteness whiteness;                                    ///< of the training residual
  Figure train, test, train_centred, test_centred;        ///< NMSE
  BandFractions bands;       ///< fraction of the test targets inside their predictive bands
  std::string bands_reason;  ///< not empty: there are none
  FreeRun free_run;
  RegressorNoise noise;           ///< of the recorded channels, and what it does to the coefficients
  Explanations explanations;      ///< of the training residual
  std::optional<BandSplit> band;  ///< of the training rows; none: they cannot tell
  Judgement judgement;            ///< filled in by judge (judgement/judge.hpp), which compares ranges
  double solve_s = 0.0;
  Eigen::VectorXd predicted, predicted_std;  ///< training rows, then test rows
};

struct RangeResult {
  dsp::RangeSpec spec;              ///< with what was left out filled in
  int recording = 0;                ///< 1-based; 0: all
  dsp::RegimeSet regime;            ///< as in Range
  std::vector<std::string> terms;   ///< of the library
  std::vector<std::string> labels;  ///< of what fits number: these, then "TERM in RECORDING" for those that differ
  RangeRows rows;
  Eigen::VectorXd target;  ///< training rows, then test rows
  std::vector<DroppedTerm> dropped;
  std::vector<std::string> uncalibrated;  ///< channels of raw numbers, with their recordings
  double accumulate_s = 0.0;
  double power_balance = std::numeric_limits<double>::quiet_NaN();  ///< of corrected v and a; NaN: nothing to check
  Crests crests;                     ///< of x; none where something that may drive the motion was recorded
  std::optional<ClosedOrbit> orbit;  ///< that the training rows are, where it has fewer equations than candidates
  double along_motion = 0.0;         ///< of the training rows: share_along_motion
  std::optional<double> exchanged;   ///< of the training rows, where they are no closed orbit: exchanged_roles
  Likelihood likelihood;             ///< of the range, for the methods that weigh rows
  Model linear;  ///< least squares on the candidates that are signals themselves, or 1: what an equation must beat
  std::vector<JudgedFit> fits;
  RangeFactors factors;  ///< of the training rows; blocks where IdentifyOptions::most_blocks asks for them
};

struct IdentifyOptions {
  std::string target = "a", target_unit;
  std::vector<MethodOptions> methods = {FastRvmOptions{}, SlowRvmOptions{}, StlsqOptions{}};
  Stage stage = Stage::likelihood;
  int num_threads = 1;
  Eigen::Index most_blocks = 0;  ///< of RangeFactors; 0: none are formed
  bool free_run = true;          ///< false: the rows of a table are no time response
  Poll poll = {};                ///< called within fits and free runs, from any thread
  /// Called in order by the calling thread: before each of several ranges is fitted, and behind each, before it is
  /// judged; where they are fitted several at a time, when all are.
  std::function<void(const Range&)> before_range = {};
  std::function<void(const RangeResult&)> after_range = {};
};

}  // namespace ident
