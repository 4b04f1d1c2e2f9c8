#pragma once
#include <string>
#include <vector>

#include "ident/equation/model.hpp"

namespace apps {

/// "a = -50.0(2) x - 0.79(1) v", each coefficient with the digits it earns; as text, LaTeX (siunitx reads the brackets
/// alike), or MathML (a math element for each term, so that lines may break between them). "a = 0" for no terms.
/// Where coefficients differ by recording a symbol stands for them.
[[nodiscard]] std::string displayed_equation(const ident::Model& model, ident::Notation notation);

/// What these symbols are: "c1, of sgn(dy), differs by recording: -0.223(5) in run1.csv, -0.418(7) in run2.csv."
[[nodiscard]] std::vector<std::string> own_coefficient_sentences(const ident::Model& model);

}  // namespace apps
