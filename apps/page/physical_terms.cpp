#include "apps/page/physical_terms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>

#include "apps/text/rounded.hpp"
#include "dsp/values/constants.hpp"
#include "ident/library/expression.hpp"

namespace apps {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Function = std::function<double(const VectorXd&)>;

using dsp::nan;

bool is_acceleration(const std::string& name) {
  return name == "a" || name == "ddy";
}

/// At this x, or y, and at rest, switches on these sides, or all on one; NaN where it is not finite.
double at_rest(const ident::Expression& expression, double x, const std::vector<double>& sides) {
  std::vector<double> values;
  for (const std::string& signal : expression.signals()) values.push_back(signal == "x" || signal == "y" ? x : 0.0);
  return expression.evaluate(values.data(), sides.data());
}
double at_rest(const ident::Expression& expression, double x, double side) {
  return at_rest(expression, x, std::vector<double>(expression.switches().size(), side));
}

double finite_at_rest(const ident::Expression& expression, double x) {
  const double value = at_rest(expression, x, 0.0);
  return std::isfinite(value) ? value : 0.0;
}

ident::Expression derivative(ident::Expression expression, const char* signal, int order) {
  for (int i = 0; i < order; ++i) expression = expression.derivative(signal);
  return expression;
}

/// What an equation is made of at rest: each a weighted sum of the coefficients, of the sign it has on the side of the
/// restoring force; `mass` is 1 for an acceleration.
struct Restoring {
  VectorXd force, stiffness, damping, friction, quadratic, cubic;
  std::optional<VectorXd> mass;
  bool is_cubic = true;  ///< in x: k and k3 hold everywhere, and not about this x alone
  [[nodiscard]] double per_mass(const VectorXd& weights, const VectorXd& coefficients) const {
    return weights.dot(coefficients) / (mass ? mass->dot(coefficients) : 1.0);
  }
};

/// The terms of an equation that act between payload and base, by what they are at rest.
class RestoringTerms {
 public:
  RestoringTerms(const ident::Model& model, bool base_at_rest)
      : sign_(is_acceleration(model.target) ? -1.0 : 1.0), num_terms_(std::ssize(model.terms)) {
    bool changes = false;  // with time
    for (Index i = 0; i < num_terms_; ++i) {
      const std::string& name = model.terms[static_cast<std::size_t>(i)].name;
      if (is_acceleration(name) && !is_acceleration(model.target)) mass_ = VectorXd::Unit(num_terms_, i);
      const ident::Expression term(name);
      const auto& signals = term.signals();
      changes = changes || std::find(signals.begin(), signals.end(), "t") != signals.end();
      if (!std::all_of(signals.begin(), signals.end(), [&](const auto& signal) {
            return signal == "x" || signal == "v" || signal == "dy" || (base_at_rest && signal == "y");
          }))
        continue;
      of_y_ = of_y_ || std::find(signals.begin(), signals.end(), "y") != signals.end();
      Term found{i, term};
      for (const std::string& argument : term.switches()) found.arguments.emplace_back(argument);
      for (const char* position : {"x", "y"}) {
        found.stiffness.push_back(derivative(term, position, 1));
        found.quadratic.push_back(derivative(term, position, 2));
        found.cubic.push_back(derivative(term, position, 3));
        found.beyond.push_back(derivative(term, position, 5));
      }
      for (const char* speed : {"v", "dy"})
        if (base_at_rest || speed[0] == 'v') found.damping.push_back(derivative(term, speed, 1));
      terms_.push_back(std::move(found));
    }
    is_motion_ = (is_acceleration(model.target) || mass_) && !changes;
  }
  /// Whether it is an equation of motion, the same at all times.
  [[nodiscard]] bool is_motion() const { return is_motion_; }

