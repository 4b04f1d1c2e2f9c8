#pragma once
#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "dsp/sensors/motion.hpp"
#include "ident/library/expression_printers.hpp"

namespace ident {

/// Functions allowed in candidate terms and conditions, and what each does, one a line: name, description.
struct FunctionHelp {
  std::string name, meaning;
};
[[nodiscard]] std::vector<FunctionHelp> expression_functions();

struct Switch;

/// A pure function of signals: "x^2*v", "abs(x)*v", "sgn(v)", "abs(v) > 0.004 && t < 10". Immutable; copies share their
/// parts, and threads may share one. Powers are real powers; -x^2 is -(x^2); 2^3^2 is 2^9. sgn must not occur inside
/// another sgn. Signals are known by name; values are in their units, SI throughout this program.
class Expression {
 public:
  /// Reads `text`; its names must be functions or among `signal_names`. Throws dsp::Fault (usage, "term.syntax",
  /// "term.unknown_name", "term.assignment", "term.too_long") naming the position (from 1), what was found and wanted.
  Expression(std::string_view text, const std::vector<std::string>& signal_names);
  /// The same where every name that is no function is a signal.
  explicit Expression(std::string_view text);

  [[nodiscard]] const std::string& text() const&;
  void text() const&& = delete;
  /// The signals it uses, in order of first appearance.
  [[nodiscard]] const std::vector<std::string>& signals() const&;
  void signals() const&& = delete;
  /// One value per sample of `motion`, each at its point; may be non-finite where the expression is. Throws
  /// std::invalid_argument if a signal is missing there.
  [[nodiscard]] Eigen::VectorXd evaluate(const dsp::Motion& motion) const;
  /// On samples [first, first + count).
  [[nodiscard]] Eigen::VectorXd evaluate(const dsp::Motion& motion, Eigen::Index first, Eigen::Index count) const;

  /// The same of columns of `num_rows`: the signals in the order of signals(), then the signs in that of switches().
  [[nodiscard]] Eigen::VectorXd evaluate(const std::vector<const double*>& columns, Eigen::Index num_rows) const;

  /// The g of every sgn(g) in it, as text, in order of first appearance.
  [[nodiscard]] const std::vector<std::string>& switches() const&;
  void switches() const&& = delete;
  /// Pointwise: `values` in the order of signals(), `signs` (+1, -1 or what a sliding mode needs) in that of
  /// switches().
  [[nodiscard]] double evaluate(const double* values, const double* signs) const;

  /// Everything that jumps or has a kink where some g passes zero: sgn(g), abs(g), comparisons; each g once.
  [[nodiscard]] std::vector<Switch> all_switches() const;
  /// Partial derivative with respect to one signal, simplified: of "x^3" "3*x^2". Off the switches: that of abs(g) is
  /// sgn(g) dg, of sgn and comparisons zero. Where sgn is inside abs its text cannot be read back.
  [[nodiscard]] Expression derivative(std::string_view signal) const;
  /// c where this is c times the other, however both are written (order, brackets, numbers folded); nothing if they are
  /// not recognised as such. Factors are not multiplied out. Zero is a multiple of zero alone, c = 1.
  [[nodiscard]] std::optional<double> ratio_to(const Expression& other) const;
  /// How many times wider than that of its signals the band of its values is: its degree as a polynomial; sgn and
  /// comparisons are constant between their switches, other functions taken to their third harmonic.
  [[nodiscard]] double band_factor() const;
  /// SI unit of its values ("m/s^2", "1") where it follows from the units of the signals; else empty.
  [[nodiscard]] std::string unit(const dsp::Motion& signals) const;
  [[nodiscard]] std::string print(Notation notation) const;
  /// As a factor behind a coefficient: in brackets where it would run into it (sums, signs, numbers).
  [[nodiscard]] std::string print_as_factor(Notation notation) const;

 private:
  struct Parts;
  Expression(Tree tree, std::string text);
  std::shared_ptr<const Parts> parts_;
};

/// Terms and their coefficients: a sum.
using WeightedTerms = std::vector<std::pair<Expression, double>>;

enum class SwitchKind { sign, magnitude, comparison };
struct Switch {
  SwitchKind kind;
  Expression argument;  ///< passes zero where it switches: g; a - b of a comparison
};

/// Rows of `motion` on which the condition holds (non-zero and finite).
[[nodiscard]] std::vector<unsigned char> rows_where(const Expression& condition, const dsp::Motion& motion);

}  // namespace ident
