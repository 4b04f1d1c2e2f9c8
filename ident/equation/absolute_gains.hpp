#pragma once
#include <string>
#include <vector>

#include "dsp/prepare.hpp"
#include "ident/equation/model.hpp"
#include "ident/library/library.hpp"

// Gains that nothing in a record can tell: a common factor on all that rests on one calibration changes the
// coefficients and leaves every residual as it is. They are no sensor parameters, whose columns would take the place of
// the terms themselves (that of a force's gain is the column of f), and are listed apart: a coefficient's standard
// deviation is that in the units which the sensors have as calibrated, and all coefficients share what those are off.

namespace ident {

/// What these signals recorded, times 1 + e, is what happened; e is known to a standard deviation only.
struct AbsoluteGain {
  std::string name;  ///< "displacements", "velocities", "accelerations", or that of a signal: "f"
  double std = 0.0;  ///< of e: the sensitivity_uncertainty of the channel that the others are brought to
  std::vector<std::string> signals;
  [[nodiscard]] bool scales(const std::string& signal) const;
};

/// Those of a recording. A computed derivative or integral goes with what it was computed from; where displacement and
/// accelerometer of a body were brought to agree, both go with the one believed in scale. Of several channels of one
/// quantity the payload's counts, else the relative one's, else the base's: the others' gains beside it are sensor
/// parameters.
[[nodiscard]] std::vector<AbsoluteGain> absolute_gains(const dsp::Prepared& prepared);

/// By what power of 1 + e the coefficient of `term` changes in an equation for `target`: 1 where the gain scales the
/// target, less the term's degree in the signals it scales. x^3 in one for a measured a: 1 by accelerations, -3 by
/// displacements. Of a term without a degree, exp(x), that of the multiple of it nearest to its change, over all
/// samples of `motion`; NaN where the term is zero there or not finite.
[[nodiscard]] double gain_exponent(const Expression& term, const std::string& target, const AbsoluteGain& gain,
                                   const dsp::Motion& motion);

/// Fills in the model's calibration and the gain_exponents of every coefficient. `motion`: samples that the terms are
/// evaluated on.
void set_calibration(Model& model, const CandidateLibrary& library, const std::vector<AbsoluteGain>& gains,
                     const dsp::Motion& motion);

}  // namespace ident