  [[nodiscard]] Restoring at(double x) const {
    const VectorXd none = VectorXd::Zero(num_terms_);
    Restoring side{none, none, none, none, none, none, mass_};
    const auto sum = [&](const std::vector<ident::Expression>& all) {
      double value = 0.0;
      for (const ident::Expression& one : all) value += sign_ * finite_at_rest(one, x);
      return value;
    };
    for (const Term& term : terms_) {
      side.force(term.index) = sign_ * finite_at_rest(term.term, x);
      side.stiffness(term.index) = sum(term.stiffness);
      side.quadratic(term.index) = sum(term.quadratic) / 2.0;
      side.cubic(term.index) = sum(term.cubic) / 6.0;
      side.damping(term.index) = sum(term.damping);
      side.is_cubic = side.is_cubic && sum(term.beyond) == 0.0;
      if (!term.term.switches().empty())
        side.friction(term.index) = 0.5 * sign_ * (at_rest(term.term, x, 1.0) - at_rest(term.term, x, -1.0));
    }
    return side;
  }

  /// The restoring force per mass.
  [[nodiscard]] double pull(double x, const VectorXd& coefficients) const {
    double force = 0.0;
    for (const Term& term : terms_) {
      std::vector<double> sides;  // of x, as in sgn(x) x^2; of v there is none at rest
      for (const ident::Expression& argument : term.arguments) {
        const double value = finite_at_rest(argument, x);
        sides.push_back(value > 0.0 ? 1.0 : value < 0.0 ? -1.0 : 0.0);
      }
      const double value = at_rest(term.term, x, sides);
      if (std::isfinite(value)) force += sign_ * value * coefficients(term.index);
    }
    return force / (mass_ ? mass_->dot(coefficients) : 1.0);
  }

  /// Where the restoring force passes zero towards its own side, between two positions; nearest to their middle.
  [[nodiscard]] std::optional<double> balance(const VectorXd& coefficients, double lowest, double highest) const {
    if (of_y_) return 0.0;  // which is x but for a constant
    constexpr int steps = 64, halvings = 60;
    const auto force = [&](double x) { return at(x).force.dot(coefficients); };
    std::optional<double> found;
    const double middle = 0.5 * (lowest + highest), step = (highest - lowest) / steps;
    for (int i = 0; i < steps; ++i) {
      double below = lowest + i * step, above = below + step;
      if (!(force(below) < 0.0 && force(above) >= 0.0)) continue;
      for (int k = 0; k < halvings; ++k) {
        const double between = 0.5 * (below + above);
        (force(between) < 0.0 ? below : above) = between;
      }
      if (!found || std::abs(below - middle) < std::abs(*found - middle)) found = below;
    }
    return found;
  }

