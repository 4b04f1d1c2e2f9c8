#pragma once
#include <string>
#include <utility>
#include <vector>

#include "apps/paper/rig.hpp"

// The record behind Tables 9-12 of [QZS23] is not public, so nothing here can be refuted by computing it again.
// Verdicts say how the twin T1 by the paper's recipe compares, reasons what our own measurements say about the
// difference.

namespace apps {

/// The fits of a regime by a method, in all seeds.
[[nodiscard]] JsonRows rig_fits(const RigReplication& replication, const RigRegime& regime, const RigWay& way,
                                const std::string& candidates = "paper", const std::string& method = "fast_rvm");

/// What the damping terms of an equation in x, v and ddr take out of steady motion in which these reach the given
/// magnitudes, over the most that the base term can put in; no more than 1 in truth. NaN without a base term.
[[nodiscard]] double damping_over_supply(const std::vector<std::pair<std::string, double>>& terms, double x_max,
                                         double v_max, double ddr_max);
/// For the print: coefficients of columns that reach 1 in such motion.
[[nodiscard]] double printed_damping_over_supply(int table);

/// Coefficients of variation of F-RVM over those of S-RVM, the same posterior without its noise.
struct CovRatio {
  double mean = 0.0, spread = 0.0;  ///< over the terms; spread: greatest over least, minus 1
  double target_rms = 0.0;          ///< that the printed training error then implies
};
[[nodiscard]] CovRatio printed_cov_ratio(int table);

/// Rows of "paper" for every printed number of the tables of these regimes: those of Table 9 have the regime as row and
/// train or test as term.
[[nodiscard]] Json compare_rig(const RigReplication& replication, const std::vector<RigRegime>& regimes);

/// What differs and why, in sentences with our own measurements.
[[nodiscard]] std::vector<std::string> rig_differences(const RigReplication& replication, const RigRegime& regime);

}  // namespace apps
