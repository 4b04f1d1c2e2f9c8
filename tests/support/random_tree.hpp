#pragma once
#include <array>
#include <random>
#include <string>
#include <vector>

#include "ident/library/expression_tree.hpp"

namespace support {

/// Random expressions of signals "x", "v", "ddr"; sgn never inside sgn.
class RandomTree {
 public:
  enum class Kind { smooth, any };  ///< smooth: no comparisons, && or ||
  RandomTree(unsigned seed, Kind kind) : engine_(seed), kind_(kind) {}

  ident::Tree operator()(int depth) { return make(depth, false); }
  double uniform(double from, double to) { return std::uniform_real_distribution<double>(from, to)(engine_); }

 private:
  using Operation = ident::Operation;
  int below(int count) { return std::uniform_int_distribution<int>(0, count - 1)(engine_); }
  ident::Tree number() {
    static constexpr std::array numbers{1.0, 2.0, 3.0, 0.5, 0.1, 7.25, 1e-5, 12.0};
    return ident::number_node(numbers[static_cast<std::size_t>(below(8))]);
  }
  ident::Tree leaf() {
    static const std::array<std::string, 3> signals{"x", "v", "ddr"};
    return below(3) == 0 ? number() : ident::signal_node(signals[static_cast<std::size_t>(below(3))]);
  }
  ident::Tree make(int depth, bool in_sgn) {
    if (depth == 0) return leaf();
    const int choice = below(kind_ == Kind::any ? 12 : 10);
    if (choice < 2) {  // a function; 1 is sgn
      int function = below(8);
      if (function <= 1 && in_sgn) function = 2;  // the derivative of abs is sgn
      return ident::call_node(static_cast<ident::Function>(function), make(depth - 1, in_sgn || function <= 1));
    }
    if (choice == 2) return ident::negate_node(make(depth - 1, in_sgn));
    if (choice == 3)
      return ident::binary_node(Operation::power, make(depth - 1, in_sgn), kind_ == Kind::any ? leaf() : number());
    const Operation arithmetic[] = {Operation::add, Operation::subtract, Operation::multiply, Operation::divide};
    const Operation operation =
        choice < 10 ? arithmetic[below(4)] : static_cast<Operation>(static_cast<int>(Operation::less) + below(8));
    return ident::binary_node(operation, make(depth - 1, in_sgn), make(depth - 1, in_sgn));
  }

  std::mt19937 engine_;
  Kind kind_;
};

}  // namespace support
