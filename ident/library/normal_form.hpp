#pragma once
#include <optional>
#include <string>
#include <vector>

#include "ident/library/expression_tree.hpp"

namespace ident {

/// A sum of products of powers, like terms collected, numbers folded. Equal wherever the tree is finite; factors that
/// are sums are not multiplied out. Order is that of first appearance, for people; comparisons do not depend on it.
class NormalForm {
 public:
  explicit NormalForm(double number);
  static NormalForm signal(const std::string& name);
  static NormalForm of(const Tree& tree);
  static NormalForm call(Function function, const NormalForm& argument);
  static NormalForm power(const NormalForm& base, const NormalForm& exponent);

  friend NormalForm operator+(NormalForm a, const NormalForm& b);
  friend NormalForm operator*(const NormalForm& a, const NormalForm& b);
  friend NormalForm operator*(double factor, NormalForm a);

  /// The number it is, if it is one.
  [[nodiscard]] std::optional<double> number() const;
  [[nodiscard]] Tree tree() const;

  /// The same function is the same scale times the same unit, whatever the order; a unit begins with coefficient 1.
  struct Scaled {
    double scale = 0.0;  ///< 0: it is zero
    std::string unit;
  };
  [[nodiscard]] Scaled scaled() const;

 private:
  /// base^exponent; the base is `scale` times what `key` names.
  struct Factor {
    std::string key;
    double scale = 1.0;
    Tree base;
    double exponent = 1.0;
  };
  struct Term {
    double coefficient = 1.0;
    std::vector<Factor> factors;
    [[nodiscard]] std::string key() const;
    [[nodiscard]] double scale() const;  ///< of the factors together
    void multiply(const Factor& factor);
    [[nodiscard]] Tree tree() const;  ///< with the coefficient's magnitude
  };
  static NormalForm of_factor(Factor factor);
  static NormalForm of_term(const Term& term);
  static NormalForm whole_power(const NormalForm& base, double exponent);
  /// The whole as one factor.
  [[nodiscard]] Factor as_factor() const;
  void add(const Term& term);

  std::vector<Term> terms_;
};

}  // namespace ident
