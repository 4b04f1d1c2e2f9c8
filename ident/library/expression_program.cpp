#include "ident/library/expression_program.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>

#include "ident/library/expression_printers.hpp"

namespace ident {
namespace {

using Eigen::Index;

constexpr Index rows_at_once = 512;  // 4 kB a register: a few fit the first-level cache, all the second

std::uint32_t position_in(const auto& list, const auto& wanted) {
  return static_cast<std::uint32_t>(std::find(list.begin(), list.end(), wanted) - list.begin());
}

/// How many factors a low power of a signal is computed by, ten times faster than std::pow; 0: by std::pow, as all
/// others.
int product_of(const Node& node, bool base_is_signal) {
  if (node.operation != Operation::power || !base_is_signal || node.right->operation != Operation::number) return 0;
  const double exponent = node.right->value;
  return exponent == 2.0 || exponent == 3.0 || exponent == 4.0 ? static_cast<int>(exponent) : 0;
}

void apply_power(int factors, const auto& each) {
  switch (factors) {
    case 2:
      return each([](double g, double) { return g * g; });
    case 3:
      return each([](double g, double) { return g * g * g; });
    case 4:
      return each([](double g, double) { return g * g * g * g; });
    default:
      return each([](double g, double h) { return std::pow(g, h); });
  }
}

void apply_function(Function function, const auto& each) {
  switch (function) {
    case Function::abs:
      return each([](double g, double) { return std::abs(g); });
    case Function::sgn:
      return;  // an input
    case Function::sin:
      return each([](double g, double) { return std::sin(g); });
    case Function::cos:
      return each([](double g, double) { return std::cos(g); });
    case Function::exp:
      return each([](double g, double) { return std::exp(g); });
    case Function::log:
      return each([](double g, double) { return std::log(g); });
    case Function::sqrt:
      return each([](double g, double) { return std::sqrt(g); });
    case Function::tanh:
      return each([](double g, double) { return std::tanh(g); });
  }
}

void apply(Operation operation, const auto& each) {
  switch (operation) {
    case Operation::negate:
      return each([](double g, double) { return -g; });
    case Operation::add:
      return each([](double g, double h) { return g + h; });
    case Operation::subtract:
      return each([](double g, double h) { return g - h; });
    case Operation::multiply:
      return each([](double g, double h) { return g * h; });
    case Operation::divide:
      return each([](double g, double h) { return g / h; });
    case Operation::less:
      return each([](double g, double h) -> double { return g < h; });
    case Operation::less_equal:
      return each([](double g, double h) -> double { return g <= h; });
    case Operation::greater:
      return each([](double g, double h) -> double { return g > h; });
    case Operation::greater_equal:
      return each([](double g, double h) -> double { return g >= h; });
    case Operation::equal:
      return each([](double g, double h) -> double { return g == h; });
    case Operation::not_equal:
      return each([](double g, double h) -> double { return g != h; });
    case Operation::logical_and:
      return each([](double g, double h) -> double { return g != 0.0 && h != 0.0; });
    case Operation::logical_or:
      return each([](double g, double h) -> double { return g != 0.0 || h != 0.0; });
    case Operation::number:
    case Operation::signal:
    case Operation::power:
    case Operation::call:
      return;
  }
}

/// One instruction on `count` rows.
template <class Instruction, class Count>
void execute(const Instruction& instruction, const double* a, const double* b, double* out, Count count) {
  const auto each = [&](auto&& value) {
    for (Index i = 0; i < count; ++i) out[i] = value(a[i], b[i]);
  };
  if (instruction.operation == Operation::power)
    apply_power(instruction.product_of, each);
  else if (instruction.operation == Operation::call)
    apply_function(instruction.function, each);
  else
    apply(instruction.operation, each);
}

}  // namespace

Program::Program(const Tree& tree, const std::vector<std::string>& signals, const std::vector<std::string>& switches)
    : signals_(signals), switches_(switches) {
  for_each_node(tree, [&](const Node& node) {
    if (node.operation == Operation::number) numbers_.push_back(node.value);
  });
  std::sort(numbers_.begin(), numbers_.end());
  numbers_.erase(std::unique(numbers_.begin(), numbers_.end()), numbers_.end());
  last_ = compile(*tree, 0);
}

/// The register of the node's value; those of the `depth` first intermediate results are kept.
Program::Register Program::compile(const Node& node, Register depth) {
  if (node.operation == Operation::number) return first_number() + position_in(numbers_, node.value);
  if (node.operation == Operation::signal) return position_in(signals_, node.name);
  if (node.operation == Operation::call && node.function == Function::sgn)
    return static_cast<Register>(signals_.size()) + position_in(switches_, print_tree(*node.left, Notation::text));
  const Register a = compile(*node.left, depth);
  const Register b = node.right ? compile(*node.right, a < first_result() ? depth : depth + 1) : a;
  num_results_ = std::max(num_results_, depth + 1);
  instructions_.push_back(
      {node.operation, node.function, product_of(node, a < first_number()), first_result() + depth, a, b});
  return first_result() + depth;
}

double Program::at(const double* signals, const double* switches) const {
  constexpr std::size_t usual = 64;  // more than a term that people write needs
  std::array<double, usual> few;
  std::vector<double> many;
  const std::size_t wanted = first_result() + num_results_;
  if (wanted > usual) many.resize(wanted);
  double* registers = wanted > usual ? many.data() : few.data();
  double* next = registers;  // a few values each: loops, since a call of memmove takes longer
  for (std::size_t k = 0; k < signals_.size(); ++k) *next++ = signals[k];
  for (std::size_t k = 0; k < switches_.size(); ++k) *next++ = switches[k];
  for (const double number : numbers_) *next++ = number;
  for (const Instruction& instruction : instructions_)
    execute(instruction, registers + instruction.a, registers + instruction.b, registers + instruction.out,
            std::integral_constant<Index, 1>());
  return registers[last_];
}

Eigen::VectorXd Program::over(const std::vector<const double*>& inputs, Index num_rows) const {
  Eigen::VectorXd values(num_rows);
  Eigen::MatrixXd own(rows_at_once, static_cast<Index>(numbers_.size()) + num_results_);
  for (std::size_t k = 0; k < numbers_.size(); ++k) own.col(static_cast<Index>(k)).setConstant(numbers_[k]);
  const auto own_register = [&](Register wanted) {
    return own.col(static_cast<Index>(wanted - first_number())).data();
  };
  for (Index first = 0; first < num_rows; first += rows_at_once) {
    const Index count = std::min(rows_at_once, num_rows - first);
    const auto read = [&](Register wanted) -> const double* {
      return wanted < first_number() ? inputs[wanted] + first : own_register(wanted);
    };
    for (const Instruction& instruction : instructions_)
      execute(instruction, read(instruction.a), read(instruction.b), own_register(instruction.out), count);
    std::copy_n(read(last_), count, values.data() + first);
  }
  return values;
}

}  // namespace ident
