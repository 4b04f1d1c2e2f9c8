#include "ident/state_space/tape.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace ident::state_space {
namespace {

/// x^n for n >= 0.
double whole_power(double x, int n) {
  double product = 1.0;
  for (; n > 0; --n) product *= x;
  return product;
}

/// Registers of one instruction, L points side by side, derivatives by `directions`.
template <int L>
struct Operands {
  double* out;
  const double *a, *b;
  int directions;

  /// out = f(a): `f(x, value, slope)`.
  template <class F>
  void unary(const F& f) const {
    double slope[L];
    for (int l = 0; l < L; ++l) f(a[l], out[l], slope[l]);
    for (int d = 1; d <= directions; ++d)
      for (int l = 0; l < L; ++l) out[d * L + l] = slope[l] * a[d * L + l];
  }
  /// out = f(a, b): `f(x, y, value, slope by x, slope by y)`.
  template <class F>
  void binary(const F& f) const {
    double by_a[L], by_b[L];
    for (int l = 0; l < L; ++l) f(a[l], b[l], out[l], by_a[l], by_b[l]);
    for (int d = 1; d <= directions; ++d)
      for (int l = 0; l < L; ++l) out[d * L + l] = by_a[l] * a[d * L + l] + by_b[l] * b[d * L + l];
  }
  /// By the side of a switch: `by_side` times a, else one of two constants.
  void switched(const double* side, bool by_side, double below, double above) const {
    for (int d = 0; d <= directions; ++d)
      for (int l = 0; l < L; ++l) {
        const double constant = d > 0 ? 0.0 : below + (above - below) * (0.5 * side[l] + 0.5);
        out[d * L + l] = by_side ? side[l] * a[d * L + l] : constant;
      }
  }
};

void apply_unary(TapeCode code, double n, const auto& on) {
  switch (code) {
    case TapeCode::power:
      return on.unary([=](double x, double& y, double& dx) {
        const double before = whole_power(x, static_cast<int>(n) - 1);
        y = before * x, dx = n * before;
      });
    case TapeCode::real_power:
      return on.unary([=](double x, double& y, double& dx) { y = std::pow(x, n), dx = n * std::pow(x, n - 1.0); });
    case TapeCode::sin:
      return on.unary([](double x, double& y, double& dx) { y = std::sin(x), dx = std::cos(x); });
    case TapeCode::cos:
      return on.unary([](double x, double& y, double& dx) { y = std::cos(x), dx = -std::sin(x); });
    case TapeCode::exp:
      return on.unary([](double x, double& y, double& dx) { y = std::exp(x), dx = y; });
    case TapeCode::log:
      return on.unary([](double x, double& y, double& dx) { y = std::log(x), dx = 1.0 / x; });
    case TapeCode::sqrt:
      return on.unary([](double x, double& y, double& dx) { y = std::sqrt(x), dx = 0.5 / y; });
    case TapeCode::tanh:
      return on.unary([](double x, double& y, double& dx) { y = std::tanh(x), dx = 1.0 - y * y; });
    default:  // negate
      return on.unary([](double x, double& y, double& dx) { y = -x, dx = -1.0; });
  }
}

void apply_binary(TapeCode code, const auto& on) {
  switch (code) {
    case TapeCode::add:
      return on.binary([](double x, double y, double& z, double& dx, double& dy) { z = x + y, dx = dy = 1.0; });
    case TapeCode::subtract:
      return on.binary([](double x, double y, double& z, double& dx, double& dy) { z = x - y, dx = 1.0, dy = -1.0; });
    case TapeCode::multiply:
      return on.binary([](double x, double y, double& z, double& dx, double& dy) { z = x * y, dx = y, dy = x; });
    case TapeCode::divide:
      return on.binary(
          [](double x, double y, double& z, double& dx, double& dy) { z = x / y, dx = 1.0 / y, dy = -z / y; });
    case TapeCode::either:
      return on.binary(
          [](double x, double y, double& z, double& dx, double& dy) { z = x + y - x * y, dx = 1.0 - y, dy = 1.0 - x; });
    default:  // any_power
      return on.binary([](double x, double y, double& z, double& dx, double& dy) {
        z = std::pow(x, y), dx = y * std::pow(x, y - 1.0), dy = z * std::log(x);
      });
  }
}

}  // namespace

Tape::Tape(const std::vector<Tree>& expressions, const std::vector<std::string>& signals, int num_states)
    : num_states_(num_states), num_registers_(static_cast<int>(signals.size())) {
  for (const Tree& tree : expressions) results_.push_back(compile(*tree, signals));
}

int Tape::number(double value) {
  const auto [place, is_new] = numbers_.try_emplace(value, num_registers_);
  if (is_new) ++num_registers_;
  return place->second;
}

