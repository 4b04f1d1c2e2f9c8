#include "apps/page/physical_terms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "apps/page/rounded.hpp"
#include "ident/library/expression.hpp"

namespace apps {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Function = std::function<double(const VectorXd&)>;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

bool is_acceleration(const std::string& name) {
  return name == "a" || name == "ddy";
}

/// At x = 0, v = 0, every switch on this side; NaN where it is not finite.
double at_rest(const ident::Expression& expression, double side) {
  const std::vector<double> values(expression.signals().size(), 0.0), sides(expression.switches().size(), side);
  return expression.evaluate(values.data(), sides.data());
}

double derivative_at_rest(ident::Expression expression, const char* signal, int order) {
  for (int i = 0; i < order; ++i) expression = expression.derivative(signal);
  const double value = at_rest(expression, 0.0);
  return std::isfinite(value) ? value : 0.0;
}

/// What an equation is made of at rest: each a weighted sum of the coefficients, of the sign it has on the side of the
/// restoring force; `mass` is 1 for an acceleration.
struct Restoring {
  VectorXd stiffness, damping, friction, cubic;
  std::optional<VectorXd> mass;
  bool is_cubic = true;  ///< in x: k and k3 hold everywhere, and not about x = 0 alone
  [[nodiscard]] double per_mass(const VectorXd& weights, const VectorXd& coefficients) const {
    return weights.dot(coefficients) / (mass ? mass->dot(coefficients) : 1.0);
  }
};

bool only_of_motion(const ident::Expression& term, bool base_at_rest) {
  return !term.signals().empty() && std::all_of(term.signals().begin(), term.signals().end(), [&](const auto& name) {
    return name == "x" || name == "v" || name == "dy" || (base_at_rest && name == "y");
  });
}

std::optional<Restoring> restoring_side(const ident::Model& model, bool base_at_rest) {
  const Index n = std::ssize(model.terms);
  const double sign = is_acceleration(model.target) ? -1.0 : 1.0;
  Restoring side{VectorXd::Zero(n), VectorXd::Zero(n), VectorXd::Zero(n), VectorXd::Zero(n), {}};
  for (Index i = 0; i < n; ++i) {
    const std::string& name = model.terms[static_cast<std::size_t>(i)].name;
    if (is_acceleration(name) && !is_acceleration(model.target)) side.mass = VectorXd::Unit(n, i);
    const ident::Expression term(name);
    if (!only_of_motion(term, base_at_rest)) continue;
    for (const char* position : {"x", "y"}) {
      side.stiffness(i) += sign * derivative_at_rest(term, position, 1);
      side.cubic(i) += sign * derivative_at_rest(term, position, 3) / 6.0;
      side.is_cubic = side.is_cubic && derivative_at_rest(term, position, 5) == 0.0;
    }
    for (const char* speed : {"v", "dy"})
      if (base_at_rest || speed[0] == 'v') side.damping(i) += sign * derivative_at_rest(term, speed, 1);
    if (!term.switches().empty()) side.friction(i) = 0.5 * sign * (at_rest(term, 1.0) - at_rest(term, -1.0));
  }
  if (!is_acceleration(model.target) && !side.mass) return {};
  return side;
}

bool has(const VectorXd& weights) {
  return (weights.array() != 0.0).any();
}

double hertz(double omega_squared) {
  return std::sqrt(omega_squared) / (2.0 * std::numbers::pi);
}

}  // namespace

MatrixXd si_covariance(const ident::Model& model, const std::vector<ident::AbsoluteGain>& gains) {
  MatrixXd covariance = model.covariance;
  if (covariance.rows() != std::ssize(model.terms) || !covariance.allFinite()) return {};
  for (const ident::AbsoluteGain& gain : gains) {
    VectorXd change = VectorXd::Zero(covariance.rows());
    for (Index i = 0; i < covariance.rows(); ++i) {
      const ident::ModelTerm& term = model.terms[static_cast<std::size_t>(i)];
      for (const auto& [name, exponent] : term.gain_exponents)
        if (name == gain.name && std::isfinite(exponent)) change(i) += gain.std * exponent * term.mean;
    }
    covariance += change * change.transpose();
  }
  return covariance;
}

double propagated_std(const Function& function, const VectorXd& mean, const MatrixXd& covariance) {
  if (covariance.rows() != mean.size() || mean.size() == 0) return nan;
  constexpr double step = 1e-6;
  VectorXd gradient(mean.size());
  for (Index i = 0; i < mean.size(); ++i) {
    const double h = step * std::max(std::abs(mean(i)), std::sqrt(std::max(0.0, covariance(i, i))));
    if (!(h > 0.0)) {
      gradient(i) = 0.0;
      continue;
    }
    VectorXd above = mean, below = mean;
    above(i) += h;
    below(i) -= h;
    gradient(i) = (function(above) - function(below)) / (above(i) - below(i));
  }
  const double variance = gradient.dot(covariance * gradient);
  return variance >= 0.0 ? std::sqrt(variance) : nan;
}

std::vector<PhysicalTerm> physical_terms(const ident::Model& model, const MatrixXd& covariance,
                                         const PhysicalContext& context) {
  const std::string& x_unit = context.x_unit;
  const double amplitude = context.amplitude;
  std::vector<PhysicalTerm> terms;
  const std::optional<Restoring> side = restoring_side(model, context.base_at_rest);
  if (!side || x_unit.empty()) return terms;
  VectorXd mean(std::ssize(model.terms));
  for (Index i = 0; i < mean.size(); ++i) mean(i) = model.terms[static_cast<std::size_t>(i)].mean;
  const auto add = [&](const std::string& name, const std::string& unit, const Function& function) {
    if (const double value = function(mean); std::isfinite(value))
      terms.push_back({name, unit, value, propagated_std(function, mean, covariance)});
  };
  const Restoring& r = *side;
  const auto k = [&r](const VectorXd& c) { return r.per_mass(r.stiffness, c); };
  const auto k3 = [&r](const VectorXd& c) { return r.per_mass(r.cubic, c); };
  const bool springs_back = has(r.stiffness) && k(mean) > 0.0;
  if (springs_back) {
    add("natural frequency", "Hz", [=](const VectorXd& c) { return hertz(k(c)); });
    if (has(r.damping))
      add("damping ratio", "%", [&](const VectorXd& c) { return 50.0 * r.per_mass(r.damping, c) / std::sqrt(k(c)); });
  } else if (r.is_cubic && has(r.stiffness) && has(r.cubic) && k3(mean) > 0.0) {
    add("rest positions at plus and minus", x_unit, [=](const VectorXd& c) { return std::sqrt(-k(c) / k3(c)); });
    add("natural frequency about them", "Hz", [=](const VectorXd& c) { return hertz(-2.0 * k(c)); });
  }
  if (has(r.friction))
    add("friction force per mass", x_unit + "/s^2", [&](const VectorXd& c) { return r.per_mass(r.friction, c); });
  if (!has(r.cubic) || (!springs_back && !r.is_cubic)) return terms;
  add(k3(mean) > 0.0 ? "hardening k3/m" : "softening k3/m", fmt::format("1/({}^2 s^2)", x_unit), k3);
  if (springs_back && amplitude > 0.0)
    add(fmt::format("frequency at {:.3g} {} amplitude", amplitude, x_unit), "Hz",
        [=](const VectorXd& c) { return hertz(k(c) + 0.75 * k3(c) * amplitude * amplitude); });
  return terms;
}

std::string to_text(const PhysicalTerm& term) {
  return fmt::format("{} {} {}", term.name, with_uncertainty(term.value, term.std), term.unit);
}

}  // namespace apps
