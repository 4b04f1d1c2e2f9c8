#pragma once
#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "ident/equation/model.hpp"

// What a vibration engineer calls the coefficients of an equation of motion.

namespace apps {

struct PhysicalTerm {
  std::string name, unit;
  double value = 0.0, std = 0.0;  ///< std NaN: not known
};

/// Standard deviation of a function of the coefficients, to first order; NaN where the covariance is empty.
[[nodiscard]] double propagated_std(const std::function<double(const Eigen::VectorXd&)>& function,
                                    const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance);

/// What an equation itself does not say.
struct PhysicalContext {
  double lowest = 0.0, highest = 0.0;  ///< of x
  std::string x_unit;
  bool base_at_rest = false;  ///< y and dy are x and v, but for a constant
};

/// Of an equation for an acceleration (a, ddy), or for a force with that acceleration among its terms, whose mass then
/// divides it. With k, c and k3 the stiffness, damping and cubic stiffness per mass at x = 0, v = 0, from derivatives
/// of the terms in x and v alone: natural frequency sqrt(k) / 2 pi, damping ratio c / (2 sqrt(k)), friction force per
/// mass (half the jump at v = 0), k3, and the frequency of free vibration without damping that begins at rest at that
/// end of the reach of x from which it stays within, by its energy (left out where there is none). Negative k of a
/// force that is a cubic: the rest positions sqrt(-k / k3) and the frequency sqrt(-2 k) / 2 pi about them. Where x does
/// not come by 0, all of that at the position within its reach where the forces of x, and of 1, balance and pull back,
/// which is a term then; nothing where there is none. Damping and friction that feed energy are called negative. What
/// the equation does not have is not there; nothing where x has no unit.
[[nodiscard]] std::vector<PhysicalTerm> physical_terms(const ident::Model& model, const PhysicalContext& context);

/// The same for a terminal or a page: "natural frequency 1.1254(3) Hz".
[[nodiscard]] std::string to_text(const PhysicalTerm& term);

}  // namespace apps
