#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "ident/equation/model.hpp"
#include "ident/records/record.hpp"
#include "ident/validate/range_result.hpp"

namespace ident {

/// A coefficient of an equation beside the one that another recording gives it.
struct CarryOver {
  std::string term;
  double identified = 0.0, identified_std = 0.0;
  double here = 0.0, here_std = 0.0;  ///< NaN: the term does not earn its place here
  std::optional<bool> carries = {};   ///< they agree within three total standard deviations; none: not known
};

/// What an identified equation makes of a recording that it was not fitted to.
struct RecordPrediction {
  std::string recording, unit;           ///< of x
  std::vector<dsp::Interval> stretches;  ///< run through, each from its measured state
  Figure nmse;                           ///< of x, about its mean, set to the measured state `num_restarts` times
  int num_restarts = 0;                  ///< before errors have grown tenfold, as for a verdict
  Figure unaided;                        ///< as nmse, without any
  Figure rms;                            ///< of x less its prediction, in `unit`
  Figure noise_floor;                    ///< rms of the noise of x within its band: no equation comes closer
  Figure linear, still;                  ///< NMSE of the linear equation, and of a payload that does not move
  std::string remark;                    ///< not empty: what the reader must know
  Coordinates coordinates;               ///< the recording's, in which the equation was run
  std::vector<CarryOver> coefficients;   ///< empty: not compared
  Eigen::VectorXd time_s, x, predicted, linear_predicted;  ///< per sample; NaN where nothing was run
};

struct PredictOptions {
  std::string fitted_as = {};  ///< name under which the equation was fitted to this very recording; empty: it was not
  std::string where = {};      ///< condition on the rows that coefficients are compared on; empty: all
  int num_threads = 1;
  Poll poll = {};
};

/// Coefficients that differ by recording are those of `fitted_as`, else their mean, and so said in the remark. Runs
/// `model` free over every interval of the recording without a gap, at least a period long, in the coordinates that the
/// model states: of a recording that it was fitted to, its own; of another, with f led as in those, and x about the
/// zero that a person stated, else about the one with which the equation's acceleration is closest to the recorded one
/// (a constant of its own, which the remark names). Where x or v are beyond what the equation was fitted to, the remark
/// says so. `linear`: what is to be beaten; without terms: nothing is. Throws dsp::Fault (input) predict.input where
/// the recording lacks a signal of the equation.
[[nodiscard]] RecordPrediction predict(const Model& model, const Model& linear, const Record& record,
                                       const PredictOptions& options = {});

}  // namespace ident
