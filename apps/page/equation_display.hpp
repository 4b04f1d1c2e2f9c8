#pragma once
#include <string>

#include "ident/model.hpp"

namespace apps {

/// The standard deviation a reader is given: in SI, with calibration, where known; else the total in the sensors'
/// units.
[[nodiscard]] double shown_std(const ident::ModelTerm& term);

/// "a = -50.0(2) x - 0.79(1) v", each coefficient with the digits it earns; as text, LaTeX (siunitx reads the brackets
/// alike), or MathML (a math element for each term, so that lines may break between them). "a = 0" for no terms.
[[nodiscard]] std::string displayed_equation(const ident::Model& model, ident::Notation notation);

}  // namespace apps
