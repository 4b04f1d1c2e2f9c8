#include "ident/library/expression_derivative.hpp"

namespace ident {
namespace {

/// A function and its derivative, made together from the leaves up.
struct Slope {
  NormalForm value, derivative;
};

NormalForm derivative_of_call(Function function, const NormalForm& g) {
  switch (function) {
    case Function::abs:
      return NormalForm::call(Function::sgn, g);
    case Function::sgn:
      return NormalForm(0.0);
    case Function::sin:
      return NormalForm::call(Function::cos, g);
    case Function::cos:
      return -1.0 * NormalForm::call(Function::sin, g);
    case Function::exp:
      return NormalForm::call(Function::exp, g);
    case Function::log:
      return NormalForm::power(g, NormalForm(-1.0));
    case Function::sqrt:
      return 0.5 * NormalForm::power(g, NormalForm(-0.5));
    case Function::tanh:
      break;
  }
  return NormalForm(1.0) + -1.0 * NormalForm::power(NormalForm::call(Function::tanh, g), NormalForm(2.0));
}

/// g^h: h g^(h-1) g' for a number h, else g^h (h' log g + h g'/g).
NormalForm derivative_of_power(const Slope& g, const Slope& h) {
  if (const auto exponent = h.value.number())
    return *exponent * NormalForm::power(g.value, NormalForm(*exponent - 1.0)) * g.derivative;
  const NormalForm by_exponent = h.derivative * NormalForm::call(Function::log, g.value);
  const NormalForm by_base = h.value * g.derivative * NormalForm::power(g.value, NormalForm(-1.0));
  return NormalForm::power(g.value, h.value) * (by_exponent + by_base);
}

Slope slope_of(const Tree& tree, const std::string& signal) {
  const Node& node = *tree;
  if (node.operation == Operation::signal)
    return {NormalForm::signal(node.name), NormalForm(node.name == signal ? 1.0 : 0.0)};
  if (node.operation == Operation::number || is_logical(node)) return {NormalForm::of(tree), NormalForm(0.0)};
  const Slope g = slope_of(node.left, signal);
  if (node.operation == Operation::negate) return {-1.0 * g.value, -1.0 * g.derivative};
  if (node.operation == Operation::call)
    return {NormalForm::call(node.function, g.value), derivative_of_call(node.function, g.value) * g.derivative};
  const Slope h = slope_of(node.right, signal);
  switch (node.operation) {
    case Operation::add:
      return {g.value + h.value, g.derivative + h.derivative};
    case Operation::subtract:
      return {g.value + -1.0 * h.value, g.derivative + -1.0 * h.derivative};
    case Operation::multiply:
      return {g.value * h.value, g.derivative * h.value + g.value * h.derivative};
    case Operation::divide: {
      const NormalForm below = NormalForm::power(h.value, NormalForm(-1.0));
      return {g.value * below,
              g.derivative * below + -1.0 * g.value * h.derivative * NormalForm::power(h.value, NormalForm(-2.0))};
    }
    default:
      return {NormalForm::power(g.value, h.value), derivative_of_power(g, h)};
  }
}

}  // namespace

NormalForm derivative(const Tree& tree, const std::string& signal) {
  return slope_of(tree, signal).derivative;
}

}  // namespace ident