int Tape::emit(Code code, int a, int b, double exponent) {
  if ((code == Code::add || code == Code::multiply) && b < a) std::swap(a, b);
  const auto [place, is_new] = known_.try_emplace(Key{code, a, b, exponent}, num_registers_);
  if (is_new) instructions_.push_back({code, num_registers_++, a, b, exponent});
  return place->second;
}

int Tape::switch_of(int g) {
  const auto place = std::find(switches_.begin(), switches_.end(), g);
  if (place != switches_.end()) return static_cast<int>(place - switches_.begin());
  switches_.push_back(g);
  return static_cast<int>(switches_.size()) - 1;
}

int Tape::compile_power(const Node& node, const std::vector<std::string>& signals) {
  constexpr double largest_product = 16.0;  // beyond, std::pow is no slower
  const int base = compile(*node.left, signals);
  const bool negative = node.right->operation == Operation::negate;
  const Node& exponent = negative ? *node.right->left : *node.right;
  if (exponent.operation != Operation::number) return emit(Code::any_power, base, compile(*node.right, signals));
  const double value = negative ? -exponent.value : exponent.value;
  const bool whole = value == std::floor(value) && value >= 1.0 && value <= largest_product;
  return emit(whole ? Code::power : Code::real_power, base, 0, value);
}

int Tape::compile_call(const Node& node, const std::vector<std::string>& signals) {
  const int g = compile(*node.left, signals);
  switch (node.function) {
    case Function::abs:
      return emit(Code::by_side, g, switch_of(g));
    case Function::sgn:
      return emit(Code::side, g, switch_of(g));
    case Function::sin:
      return emit(Code::sin, g);
    case Function::cos:
      return emit(Code::cos, g);
    case Function::exp:
      return emit(Code::exp, g);
    case Function::log:
      return emit(Code::log, g);
    case Function::sqrt:
      return emit(Code::sqrt, g);
    case Function::tanh:
      break;
  }
  return emit(Code::tanh, g);
}

int Tape::compile(const Node& node, const std::vector<std::string>& signals) {
  if (node.operation == Operation::number) return number(node.value);
  if (node.operation == Operation::signal) {
    const auto place = std::find(signals.begin(), signals.end(), node.name);
    if (place == signals.end()) throw std::invalid_argument("state_space: no signal '" + node.name + "'");
    return static_cast<int>(place - signals.begin());
  }
  if (node.operation == Operation::call) return compile_call(node, signals);
  if (node.operation == Operation::power) return compile_power(node, signals);
  const int a = compile(*node.left, signals);
  if (node.operation == Operation::negate) return emit(Code::negate, a);
  const int b = compile(*node.right, signals);
  switch (node.operation) {
    case Operation::add:
      return emit(Code::add, a, b);
    case Operation::subtract:
      return emit(Code::subtract, a, b);
    case Operation::multiply:
    case Operation::logical_and:
      return emit(Code::multiply, a, b);
    case Operation::divide:
      return emit(Code::divide, a, b);
    case Operation::logical_or:
      return emit(Code::either, a, b);
    case Operation::equal:  // on either side of a = b it is not
      return number(0.0);
    case Operation::not_equal:
      return number(1.0);
    default:
      break;
  }
  const int g = emit(Code::subtract, a, b);
  const bool less = node.operation == Operation::less || node.operation == Operation::less_equal;
  return emit(less ? Code::below : Code::above, g, switch_of(g));
}

template <int L>
std::vector<double> Tape::registers() const {
  const auto size = static_cast<std::size_t>(stride() * L);
  std::vector<double> all(static_cast<std::size_t>(num_registers_) * size, 0.0);
  for (const auto& [value, at] : numbers_) std::fill_n(all.begin() + at * stride() * L, L, value);
  for (int i = 0; i < num_states_; ++i) std::fill_n(all.begin() + (i * stride() + 1 + i) * L, L, 1.0);
  return all;
}

template <int L>
void Tape::run(double* registers, const double* sides, Slopes slopes) const {
  const int size = stride() * L;
  for (const Instruction& i : instructions_) {
    const Operands<L> on{registers + i.out * size, registers + i.a * size, registers + i.b * size, count(slopes)};
    if (i.code >= Code::side)
      on.switched(sides + i.b * L, i.code == Code::by_side, i.code == Code::side ? -1.0 : i.code == Code::below,
                  i.code == Code::below ? 0.0 : 1.0);
    else if (i.code >= Code::add)
      apply_binary(i.code, on);
    else
      apply_unary(i.code, i.exponent, on);
  }
}

template std::vector<double> Tape::registers<1>() const;
template std::vector<double> Tape::registers<side_by_side>() const;
template void Tape::run<1>(double*, const double*, Slopes) const;
template void Tape::run<side_by_side>(double*, const double*, Slopes) const;

}  // namespace ident::state_space
