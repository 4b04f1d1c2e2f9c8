#pragma once
#include <Eigen/Core>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ident/columns/columns.hpp"
#include "ident/fit.hpp"
#include "ident/likelihood.hpp"
#include "ident/model.hpp"
#include "ident/ranges/ranges.hpp"
#include "ident/records/range_factors.hpp"
#include "ident/records/record.hpp"
#include "ident/selection/effective_size.hpp"
#include "ident/validate/band_split.hpp"
#include "ident/validate/closed_orbit.hpp"
#include "ident/validate/crests.hpp"
#include "ident/validate/free_run.hpp"
#include "ident/validate/metrics.hpp"
#include "ident/validate/regressor_noise.hpp"
#include "ident/validate/unexplained.hpp"
#include "ident/verdict.hpp"

namespace ident {

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
  Judgement judgement;            ///< filled in by judge (validate/judge.hpp), which compares ranges
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

/// Fits each method on the training rows of a range and judges all but what other ranges say of it (judgement).
/// `recordings` are the columns of each recording, of one library; their switches are placed where the first method's
/// equation of this range has them (place_switches), and stay so. Throws dsp::Fault as range_rows does, and (numerics,
/// "library.nothing_left") where no candidate is left.
[[nodiscard]] RangeResult identify(const Range& range, std::vector<Columns>& recordings,
                                   const CandidateLibrary& library, const IdentifyOptions& options);

/// Each range, on a copy of its columns, judged beside the others; several at a time where there are threads.
[[nodiscard]] std::vector<RangeResult> identify(const std::vector<Range>& ranges,
                                                const std::vector<Columns>& recordings, const CandidateLibrary& library,
                                                const IdentifyOptions& options);

/// The usual case in one call: the ranges of a record (its own, else default_ranges), about the zero of x that a
/// difference of two displacements needs, by the library given; judged. Throws as record_library, record_columns
/// and identify do; target_unit is the record's.
[[nodiscard]] std::vector<RangeResult> identify(Record record, const LibraryOptions& library,
                                                IdentifyOptions options = {});

}  // namespace ident
