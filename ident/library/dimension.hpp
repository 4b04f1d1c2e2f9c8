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
  /// "m/s^2", "1/(m*s)", "N": products and quotients of names with whole powers; rad is a pure number. None as for
  /// times.
  static std::optional<Dimension> of_unit(std::string_view unit);
  [[nodiscard]] std::string unit() const;
  [[nodiscard]] bool is_pure() const { return powers_.empty(); }
  /// This times other^exponent. None where a power would not be whole, or beyond those that units are printed with.
  [[nodiscard]] std::optional<Dimension> times(const Dimension& other, double exponent = 1.0) const;
  bool operator==(const Dimension&) const = default;

 private:
  std::map<std::string, int> powers_;  ///< none is zero
};

/// Dimension of an expression from those of its signals (none: not known), where it follows: numbers are pure, sums are
/// of equals, functions but abs, sgn and sqrt and exponents want pure numbers.
[[nodiscard]] std::optional<Dimension> dimension_of(
    const Node& node, const std::function<std::optional<Dimension>(const std::string&)>& of_signal);

}  // namespace ident
