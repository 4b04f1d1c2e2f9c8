#include "ident/library/expression_tree.hpp"

#include <utility>

namespace ident {

Tree number_node(double value) {
  if (value < 0.0) return negate_node(number_node(-value));
  return std::make_shared<const Node>(Node{.operation = Operation::number, .value = value});
}
Tree signal_node(std::string name) {
  return std::make_shared<const Node>(Node{.operation = Operation::signal, .name = std::move(name)});
}
Tree call_node(Function function, Tree argument) {
  return std::make_shared<const Node>(
      Node{.operation = Operation::call, .function = function, .left = std::move(argument)});
}
Tree negate_node(Tree operand) {
  return std::make_shared<const Node>(Node{.operation = Operation::negate, .left = std::move(operand)});
}
Tree binary_node(Operation operation, Tree left, Tree right) {
  return std::make_shared<const Node>(Node{.operation = operation, .left = std::move(left), .right = std::move(right)});
}

bool is_comparison(const Node& node) {
  return node.operation >= Operation::less && node.operation <= Operation::not_equal;
}
bool is_logical(const Node& node) {
  return node.operation >= Operation::less;
}

int precedence(const Node& node) {
  switch (node.operation) {
    case Operation::logical_or:
      return 1;
    case Operation::logical_and:
      return 2;
    case Operation::add:
    case Operation::subtract:
      return 4;
    case Operation::negate:
    case Operation::multiply:
    case Operation::divide:
      return 5;
    case Operation::power:
      return 6;
    case Operation::number:
    case Operation::signal:
    case Operation::call:
      return 7;
    default:
      return 3;
  }
}

bool identical(const Node& a, const Node& b) {
  const auto same = [](const Tree& one, const Tree& other) {
    return one == other || (one != nullptr && other != nullptr && identical(*one, *other));
  };
  return a.operation == b.operation && a.value == b.value && a.name == b.name && a.function == b.function &&
         same(a.left, b.left) && same(a.right, b.right);
}

void for_each_node(const Tree& tree, const std::function<void(const Node&)>& visit) {
  visit(*tree);
  if (tree->left) for_each_node(tree->left, visit);
  if (tree->right) for_each_node(tree->right, visit);
}

}  // namespace ident