 private:
  struct Term {
    Index index;
    ident::Expression term;
    std::vector<ident::Expression> arguments{}, stiffness{}, quadratic{}, cubic{}, beyond{}, damping{};
  };
  double sign_;
  Index num_terms_;
  std::vector<Term> terms_;
  std::optional<VectorXd> mass_;
  bool of_y_ = false, is_motion_ = false;
};

bool has(const VectorXd& weights) {
  return (weights.array() != 0.0).any();
}

using Pull = std::function<double(double)>;  ///< the restoring force per mass at x

/// What the restoring force takes from a to b, by Gauss and Legendre's rule of four points.
double work(const Pull& pull, double a, double b, int pieces = 1) {
  constexpr std::array nodes{0.3399810435848563, 0.8611363115940526}, weights{0.6521451548625461, 0.3478548451374538};
  const double half = 0.5 * (b - a) / pieces;
  double sum = 0.0;
  for (int piece = 0; piece < pieces; ++piece)
    for (std::size_t i = 0; i < nodes.size(); ++i)
      for (const double side : {-1.0, 1.0})
        sum += half * weights[i] * pull(a + (2 * piece + 1 + side * nodes[i]) * half);
  return sum;
}

/// Of free vibration without damping that begins at rest at `from`, from its energy: with the restoring force passing
/// zero at `rest`, T = 2 int dx / sqrt(2 int_x^turn pull). NaN where it does not come back.
double vibration_hz(const Pull& pull, double rest, double from) {
  // The other turning point: as far up the other side.
  constexpr int steps = 32, farthest = 8 * steps, halvings = 50;
  double left = work(pull, rest, from, steps), to = rest;
  for (int i = 0; i < farthest && left > 0.0; ++i) {
    const double next = to - (from - rest) / steps;
    if (const double used = work(pull, to, next); used < left) {
      left -= used;
      to = next;
      continue;
    }
    double below = to, above = next;
    for (int k = 0; k < halvings; ++k) {
      const double between = 0.5 * (below + above);
      (work(pull, to, between) < left ? below : above) = between;
    }
    to = 0.5 * (below + above);
    left = 0.0;
  }
  if (left > 0.0 || to == rest) return nan;
  // Midpoints of an angle between the ends, where the root is zero; from either end, or it would cancel.
  constexpr int points = 64;
  const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
  const auto angle = [&](double i) { return std::numbers::pi * ((i + 0.5) / points - 0.5); };
  double period_s = 0.0;
  for (const double end : {-1.0, 1.0}) {
    double at = middle + end * half, kinetic = 0.0;
    for (int i = 0; i < points / 2; ++i) {
      const double x = middle - end * half * std::sin(angle(i));
      kinetic += work(pull, x, at);
      at = x;
      if (!(kinetic > 0.0)) return nan;
      period_s += 2.0 * std::numbers::pi / points * std::abs(half) * std::cos(angle(i)) / std::sqrt(2.0 * kinetic);
    }
  }
  return 1.0 / period_s;
}

/// One that begins at rest `offset` beside where it rests; `hz` with these coefficients, about where it rests with
/// them.
struct Vibration {
  double offset = 0.0;
  Function hz;
};

/// From the end of the record with less energy: on its other side such a vibration stays in what was recorded. An end
/// that is hardly apart from where it rests, or from which it does not come back, is none. `forces` must outlive it.
std::optional<Vibration> vibration_within(const RestoringTerms& forces, const VectorXd& mean,
                                          const PhysicalContext& context, double rest) {
  constexpr int pieces = 32;
  constexpr double hardly = 0.01;  // of what x spans
  const double lowest = context.lowest, highest = context.highest;
  if (!(highest > lowest)) return std::nullopt;
  // Where it rests with what is constant in it; with other coefficients elsewhere, to first order.
  const double about = forces.balance(mean, lowest, highest).value_or(rest);
  const Restoring there = forces.at(about);
  const double slope = there.per_mass(there.stiffness, mean), none = forces.pull(about, mean);
  const auto hz_from = [&forces, about, slope, none](const VectorXd& c, double offset) {
    const double own = about - (forces.pull(about, c) - none) / slope;
    return vibration_hz([&](double at) { return forces.pull(at, c); }, own, own + offset);
  };
  std::optional<double> offset;
  double least = std::numeric_limits<double>::infinity();
  for (const double end : {lowest, highest}) {
    const double energy = work([&](double at) { return forces.pull(at, mean); }, about, end, pieces);
    if (std::abs(end - about) < hardly * (highest - lowest) || !(energy > 0.0) || energy >= least ||
        !std::isfinite(hz_from(mean, end - about)))
      continue;
    offset = end - about;
    least = energy;
  }
  if (!offset) return std::nullopt;
  return Vibration{*offset, [hz_from, from = *offset](const VectorXd& c) { return hz_from(c, from); }};
}

double hertz(double omega_squared) {
  return std::sqrt(omega_squared) / (2.0 * std::numbers::pi);
}

}  // namespace

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

