#pragma once
#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "apps/columns.hpp"
#include "apps/range.hpp"
#include "ident/fit.hpp"
#include "ident/model.hpp"
#include "ident/validate/free_run.hpp"
#include "ident/validate/judge.hpp"

namespace apps {

/// A sample of one of the recordings.
struct Row {
  std::size_t recording = 0;
  Eigen::Index sample = 0;
};

/// Rows that are fitted together, and rows they are tried on; in the order of recordings and time.
struct RangeRows {
  std::vector<Row> train, test;
  std::vector<dsp::Interval> train_s,
      test_s;  ///< stretches without an excluded gap; rows that `where` drops do not split
};

/// A number that may be missing for a reason that can be told.
struct Figure {
  double value = 0.0;
  std::string reason;  ///< not empty: there is no value
};

/// One method on one range, with all that is needed to judge it.
struct JudgedFit {
  ident::Fit fit;  ///< terms are those of the library
  ident::Model model;
  ident::Whiteness whiteness;                       ///< of the training residual
  Figure train, test, train_centred, test_centred;  ///< NMSE
  ident::BandShares bands;                          ///< share of the test targets inside their predictive bands
  std::string bands_reason;                         ///< not empty: there are none
  ident::FreeRun free_run;
  double solve_s = 0.0;
  Eigen::VectorXd predicted, predicted_std;  ///< training rows, then test rows
};

struct RangeResult {
  dsp::RangeSpec spec;             ///< with what was left out filled in
  int recording = 0;               ///< 1-based; 0: all
  dsp::RegimeSet regime;           ///< as in Range
  std::vector<std::string> terms;  ///< of the library
  RangeRows rows;
  Eigen::VectorXd target;  ///< training rows, then test rows
  std::vector<DroppedTerm> dropped;
  std::vector<std::string> uncalibrated;  ///< channels of raw numbers, with their recordings
  double accumulate_s = 0.0;
  double power_balance = std::numeric_limits<double>::quiet_NaN();  ///< of corrected v and a; NaN: nothing to check
  std::vector<JudgedFit> fits;
};

struct IdentifyOptions {
  std::string target = "a", target_unit;
  std::vector<ident::Method> methods;
  ident::Selection selection = ident::Selection::evidence;
  double tau = -1.0, threshold = 0.02;
  bool unit_norm_threshold = true;
  double ridge_lambda = ident::RidgeOptions{}.lambda, lasso_lambda = ident::LassoOptions{}.lambda;
  int num_threads = 1;
  bool free_run = true;  ///< false: the rows of a table are no time response
};

/// Samples of the range: inside [from, to), not excluded, not at a spoilt end, of its regime, `where` true; training
/// rows before train_to, or the first train_share of each recording's rows. Throws dsp::Fault (usage, "range.outside",
/// "range.empty", "term.*" for the condition) with the range's place in the config.
[[nodiscard]] RangeRows range_rows(const Range& range, const std::vector<Columns>& recordings);

/// Fits each method on the training rows of a range and judges it. `columns` are those of each recording, of one
/// library.
[[nodiscard]] RangeResult identify(const Range& range, const std::vector<Columns>& recordings,
                                   const ident::CandidateLibrary& library, const IdentifyOptions& options);

}  // namespace apps
