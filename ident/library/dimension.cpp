#include "ident/library/dimension.hpp"

#include <fmt/format.h>

#include <cctype>
#include <charconv>
#include <cmath>

namespace ident {

std::optional<Dimension> Dimension::of_unit(std::string_view unit) {
  Dimension dimension;
  int sign = 1;
  bool in_brackets = false;
  for (std::size_t i = 0; i < unit.size();) {
    const char c = unit[i];
    if (std::isalpha(static_cast<unsigned char>(c))) {
      std::size_t end = i;
      while (end < unit.size() && std::isalpha(static_cast<unsigned char>(unit[end]))) ++end;
      Dimension base;
      base.powers_[std::string(unit.substr(i, end - i))] = 1;
      int power = 1;
      if (end < unit.size() && unit[end] == '^')
        end = std::from_chars(unit.data() + end + 1, unit.data() + unit.size(), power).ptr - unit.data();
      if (!base.powers_.contains("rad")) {
        const auto product = dimension.times(base, static_cast<double>(sign) * power);
        if (!product) return std::nullopt;
        dimension = *product;
      }
      if (!in_brackets) sign = 1;
      i = end;
      continue;
    }
    if (c == '/') sign = -1;
    if (c == '(') in_brackets = true;
    if (c == ')') in_brackets = false, sign = 1;
    ++i;
  }
  return dimension;
}

std::string Dimension::unit() const {
  std::string above, below;
  int num_below = 0;
  for (const auto& [base, exponent] : powers_) {
    std::string& side = exponent > 0 ? above : below;
    num_below += exponent < 0;
    side += (side.empty() ? "" : "*") + base + (std::abs(exponent) > 1 ? fmt::format("^{}", std::abs(exponent)) : "");
  }
  if (below.empty()) return above.empty() ? "1" : above;
  return (above.empty() ? "1" : above) + "/" + (num_below > 1 ? "(" + below + ")" : below);
}

std::optional<Dimension> Dimension::times(const Dimension& other, double exponent) const {
  constexpr double largest = 1000.0;  // of powers that a unit is printed with
  Dimension product = *this;
  for (const auto& [base, power] : other.powers_) {
    const auto own = product.powers_.find(base);
    const double raised = power * exponent, sum = raised + (own == product.powers_.end() ? 0 : own->second);
    if (raised != std::floor(raised) || !(std::abs(sum) <= largest)) return std::nullopt;
    product.powers_[base] = static_cast<int>(sum);
  }
  std::erase_if(product.powers_, [](const auto& one) { return one.second == 0; });
  return product;
}

namespace {

using OfSignal = std::function<std::optional<Dimension>(const std::string&)>;

/// The number that an exponent is; none for anything else.
std::optional<double> plain_number(const Node& node) {
  if (node.operation == Operation::number) return node.value;
  if (node.operation == Operation::negate && node.left->operation == Operation::number) return -node.left->value;
  if (node.operation == Operation::divide) {
    const auto above = plain_number(*node.left), below = plain_number(*node.right);
    if (above && below) return *above / *below;
  }
  return std::nullopt;
}

std::optional<Dimension> dimension_of_call(const Node& node, const OfSignal& of_signal) {
  if (node.function == Function::sgn) return Dimension();
  const auto argument = dimension_of(*node.left, of_signal);
  if (!argument || node.function == Function::abs) return argument;
  if (node.function == Function::sqrt) return Dimension().times(*argument, 0.5);
  return argument->is_pure() ? argument : std::nullopt;
}

}  // namespace

std::optional<Dimension> dimension_of(const Node& node, const OfSignal& of_signal) {
  if (is_logical(node) || node.operation == Operation::number) return Dimension();
  if (node.operation == Operation::signal) return of_signal(node.name);
  if (node.operation == Operation::call) return dimension_of_call(node, of_signal);
  const auto left = dimension_of(*node.left, of_signal);
  if (!left || node.operation == Operation::negate) return left;
  const auto exponent = node.operation == Operation::power ? plain_number(*node.right) : std::nullopt;
  if (exponent) return Dimension().times(*left, *exponent);
  const auto right = dimension_of(*node.right, of_signal);
  if (!right) return std::nullopt;
  switch (node.operation) {
    case Operation::multiply:
      return left->times(*right);
    case Operation::divide:
      return left->times(*right, -1.0);
    case Operation::power:
      return left->is_pure() && right->is_pure() ? left : std::nullopt;
    default:
      return *left == *right ? left : std::nullopt;
  }
}

}  // namespace ident
