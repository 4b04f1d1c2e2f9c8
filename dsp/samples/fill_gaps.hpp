#pragma once
#include <Eigen/Core>
#include <vector>

#include "dsp/values/recording.hpp"

namespace dsp {

struct FillOptions {
  double max_gap_s = 1.0;  ///< longer gaps are bridged by a straight line
  Eigen::Index order = 0;  ///< of the predictors; 0: as many samples as make a second, 64 to 256
  double fit_s = 8.0;      ///< of the signal on either side that they are fitted to
};

/// Replaces the samples inside each gap (seconds from the first sample) by a prediction from before (Burg [Bur75]) and
/// one, backwards, from after, faded into each other; nothing outside changes. Meant for the intermediate rate, where a
/// predictor reaches over a cycle: there 0.3 s of any of the rig's channels come back within 0.4 % of their rms below
/// 10 Hz, and 1 s within 0.5 %, once the gap is widened by what the filter before it smears (FilterSheet::edge_s). Gaps
/// that touch are one; at an end of the record there is one prediction. Throws std::invalid_argument if nothing is left
/// to predict from.
void fill_gaps(Eigen::Ref<Eigen::VectorXd> samples, double sample_rate_hz, const std::vector<Interval>& gaps,
               const FillOptions& options = {});

}  // namespace dsp
