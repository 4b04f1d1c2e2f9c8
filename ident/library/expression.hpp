#pragma once
#include <Eigen/Core>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/motion.hpp"

namespace ident {

/// Functions allowed in candidate terms and conditions, and what each does, one a line: name, description.
struct FunctionHelp {
  std::string name, meaning;
};
[[nodiscard]] std::vector<FunctionHelp> expression_functions();

/// How sgn(g) is sampled.
enum class SwitchSampling {
  point,         ///< -1, 0 or 1 at the sample
  cell_average,  ///< mean over the sampling cell, clip(2 g f_s / |dg/dt|, -1, 1), where dg/dt is a known signal: the
                 ///< jump keeps its place between two samples, as the anti-alias filter of the target keeps it
};

/// A pure function of signals, compiled once: "x^2*v", "abs(x)*v", "sgn(v)", "abs(v) > 0.004 && t < 10".
/// Powers are real powers; -x^2 is -(x^2). sgn must not stand inside another sgn.
class Expression {
 public:
  /// Compiles `text` for the given signal names. Throws dsp::Fault (usage, "term.syntax", "term.unknown_name",
  /// "term.assignment", "term.too_long") naming the position, what was found and what is allowed.
  Expression(std::string_view text, const std::vector<std::string>& signal_names);
  ~Expression();
  Expression(Expression&&) noexcept;
  Expression& operator=(Expression&&) noexcept;

  [[nodiscard]] const std::string& text() const;
  /// The signals it uses, in order of first appearance.
  [[nodiscard]] const std::vector<std::string>& signals() const;
  /// One value per sample of `motion`; may be non-finite where the expression is.
  [[nodiscard]] Eigen::VectorXd evaluate(const dsp::Motion& motion,
                                         SwitchSampling sampling = SwitchSampling::cell_average) const;

  /// The g of every sgn(g) in it, as text, in order of first appearance.
  [[nodiscard]] const std::vector<std::string>& switches() const;
  /// Pointwise: `values` in the order of signals(), `signs` (+1, -1 or what a sliding mode needs) in that of
  /// switches().
  [[nodiscard]] double evaluate(const double* values, const double* signs) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Rows of `motion` on which the condition holds (non-zero and finite).
[[nodiscard]] std::vector<unsigned char> rows_where(const Expression& condition, const dsp::Motion& motion);

}  // namespace ident