std::vector<PhysicalTerm> physical_terms(const ident::Model& model, const PhysicalContext& context) {
  const std::string& x_unit = context.x_unit;
  const RestoringTerms all(model, context.base_at_rest);
  if (!all.is_motion() || x_unit.empty()) return {};
  VectorXd mean(std::ssize(model.terms));
  for (Index i = 0; i < mean.size(); ++i) mean(i) = model.terms[static_cast<std::size_t>(i)].mean;
  const bool by_zero = context.lowest <= 0.0 && context.highest >= 0.0;
  const auto rest = by_zero ? std::optional(0.0) : all.balance(mean, context.lowest, context.highest);
  if (!rest) return {};
  const Restoring r = all.at(*rest);
  const bool moved = *rest != 0.0;
  // With other coefficients it rests elsewhere; to first order.
  const auto position = [&](const VectorXd& c) { return *rest - r.force.dot(c) / r.stiffness.dot(c); };
  const auto there = [&](const VectorXd& c) { return moved ? all.at(position(c)) : r; };
  const auto per_mass = [&](VectorXd Restoring::*weights) -> Function {
    return [&, weights](const VectorXd& c) {
      const Restoring side = there(c);
      return side.per_mass(side.*weights, c);
    };
  };
  const Function k = per_mass(&Restoring::stiffness), k2 = per_mass(&Restoring::quadratic),
                 k3 = per_mass(&Restoring::cubic), damping = per_mass(&Restoring::damping);
  // What k3 and a quadratic part together do to the frequency: k2^2 softens to either side.
  const Function hardening = [&](const VectorXd& c) {
    const double quadratic = k2(c);
    return k3(c) - (quadratic == 0.0 ? 0.0 : 10.0 / 9.0 * quadratic * quadratic / k(c));
  };
  std::vector<PhysicalTerm> terms;
  const auto add = [&](const std::string& name, const std::string& unit, const Function& function) {
    if (const double value = function(mean); std::isfinite(value))
      terms.push_back({name, unit, value, propagated_std(function, mean, model.covariance)});
  };
  const bool springs_back = has(r.stiffness) && k(mean) > 0.0;
  if (moved && springs_back) add("rest position", x_unit, position);
  if (springs_back) {
    add(moved ? "natural frequency about it" : "natural frequency", "Hz",
        [&](const VectorXd& c) { return hertz(k(c)); });
    const Function ratio = [&](const VectorXd& c) { return 50.0 * damping(c) / std::sqrt(k(c)); };
    if (has(r.damping)) add(ratio(mean) < 0.0 ? "negative damping ratio" : "damping ratio", "%", ratio);
  } else if (r.is_cubic && has(r.stiffness) && has(r.cubic) && k3(mean) > 0.0) {
    add("rest positions at plus and minus", x_unit, [&](const VectorXd& c) { return std::sqrt(-k(c) / k3(c)); });
    add("natural frequency about them", "Hz", [&](const VectorXd& c) { return hertz(-2.0 * k(c)); });
  }
  const Function friction = [&](const VectorXd& c) { return r.per_mass(r.friction, c); };
  if (has(r.friction))
    add(friction(mean) < 0.0 ? "negative friction force per mass" : "friction force per mass", x_unit + "/s^2",
        friction);
  if (!has(r.cubic) || (!springs_back && !r.is_cubic)) return terms;
  const double bend = springs_back ? hardening(mean) : k3(mean);
  // A positive k3 beside a quadratic part that softens more is neither.
  const char* of_spring = (bend > 0.0) != (k3(mean) > 0.0) ? "k3/m" : bend > 0.0 ? "hardening k3/m" : "softening k3/m";
  add(of_spring, fmt::format("1/({}^2 s^2)", x_unit), k3);
  if (!springs_back) return terms;
  if (const auto found = vibration_within(all, mean, context, *rest))
    add(fmt::format("frequency at {:.3g} {} amplitude", std::abs(found->offset), x_unit), "Hz", found->hz);
  return terms;
}

std::string to_text(const PhysicalTerm& term) {
  return fmt::format("{} {} {}", term.name, with_uncertainty(term.value, term.std), term.unit);
}

}  // namespace apps
