#include "ident/library/expression_printers.hpp"

#include <fmt/format.h>

#include <array>
#include <string_view>

namespace ident {
namespace {

/// What notations along one line differ in: formats of {0} and {1}.
struct Style {
  std::array<std::string_view, 15> operation;  ///< negate to logical_or, without call
  std::string_view KnownFunction::*call;       ///< the column of the table of functions; none: name(...)
  std::string_view as_number;                  ///< a comparison as 0 or 1
  bool point;                                  ///< 2 would be a whole number there: it is written 2.0
};

constexpr Style text_style{{"-{}", "{}+{}", "{}-{}", "{}*{}", "{}/{}", "{}^{}", "", "{}<{}", "{}<={}", "{}>{}",
                            "{}>={}", "{}=={}", "{}!={}", "{}&&{}", "{}||{}"},
                           nullptr,
                           {},
                           false};
constexpr Style c_style{{"-{}", "{} + {}", "{} - {}", "{}*{}", "{}/{}", "pow({}, {})", "", "{} < {}", "{} <= {}",
                         "{} > {}", "{} >= {}", "{} == {}", "{} != {}", "{} && {}", "{} || {}"},
                        &KnownFunction::c,
                        "(double)({})",
                        true};
constexpr Style matlab_style{{"-{}", "{} + {}", "{} - {}", "{}.*{}", "{}./{}", "{}.^{}", "", "{} < {}", "{} <= {}",
                              "{} > {}", "{} >= {}", "{} == {}", "{} ~= {}", "{} & {}", "{} | {}"},
                             &KnownFunction::matlab,
                             "double({})",
                             false};
constexpr Style python_style{
    {"-{}", "{} + {}", "{} - {}", "{}*{}", "{}/{}", "{}**{}", "", "{} < {}", "{} <= {}", "{} > {}", "{} >= {}",
     "{} == {}", "{} != {}", "np.logical_and({}, {})", "np.logical_or({}, {})"},
    &KnownFunction::python,
    "(1.0*({}))",
    true};

constexpr Style modelica_style{{"-{}", "{} + {}", "{} - {}", "{}*{}", "{}/{}", "{}^{}", "", "{} < {}", "{} <= {}",
                                "{} > {}", "{} >= {}", "{} == {}", "{} <> {}", "{} and {}", "{} or {}"},
                               nullptr,
                               "(if {} then 1.0 else 0.0)",
                               true};

std::string print(const Node& node, const Style& style) {
  if (node.operation == Operation::signal) return node.name;
  if (node.operation == Operation::number) {
    const std::string shortest = fmt::format("{}", node.value);
    const bool whole = shortest.find_first_of(".e") == std::string::npos;
    return style.point && whole ? shortest + ".0" : shortest;
  }
  if (node.operation == Operation::call && style.call == nullptr)
    return fmt::format("{}({})", info_of(node.function).name, print(*node.left, style));
  const auto operation = static_cast<std::size_t>(node.operation) - static_cast<std::size_t>(Operation::negate);
  const std::string_view format =
      node.operation == Operation::call ? info_of(node.function).*style.call : style.operation[operation];
  const bool infix = format.starts_with("{") || format.starts_with("-");
  const auto operand = [&](const Node& of, Side side) {
    const std::string text = print(of, style);
    if (is_logical(of) && !is_logical(node) && !style.as_number.empty())
      return fmt::format(fmt::runtime(style.as_number), text);
    return infix && needs_brackets(node, of, side) ? fmt::format("({})", text) : text;
  };
  const std::string left = operand(*node.left, Side::left);
  return node.right ? fmt::format(fmt::runtime(format), left, operand(*node.right, Side::right))
                    : fmt::format(fmt::runtime(format), left);
}

/// The node whose text comes first, a minus being the text of its node.
const Node& leftmost(const Node& node) {
  const bool begins_with_operand = node.operation > Operation::negate && node.operation != Operation::call;
  return begins_with_operand ? leftmost(*node.left) : node;
}

}  // namespace

bool needs_brackets(const Node& parent, const Node& operand, Side side) {
  const int own = precedence(operand), outer = precedence(parent);
  if (parent.operation == Operation::negate) return own < 6;
  if (parent.operation == Operation::power)  // to the right 2^-x needs none
    return side == Side::left ? own < 7 : own < 7 && !(operand.operation == Operation::negate);
  if (side == Side::right && leftmost(operand).operation == Operation::negate) return true;
  return side == Side::left && !is_comparison(parent) ? own < outer : own <= outer;
}

std::string print_tree(const Node& node, Notation notation) {
  switch (notation) {
    case Notation::text:
      return print(node, text_style);
    case Notation::latex:
      return print_latex(node);
    case Notation::mathml:
      return print_mathml(node);
    case Notation::c:
      return print(node, c_style);
    case Notation::matlab:
      return print(node, matlab_style);
    case Notation::python:
      return print(node, python_style);
    case Notation::modelica:
      return print(node, modelica_style);
  }
  return {};
}

std::string print_factor(const Node& node, Notation notation) {
  const Operation first = leftmost(node).operation;
  const std::string text = print_tree(node, notation);
  if (precedence(node) >= 5 && first != Operation::negate && first != Operation::number) return text;
  return notation == Notation::mathml ? fmt::format("<mrow><mo>(</mo>{}<mo>)</mo></mrow>", text)
                                      : fmt::format("({})", text);
}

}  // namespace ident
