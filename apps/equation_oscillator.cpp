#include "apps/equation_oscillator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>

#include "apps/process/printable.hpp"
#include "dsp/fault.hpp"
#include "ident/library/expression.hpp"

namespace apps {
namespace {

// The signals a term may hold, in this order; x and v are relative to the base, y and dy are not.
enum Place { place_x, place_v, place_y, place_dy, place_r, place_dr, place_ddr, place_f, num_places };
constexpr std::array<const char*, num_places> names{"x", "v", "y", "dy", "r", "dr", "ddr", "f"};

struct PlacedTerm {
  ident::Expression expression;
  double coefficient;
  std::vector<std::size_t> places;
};

[[noreturn]] void refuse(const IdentifiedEquation& equation, const std::string& why) {
  throw dsp::Fault(
      dsp::FaultKind::usage, "frc.equation",
      printable(fmt::format("range {} by {}: {} = ...: {}", equation.range, equation.method, equation.target, why)));
}

std::vector<PlacedTerm> placed_terms(const IdentifiedEquation& equation, const Eigen::VectorXd& coefficients) {
  std::vector<PlacedTerm> terms;
  for (std::size_t i = 0; i < equation.terms.size(); ++i) {
    try {
      terms.push_back({ident::Expression(equation.terms[i], {names.begin(), names.end()}),
                       coefficients[static_cast<Eigen::Index>(i)],
                       {}});
    } catch (const dsp::Fault&) {
      refuse(equation, fmt::format("the term {} needs more than x, v, y, dy, the base's motion and f: no steady "
                                   "response to a sine follows from it",
                                   equation.terms[i]));
    }
    for (const std::string& signal : terms.back().expression.signals())
      terms.back().places.push_back(
          static_cast<std::size_t>(std::find(names.begin(), names.end(), signal) - names.begin()));
  }
  return terms;
}

/// What the terms look at.
struct Contents {
  bool relative_switch = false, absolute_switch = false;  ///< sgn(v), sgn(dy)
  std::array<bool, num_places> uses{};
};

Contents contents_of(const IdentifiedEquation& equation, const std::vector<PlacedTerm>& terms) {
  Contents contents;
  for (const PlacedTerm& term : terms) {
    for (const std::size_t place : term.places) contents.uses[place] = true;
    for (const std::string& argument : term.expression.switches()) {
      if (argument != "v" && argument != "dy")
        refuse(equation, fmt::format("sgn({}) is a switch on neither v nor dy", argument));
      (argument == "v" ? contents.relative_switch : contents.absolute_switch) = true;
    }
  }
  if (contents.relative_switch && contents.absolute_switch && equation.base_measured)
    refuse(equation, "friction by sgn(v) and by sgn(dy) at once cannot be followed here");
  return contents;
}

}  // namespace

EquationOscillator equation_oscillator(const IdentifiedEquation& equation, const Eigen::VectorXd& coefficients) {
  if (equation.target != "a" && equation.target != "ddy") refuse(equation, "not an equation of motion of x or y");
  if (equation.terms.empty()) refuse(equation, "no term was selected");
  auto terms = std::make_shared<const std::vector<PlacedTerm>>(placed_terms(equation, coefficients));
  const Contents contents = contents_of(equation, *terms);
  const auto& uses = contents.uses;

  EquationOscillator result;
  const bool base = equation.base_measured;
  result.drive = base ? DriveKind::base : DriveKind::force;
  result.has_friction = contents.relative_switch || contents.absolute_switch;
  const bool moves_with_base =
      uses[place_r] || uses[place_dr] || uses[place_ddr] ||
      (equation.target == "a" ? uses[place_y] || uses[place_dy] : uses[place_x] || uses[place_v]);
  if (base ? !moves_with_base : !uses[place_f])
    refuse(equation, base ? "nothing in it moves with the base" : "there is no base and no force f in it");

  const bool absolute = base && contents.absolute_switch;  // the coordinate whose speed the switch looks at
  const double base_share = !base ? 0.0 : equation.target == "a" ? (absolute ? 1.0 : 0.0) : (absolute ? 0.0 : -1.0);
  result.oscillator.switches = result.has_friction;
  result.oscillator.x_per_drive = absolute ? -1.0 : 0.0;
  result.oscillator.y_per_drive = base && !absolute ? 1.0 : 0.0;
  result.oscillator.acceleration = [terms, base, absolute, base_share, arguments = std::vector<double>(num_places),
                                    signs = std::vector<double>(2)](const sim::DrivenOscillator::Drive& drive, double q,
                                                                    double v, double sign) mutable {
    const double r = base ? drive[0] : 0.0, dr = base ? drive[1] : 0.0, ddr = base ? drive[2] : 0.0;
    const double x = absolute ? q - r : q, dx = absolute ? v - dr : v;
    const std::array<double, num_places> signals{x, dx, x + r, dx + dr, r, dr, ddr, base ? 0.0 : drive[0]};
    std::fill(signs.begin(), signs.end(), sign);
    double sum = base_share * ddr;
    for (const PlacedTerm& term : *terms) {
      for (std::size_t k = 0; k < term.places.size(); ++k) arguments[k] = signals[term.places[k]];
      sum += term.coefficient * term.expression.evaluate(arguments.data(), signs.data());
    }
    return sum;
  };
  return result;
}

}  // namespace apps
