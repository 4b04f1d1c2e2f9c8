#pragma once
#include <array>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace ident {

/// What a node of an expression does with its operands.
enum class Operation : unsigned char {
  number,
  signal,
  negate,
  add,
  subtract,
  multiply,
  divide,
  power,
  call,
  less,
  less_equal,
  greater,
  greater_equal,
  equal,
  not_equal,
  logical_and,
  logical_or
};

enum class Function : unsigned char { abs, sgn, sin, cos, exp, log, sqrt, tanh };
enum class Parity : unsigned char { none, even, odd };
/// One line of the table of functions. Notations: formats of the argument. What a function is worth and its derivative
/// are in expression_program.cpp and expression_derivative.cpp.
struct KnownFunction {
  Function function;
  std::string_view name, meaning;
  Parity parity;
  std::string_view latex;  ///< its name there; none: a notation of its own
  std::string_view c, matlab, python;
};
/// In the order of Function.
inline constexpr std::array<KnownFunction, 8> known_functions{{
    {Function::abs, "abs", "magnitude", Parity::even, "", "fabs({})", "abs({})", "np.abs({})"},
    {Function::sgn, "sgn", "sign: -1, 0 or 1; a switch that simulations locate exactly", Parity::odd,
     "\\operatorname{sgn}", "(double)(({0} > 0.0) - ({0} < 0.0))", "sign({})", "np.sign({})"},
    {Function::sin, "sin", "sine of radians", Parity::odd, "\\sin", "sin({})", "sin({})", "np.sin({})"},
    {Function::cos, "cos", "cosine of radians", Parity::even, "\\cos", "cos({})", "cos({})", "np.cos({})"},
    {Function::exp, "exp", "exponential", Parity::none, "\\exp", "exp({})", "exp({})", "np.exp({})"},
    {Function::log, "log", "natural logarithm; not finite at or below zero", Parity::none, "\\log", "log({})",
     "log({})", "np.log({})"},
    {Function::sqrt, "sqrt", "square root; not finite below zero", Parity::none, "", "sqrt({})", "sqrt({})",
     "np.sqrt({})"},
    {Function::tanh, "tanh", "hyperbolic tangent, a smooth sign", Parity::odd, "\\tanh", "tanh({})", "tanh({})",
     "np.tanh({})"},
}};
[[nodiscard]] inline const KnownFunction& info_of(Function function) {
  return known_functions[static_cast<std::size_t>(function)];
}
/// -1, 0 or 1; 0 of NaN.
[[nodiscard]] inline double sign(double g) {
  return g > 0.0 ? 1.0 : g < 0.0 ? -1.0 : 0.0;
}

struct Node;
/// Immutable, so that expressions share their parts.
using Tree = std::shared_ptr<const Node>;
struct Node {
  Operation operation;
  double value = 0.0;   ///< of a number, never negative: -2 is negate(2)
  std::string name;     ///< of a signal
  Function function{};  ///< of a call
  Tree left, right;     ///< one operand: left
};

[[nodiscard]] Tree number_node(double value);  ///< negative ones become negate(number)
[[nodiscard]] Tree signal_node(std::string name);
[[nodiscard]] Tree call_node(Function function, Tree argument);
[[nodiscard]] Tree negate_node(Tree operand);
[[nodiscard]] Tree binary_node(Operation operation, Tree left, Tree right);

/// Whether the value is 0 or 1: a comparison, && or ||.
[[nodiscard]] bool is_logical(const Node& node);
[[nodiscard]] bool is_comparison(const Node& node);
/// How tightly a node holds together as text: || 1, && 2, comparisons 3, sums 4, products and signs 5, powers 6,
/// rest 7.
[[nodiscard]] int precedence(const Node& node);
/// Node by node the same.
[[nodiscard]] bool identical(const Node& a, const Node& b);
/// Calls visit(node) for every node, in the order of the text.
void for_each_node(const Tree& tree, const std::function<void(const Node&)>& visit);

}  // namespace ident
