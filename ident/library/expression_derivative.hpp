#pragma once
#include <string>

#include "ident/library/normal_form.hpp"

namespace ident {

/// Derivative with respect to a signal, the others held. That of sgn, of comparisons, && and || is zero: where they
/// jump there is none. abs(g) gives sgn(g).
[[nodiscard]] NormalForm derivative(const Tree& tree, const std::string& signal);

}  // namespace ident
