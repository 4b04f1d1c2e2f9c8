#pragma once
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "ident/library/expression_tree.hpp"

namespace ident {

/// Powers of base units: m/s^2 is {m: 1, s: -2}. A pure number has none.
class Dimension {
 public:
  /// "m/s^2", "1/(m*s)", "N": products and quotients of names with whole powers; rad is a pure number.
  static Dimension of_unit(std::string_view unit);
  [[nodiscard]] std::string unit() const;
  [[nodiscard]] bool is_pure() const { return powers_.empty(); }
  /// None where a power would not be whole.
  [[nodiscard]] std::optional<Dimension> to_power(double exponent) const;
  friend Dimension operator*(Dimension a, const Dimension& b);
  friend Dimension operator/(const Dimension& a, const Dimension& b);
  bool operator==(const Dimension&) const = default;

 private:
  std::map<std::string, int> powers_;  ///< none is zero
};

/// Dimension of an expression from those of its signals (none: not known), where it follows: numbers are pure, sums are
/// of equals, functions but abs, sgn and sqrt and exponents want pure numbers.
[[nodiscard]] std::optional<Dimension> dimension_of(
    const Node& node, const std::function<std::optional<Dimension>(const std::string&)>& of_signal);

}  // namespace ident
