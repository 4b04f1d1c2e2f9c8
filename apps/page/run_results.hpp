#pragma once
#include <cstddef>
#include <optional>
#include <vector>

#include "apps/config/config.hpp"
#include "apps/config/inputs.hpp"
#include "apps/output/steps_table.hpp"
#include "apps/page/physical_terms.hpp"
#include "ident/identify.hpp"
#include "ident/judgement/judge.hpp"
#include "ident/validate/predict.hpp"

namespace apps {

/// All that a run knows at its end, for what is written about it. Nothing is owned.
struct RunResults {
  const Config& config;
  const std::vector<Input>& inputs;
  const std::vector<ident::Columns>& columns;  ///< of each input
  const std::vector<ident::RangeResult>& ranges;
  std::vector<RecordingSteps> steps = {};                 ///< of recordings that are stepped sines
  std::vector<ident::RecordPrediction> predictions = {};  ///< of recordings that were kept for that
  std::optional<ident::BandSplit> split = {};             ///< of the whole band, where that was lowered
};

/// The equation that speaks for the run, of a range that has one; nullptr: no terms were found anywhere.
struct ChosenEquation {
  const ident::RangeResult* range = nullptr;
  const ident::JudgedFit* fit = nullptr;
};
[[nodiscard]] ChosenEquation chosen_equation(const std::vector<ident::RangeResult>& ranges);
void chosen_equation(const std::vector<ident::RangeResult>&&) = delete;
/// The same within one range.
[[nodiscard]] ChosenEquation chosen_equation(const ident::RangeResult& range);
void chosen_equation(const ident::RangeResult&&) = delete;

/// Whether nothing but the payload moves: y and dy are x and v, but for a constant.
[[nodiscard]] bool base_at_rest(const dsp::Motion& signals);

/// What the coefficients of a range's equation mean, with the uncertainty that they have in SI. Nothing of one closed
/// orbit with fewer equations than candidates: its frequency is the motion's, which a drive may set.
[[nodiscard]] std::vector<PhysicalTerm> physical_terms(const ChosenEquation& chosen, const RunResults& results);

/// "describes", "describes in part", ...
[[nodiscard]] const char* in_words(ident::Verdict verdict);
/// "no term explains more than noise", "too few rows for the terms", ...
[[nodiscard]] const char* in_words(ident::FitStatus status);

}  // namespace apps
