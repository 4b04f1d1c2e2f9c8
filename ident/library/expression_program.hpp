#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "ident/library/expression_tree.hpp"

namespace ident {

/// A tree as a list of instructions on registers. Running it changes nothing in it: threads may share it.
/// Registers: the inputs (values of the signals, then of the switches), the numbers, intermediate results.
class Program {
 public:
  /// `switches`: texts of the g whose sgn(g) is an input.
  Program(const Tree& tree, const std::vector<std::string>& signals, const std::vector<std::string>& switches);

  /// One value: `signals` and `switches` in the order given to the constructor.
  [[nodiscard]] double at(const double* signals, const double* switches) const;
  /// From columns of `num_rows` each, signals before switches; block by block, so that what lies between stays in
  /// cache.
  [[nodiscard]] Eigen::VectorXd over(const std::vector<const double*>& inputs, Eigen::Index num_rows) const;

 private:
  using Register = std::uint32_t;
  struct Instruction {
    Operation operation;
    Function function;
    int product_of;  ///< of a power: how many equal factors; 0: std::pow
    Register out, a, b;
  };
  Register compile(const Node& node, Register depth);
  [[nodiscard]] Register first_number() const { return static_cast<Register>(signals_.size() + switches_.size()); }
  [[nodiscard]] Register first_result() const { return first_number() + static_cast<Register>(numbers_.size()); }

  std::vector<std::string> signals_, switches_;
  std::vector<double> numbers_;
  std::vector<Instruction> instructions_;
  Register num_results_ = 0;  ///< intermediate ones that are wanted at a time
  Register last_ = 0;         ///< holds the value of the whole
};

}  // namespace ident
