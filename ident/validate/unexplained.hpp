#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "ident/columns.hpp"
#include "ident/fit.hpp"
#include "ident/model.hpp"
#include "ident/r_factor.hpp"
#include "ident/ranges.hpp"
#include "ident/verdict.hpp"

namespace ident {

class IndependentRows;

/// Something recorded that is not in an equation and explains part of what that leaves over.
struct Explanation {
  std::string what;  ///< "f", "sgn(dy)"
  Cause cause = Cause::not_found;
  double fraction = 0.0;  ///< of the residual's power
};

/// The best of: recorded signals that act on the motion from outside and are not in the model (missing_input), and
/// sgn(v) or sgn(dy) where the library (`terms`) has the other (switch_variable), that explains more than chance would
/// once in a thousand: by the partial correlation with the residual over as many independent rows as the two have
/// together. `kept`: R factor of the model's terms on `rows`, as they are or beside sensors.
[[nodiscard]] std::optional<Explanation> explanation(const Model& model, const std::vector<std::string>& terms,
                                                     const RFactor& kept, const std::vector<Row>& rows,
                                                     const std::vector<Columns>& recordings,
                                                     const Eigen::Ref<const Eigen::VectorXd>& residual,
                                                     const IndependentRows& independence, const Poll& poll = {});

}  // namespace ident
