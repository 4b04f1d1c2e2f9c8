#include "ident/library/expression.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "ident/library/dimension.hpp"
#include "ident/library/expression_derivative.hpp"
#include "ident/library/expression_parser.hpp"
#include "ident/library/expression_program.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

bool add_once(std::vector<std::string>& list, std::string text) {
  if (std::find(list.begin(), list.end(), text) != list.end()) return false;
  list.push_back(std::move(text));
  return true;
}

std::vector<std::string> signals_of(const Tree& tree) {
  std::vector<std::string> signals;
  for_each_node(tree, [&](const Node& node) {
    if (node.operation == Operation::signal) add_once(signals, node.name);
  });
  return signals;
}

std::vector<Tree> switch_trees(const Tree& tree) {
  std::vector<std::string> known;
  std::vector<Tree> arguments;
  for_each_node(tree, [&](const Node& node) {
    const bool is_switch = node.operation == Operation::call && node.function == Function::sgn;
    if (is_switch && add_once(known, print_tree(*node.left, Notation::text))) arguments.push_back(node.left);
  });
  return arguments;
}

double band_factor_of(const Node& node) {
  if (node.operation == Operation::number || is_logical(node)) return 0.0;
  if (node.operation == Operation::signal) return 1.0;
  const double left = band_factor_of(*node.left);
  if (node.operation == Operation::call)
    return node.function == Function::sgn ? 0.0 : node.function == Function::abs ? left : 3.0 * left;
  if (!node.right) return left;
  const double right = band_factor_of(*node.right);
  switch (node.operation) {
    case Operation::multiply:
      return left + right;
    case Operation::divide:
      return left + 3.0 * right;
    case Operation::power:
      return left * (node.right->operation == Operation::number ? std::max(1.0, node.right->value) : 3.0);
    default:
      return std::max(left, right);
  }
}

Tree read(std::string_view text, const std::vector<std::string>& signal_names) {
  std::string known = fmt::format("signals are {}; functions", fmt::join(signal_names, ", "));
  for (const KnownFunction& function : known_functions) known += fmt::format(" {}", function.name);
  return parse_expression(
      text,
      [&](std::string_view name) {
        return std::find(signal_names.begin(), signal_names.end(), name) != signal_names.end();
      },
      known);
}

}  // namespace

std::vector<FunctionHelp> expression_functions() {
  std::vector<FunctionHelp> help;
  for (const KnownFunction& f : known_functions) help.push_back({fmt::format("{}(g)", f.name), std::string(f.meaning)});
  help.push_back(
      {"+ - * / ^", "arithmetic; ^ is a real power, -x^2 is -(x^2), a negative base wants a whole exponent"});
  help.push_back({"< <= > >= == != && ||", "comparisons, for conditions"});
  return help;
}

struct Expression::Parts {
  Tree tree;
  std::string text;
  std::vector<std::string> signals, switches;
  std::vector<Expression> switch_arguments;
  Program program;
};

Expression::Expression(Tree tree, std::string text) {
  std::vector<std::string> signals = signals_of(tree), switches;
  std::vector<Expression> arguments;
  for (const Tree& argument : switch_trees(tree)) {
    switches.push_back(print_tree(*argument, Notation::text));
    arguments.push_back(Expression(argument, switches.back()));
  }
  Program program(tree, signals, switches);
  parts_ = std::make_shared<const Parts>(Parts{std::move(tree), std::move(text), std::move(signals),
                                               std::move(switches), std::move(arguments), std::move(program)});
}

Expression::Expression(std::string_view text, const std::vector<std::string>& signal_names)
    : Expression(read(text, signal_names), std::string(text)) {}

Expression::Expression(std::string_view text)
    : Expression(parse_expression(text, [](std::string_view) { return true; }, {}), std::string(text)) {}

const std::string& Expression::text() const& {
  return parts_->text;
}
const std::vector<std::string>& Expression::signals() const& {
  return parts_->signals;
}
const std::vector<std::string>& Expression::switches() const& {
  return parts_->switches;
}

VectorXd Expression::evaluate(const dsp::Motion& motion) const {
  return evaluate(motion, 0, motion.num_samples());
}

VectorXd Expression::evaluate(const dsp::Motion& motion, Index first, Index count) const {
  std::vector<VectorXd> signs;
  for (const Expression& argument : parts_->switch_arguments)
    signs.push_back(argument.evaluate(motion, first, count).unaryExpr(&sign));
  std::vector<const double*> columns;
  for (const std::string& name : parts_->signals) columns.push_back(motion.at(name).data() + first);
  for (const VectorXd& sign : signs) columns.push_back(sign.data());
  return evaluate(columns, count);
}

VectorXd Expression::evaluate(const std::vector<const double*>& columns, Index num_rows) const {
  return parts_->program.over(columns, num_rows);
}

double Expression::evaluate(const double* values, const double* signs) const {
  return parts_->program.at(values, signs);
}

std::vector<Switch> Expression::all_switches() const {
  std::vector<std::string> known;
  std::vector<Switch> found;
  for_each_node(parts_->tree, [&](const Node& node) {
    const bool comparison = is_comparison(node);
    const bool magnitude = node.operation == Operation::call && node.function == Function::abs;
    const bool sign = node.operation == Operation::call && node.function == Function::sgn;
    if (!comparison && !magnitude && !sign) return;
    const Tree argument = comparison ? binary_node(Operation::subtract, node.left, node.right) : node.left;
    const SwitchKind kind = comparison ? SwitchKind::comparison : sign ? SwitchKind::sign : SwitchKind::magnitude;
    std::string text = print_tree(*argument, Notation::text);
    if (add_once(known, fmt::format("{} {}", static_cast<int>(kind), text)))
      found.push_back({kind, Expression(argument, text)});
  });
  return found;
}

Expression Expression::derivative(std::string_view signal) const {
  Tree tree = ident::derivative(parts_->tree, std::string(signal)).tree();
  std::string text = print_tree(*tree, Notation::text);
  return {std::move(tree), std::move(text)};
}

std::optional<double> Expression::ratio_to(const Expression& other) const {
  const auto own = NormalForm::of(parts_->tree).scaled(), others = NormalForm::of(other.parts_->tree).scaled();
  if (own.unit != others.unit) return std::nullopt;
  return own.scale == others.scale ? 1.0 : own.scale / others.scale;
}

double Expression::band_factor() const {
  return band_factor_of(*parts_->tree);
}

std::string Expression::unit(const dsp::Motion& signals) const {
  const auto dimension = dimension_of(*parts_->tree, [&](const std::string& name) -> std::optional<Dimension> {
    const dsp::Signal* signal = signals.find(name);
    if (signal == nullptr || signal->unit.empty()) return std::nullopt;
    return Dimension::of_unit(signal->unit);
  });
  return dimension ? dimension->unit() : std::string();
}

std::string Expression::print(Notation notation) const {
  return print_tree(*parts_->tree, notation);
}

std::string Expression::print_as_factor(Notation notation) const {
  return print_factor(*parts_->tree, notation);
}

std::vector<unsigned char> rows_where(const Expression& condition, const dsp::Motion& motion) {
  const VectorXd values = condition.evaluate(motion);
  std::vector<unsigned char> rows(static_cast<std::size_t>(values.size()));
  for (Index i = 0; i < values.size(); ++i)
    rows[static_cast<std::size_t>(i)] = std::isfinite(values(i)) && values(i) != 0.0;
  return rows;
}

}  // namespace ident
