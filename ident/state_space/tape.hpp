#pragma once
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "ident/library/expression_tree.hpp"

namespace ident::state_space {

/// Points that are computed together: their values lie side by side, so that a processor takes several at once.
inline constexpr int side_by_side = 8;

/// Which derivatives are computed beside a value.
enum class Slopes { none, by_states, by_states_and_time };

/// What an instruction does: of one operand, of two, by the side of a switch.
enum class TapeCode : unsigned char {
  negate,
  power,
  real_power,
  sin,
  cos,
  exp,
  log,
  sqrt,
  tanh,
  add,
  subtract,
  multiply,
  divide,
  either,
  any_power,
  side,
  below,
  above,
  by_side
};

/// Several expressions as one list of instructions, what they share computed once, each value with its exact
/// derivatives (forward differentiation). Everything that jumps or bends where some g passes zero, sgn(g), abs(g) and
/// comparisons, is taken on a side of g, +1 or -1, that the caller names: within a side all are smooth. Of a side in
/// between, as of a motion that is held at g = 0, so much of either.
///
/// Registers are `stride()` x L doubles each for L points side by side: value, derivative by each state, derivative by
/// time through the inputs. The first registers are the signals, states before inputs.
class Tape {
 public:
  /// `signals`: names of what the expressions look at, of which the first `num_states` are states. Throws
  /// std::invalid_argument for a name that is not among them.
  Tape(const std::vector<Tree>& expressions, const std::vector<std::string>& signals, int num_states);

  [[nodiscard]] int stride() const { return num_states_ + 2; }
  [[nodiscard]] int num_registers() const { return num_registers_; }
  /// The register that holds expression i, and the g of switch i.
  [[nodiscard]] int result(int i) const { return results_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] int switch_value(int i) const { return switches_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] int num_switches() const { return static_cast<int>(switches_.size()); }

  /// Registers ready for `run`: numbers in place, each state with derivative 1 by itself.
  template <int L>
  [[nodiscard]] std::vector<double> registers() const;
  /// All values and these derivatives from the values of the signals. `sides`: switches x L. For those by time, the
  /// derivatives of the inputs by time are given in their registers too.
  template <int L>
  void run(double* registers, const double* sides, Slopes slopes) const;
  /// How many derivatives that are.
  [[nodiscard]] int count(Slopes slopes) const {
    return slopes == Slopes::none ? 0 : num_states_ + (slopes == Slopes::by_states ? 0 : 1);
  }

 private:
  using Code = TapeCode;
  struct Instruction {
    Code code;
    int out = 0, a = 0, b = 0;  ///< registers; b of a switch: its index
    double exponent = 0.0;
  };
  using Key = std::tuple<Code, int, int, double>;
  [[nodiscard]] int compile(const Node& node, const std::vector<std::string>& signals);
  [[nodiscard]] int compile_call(const Node& node, const std::vector<std::string>& signals);
  [[nodiscard]] int compile_power(const Node& node, const std::vector<std::string>& signals);
  [[nodiscard]] int number(double value);
  [[nodiscard]] int emit(Code code, int a, int b = 0, double exponent = 0.0);
  [[nodiscard]] int switch_of(int g);

  int num_states_, num_registers_;
  std::vector<Instruction> instructions_;
  std::map<Key, int> known_;
  std::map<double, int> numbers_;
  std::vector<int> results_, switches_;
};

}  // namespace ident::state_space
