#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "ident/bodies/candidates.hpp"

namespace ident {

/// Whether what acts between two bodies acts on both alike: the coefficients of one are -1 / ratio times those of the
/// other, with one mass ratio for all of them.
struct Coupling {
  int lower = 1;                                  ///< and the next body
  std::vector<std::string> terms = {};            ///< in either equation
  std::vector<std::string> on_one_side = {};      ///< of these, kept in one equation only
  double mass_ratio = 0.0, mass_ratio_std = 0.0;  ///< m_(lower + 1) / m_lower of most likelihood; NaN: there is none
  double chi_square = 0.0;                        ///< what that leaves of their differences
  int freedom = 0;                                ///< 0: one term is always so
  double probability = 1.0;                       ///< of more, where it holds
  [[nodiscard]] bool can_be_tested() const { return freedom > 0; }
  [[nodiscard]] bool holds() const { return probability > doubt; }
  static constexpr double doubt = 0.01;
  /// With it imposed on all of `terms`: coefficients of the lower body and their standard deviations.
  Eigen::VectorXd mean = {}, std = {};
};

/// Of each pair of neighbours that anything acts between.
[[nodiscard]] std::vector<Coupling> couplings_of(const BodiesLayout& layout, const std::vector<BodyTerm>& terms,
                                                 const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance);

}  // namespace ident
