#pragma once
#include <string>
#include <vector>

#include "apps/config/inputs.hpp"
#include "ident/identify.hpp"

namespace apps {

/// Channels of raw numbers that any of the ranges rests on, "recording: channel", each once.
[[nodiscard]] std::vector<std::string> uncalibrated_channels(const std::vector<ident::RangeResult>& ranges);

/// Of candidates, by their places in `labels`.
[[nodiscard]] std::vector<std::string> names_of(const std::vector<Eigen::Index>& terms,
                                                const std::vector<std::string>& labels);

/// Where a coefficient's variance comes from, the largest sources first, and what its calibrations may change it by;
/// "-" for nothing.
[[nodiscard]] std::string budget_text(const ident::Model& model, const ident::ModelTerm& term);

/// "x = 0 is where y - r is 0.00012(3) m.", in each recording, and by how much f is led where it is; empty for none.
[[nodiscard]] std::string coordinates_sentence(const std::vector<ident::Coordinates>& coordinates);

/// "Calibration, apart from these: displacements and f 1 %."; empty where the coefficients change with none.
[[nodiscard]] std::string calibration_sentence(const ident::Model& model);

/// What a method found.
struct MethodModel {
  ident::Method method;
  const ident::Model* model;
};
/// What the other methods found where this model is shown: "slow_rvm agrees; sindy differs in x^2."
[[nodiscard]] std::string agreement_sentence(const ident::Model& shown, const std::vector<MethodModel>& others);

/// The identified equations for a terminal, under a line that names channels not calibrated if there are any: each with
/// its error bars and, right under it, in one sentence whether it describes the record, then remarks; last what the
/// ranges disagree on.
[[nodiscard]] std::string report_text(const std::vector<ident::RangeResult>& ranges);

/// Which stage the coefficients of a fit are of, and why: "the likelihood of 3753 recorded samples (method fast_rvm
/// before it)"; "method fast_rvm (regression: x is the difference of two channels)".
[[nodiscard]] std::string stage_text(const ident::RangeResult& range, const ident::JudgedFit& fit);

/// That a record does not follow one equation in its whole band, with the coefficient that shows it; no full stop.
[[nodiscard]] std::string to_text(const ident::BandSplit& split);

/// What is wrong with the recordings' sensors and samples, a line each; empty where nothing is.
[[nodiscard]] std::string findings_text(const std::vector<Input>& inputs);

/// The same equations as LaTeX, the judgement as a comment before each.
[[nodiscard]] std::string report_latex(const std::vector<ident::RangeResult>& ranges);

}  // namespace apps
