#pragma once
#include <string>

#include "ident/library/expression_tree.hpp"

namespace ident {

/// How an expression is written: as it is read here, for a paper, for a page, or as code. C wants math.h, Python numpy
/// as np; MATLAB and Python take arrays; Modelica has no sgn that sees the jump.
enum class Notation { text, latex, mathml, c, matlab, python, modelica };

[[nodiscard]] std::string print_tree(const Node& node, Notation notation);
/// As a factor behind a coefficient: in brackets where it is a sum, a comparison, or begins with a sign or a digit.
[[nodiscard]] std::string print_factor(const Node& node, Notation notation);

/// Those that are not along one line.
[[nodiscard]] std::string print_latex(const Node& node);
[[nodiscard]] std::string print_mathml(const Node& node);
/// Whether an operand of an infix operator is in brackets.
enum class Side { left, right };
[[nodiscard]] bool needs_brackets(const Node& parent, const Node& operand, Side side);

}  // namespace ident
