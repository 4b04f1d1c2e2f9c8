#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "ident/columns/columns.hpp"
#include "ident/equation/model.hpp"
#include "ident/equation/verdict.hpp"
#include "ident/ranges/ranges.hpp"
#include "ident/regression/fit.hpp"
#include "ident/regression/r_factor.hpp"

namespace ident {

class IndependentRows;

/// What explains more of a residual than chance would once in a thousand, by the partial correlation with it over as
/// many independent rows as the two have together; of each kind the one that explains most.
struct Explanations {
  /// Recorded signals that act on the motion from outside and are not in the model (missing_input; z: missing_term),
  /// and sgn(v) or sgn(dy) where the library has the other and equations of kept terms are better, as of `better`, with
  /// this one in place of it (switch_variable).
  std::optional<Explanation> recorded;
  /// Of what springs, dampers and friction are commonly made of, what is no candidate (missing_term): sgn(v), x and v
  /// with their products up to the third degree, abs(v)*v, a spring in series with a slider (hysteresis), and a
  /// stiffness that follows a clock (modulation_rad_s).
  std::optional<Explanation> form;
  /// One of these forms with which equations of kept terms are better: of all equations of kept terms and it, by the
  /// score of Selection::evidence (ranked_models), the best has it, by odds of 150 for it to belong. Where the best is
  /// without kept terms, these only imitate the form (v^3 and abs(v)*v a friction): instead_of. `fraction`: of what is
  /// left over by the kept terms of the best.
  std::optional<Explanation> better;
  /// A recorded signal, one of these forms or a candidate that was not taken, of which the residual has more at the
  /// frequencies of the motion than noise has of any of them by chance (MotionScore::Score::gain).
  std::optional<Explanation> at_motion;
  /// So it has, or that is in doubt: of that one alone noise has as much once in a hundred.
  bool may_lack_at_motion = false;
};

/// A candidate that was not taken.
struct LeftOut {
  std::string name;
  Eigen::Index column = 0;  ///< its index in the library
};

/// `terms`: the library; `left_out`: of it, beside the model. `kept`: R factor of the model's terms on `rows`, as they
/// are or beside sensors.
[[nodiscard]] Explanations explanations(const Model& model, const std::vector<std::string>& terms,
                                        const std::vector<LeftOut>& left_out, const RFactor& kept,
                                        const std::vector<Row>& rows, const std::vector<Columns>& recordings,
                                        const Eigen::Ref<const Eigen::VectorXd>& residual,
                                        const IndependentRows& independence, const Poll& poll = {});

/// The stiffness that follows a clock alone, as Explanations::form has it.
[[nodiscard]] std::optional<Explanation> swing_of(const Model& model, const std::vector<std::string>& terms,
                                                  const RFactor& kept, const std::vector<Row>& rows,
                                                  const std::vector<Columns>& recordings,
                                                  const Eigen::Ref<const Eigen::VectorXd>& residual,
                                                  const IndependentRows& independence, const Poll& poll = {});

}  // namespace ident
