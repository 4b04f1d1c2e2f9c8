#pragma once
#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "ident/library/library.hpp"
#include "ident/regression/fit.hpp"
#include "ident/regression/r_factor.hpp"

namespace ident {

/// A combination of unit-norm columns that is nearly zero: sum of weight_i phi_i / ||phi_i||, of norm `size` for
/// weights of norm 1.
struct NearDependence {
  std::vector<Eigen::Index> terms;  ///< those that carry it, by falling weight
  Eigen::VectorXd weights;          ///< of these terms
  double size = 0.0;
};

struct Collinearity {
  double condition_number = 1.0;  ///< of all non-zero columns at unit norm
  Eigen::VectorXd
      inflation;  ///< b: 1 / (1 - R^2) of each column on all others (no mean removed); infinite if dependent
  std::vector<NearDependence> dependences;  ///< weakest first: singular values below largest / `limit`
  std::vector<Eigen::Index> zero_columns;
};
/// From the singular values of R's unit-norm columns. `limit`: condition index from which a combination is named.
/// Here and below `poll` is called between steps.
[[nodiscard]] Collinearity collinearity(const RFactor& data, double limit = 100.0, const Poll& poll = {});

/// A left-out term that would do nearly as well as a kept one.
struct Rival {
  Eigen::Index kept = 0, other = 0;
  double evidence_lost = 0.0;  ///< 2 dL of the exchange, at fixed noise; small or negative: the data do not decide
};
inline constexpr double undecided_evidence = 10.0;  ///< of 2 log evidence: odds of 150
/// Exchanges that cost less than `limit` of 2 log evidence. Fits without a noise estimate have none.
[[nodiscard]] std::vector<Rival> rivals(const RFactor& data, const Fit& fit, double limit = undecided_evidence,
                                        const Poll& poll = {});

/// What a person should know of the library and the fit, one sentence each: "x and sin(x) cannot be distinguished here:
/// largest |x| 0.11", "x lies 300 of its standard deviations from zero: subtract its mean", equal and zero columns by
/// name, combinations with a kept term in them that one part in a thousand sets apart from zero.
/// `terms`: of the columns of `data`, to which fit.relevant refers. `largest`: greatest magnitude of each signal.
[[nodiscard]] std::vector<std::string> collinearity_remarks(const RFactor& data, const Fit& fit,
                                                            const std::vector<const Term*>& terms,
                                                            const std::vector<std::pair<std::string, double>>& largest,
                                                            const Poll& poll = {});

}  // namespace ident
