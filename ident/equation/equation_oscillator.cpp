#include "ident/equation/equation_oscillator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "dsp/values/constants.hpp"
#include "dsp/values/fault.hpp"
#include "ident/equation/equation_of_motion.hpp"

namespace ident {
namespace {

constexpr std::array<const char*, 8> signal_names{"x", "v",  "y",   "dy",
                                                  "r", "dr", "ddr", "f"};  // all that terms may look at

[[noreturn]] void refuse(const IdentifiedEquation& equation, const std::string& why) {
  throw dsp::Fault(dsp::FaultKind::usage, "frc.equation",
                   fmt::format("range {} by {}: {} = ...: {}", equation.range, equation.method, equation.target, why));
}

/// What the terms look at.
struct Contents {
  std::set<std::string, std::less<>> signals, switches;
  [[nodiscard]] bool any_of(std::initializer_list<std::string_view> wanted) const {
    return std::any_of(wanted.begin(), wanted.end(), [&](std::string_view name) { return signals.count(name) > 0; });
  }
};

Contents contents_of(const IdentifiedEquation& equation) {
  Contents contents;
  for (const std::string& term : equation.terms) try {
      const Expression expression(term, {signal_names.begin(), signal_names.end()});
      contents.signals.insert(expression.signals().begin(), expression.signals().end());
      contents.switches.insert(expression.switches().begin(), expression.switches().end());
    } catch (const dsp::Fault&) {
      refuse(equation, fmt::format("the term {} needs more than x, v, y, dy, the base's motion and f: no steady "
                                   "response to a sine follows from it",
                                   term));
    }
  for (const std::string& argument : contents.switches)
    if (argument != "v" && argument != "dy")
      refuse(equation, fmt::format("sgn({}) is a switch on neither v nor dy", argument));
  if (contents.switches.size() > 1 && equation.base_measured)
    refuse(equation, "friction by sgn(v) and by sgn(dy) at once cannot be followed here");
  return contents;
}

/// The equation in x where friction goes by sgn(v), in y where it goes by sgn(dy).
EquationOfMotion equation_of_motion(const IdentifiedEquation& equation, const Eigen::VectorXd& coefficients,
                                    bool absolute) {
  StateEquation row{.state = 1, .terms = {}, .coefficients = {}};
  if (equation.base_measured && absolute != (equation.target == "ddy")) {  // y'' = x'' + r''
    row.terms.push_back("ddr");
    row.coefficients.push_back(absolute ? 1.0 : -1.0);
  }
  row.terms.insert(row.terms.end(), equation.terms.begin(), equation.terms.end());
  row.coefficients.insert(row.coefficients.end(), coefficients.begin(), coefficients.end());
  return {{std::move(row)},
          {.states = absolute ? std::vector<std::string>{"y", "dy"} : std::vector<std::string>{"x", "v"},
           .inputs = {"r", "dr", "ddr", "f"},
           .base_moves = equation.base_measured}};
}

}  // namespace

EquationOscillator equation_oscillator(const IdentifiedEquation& equation, const Eigen::VectorXd& coefficients) {
  if (equation.target != "a" && equation.target != "ddy") refuse(equation, "not an equation of motion of x or y");
  if (equation.terms.empty()) refuse(equation, "no term was selected");
  const Contents contents = contents_of(equation);
  const bool base = equation.base_measured;
  const bool moves_with_base = contents.any_of({"r", "dr", "ddr"}) ||
                               (equation.target == "a" ? contents.any_of({"y", "dy"}) : contents.any_of({"x", "v"}));
  if (base ? !moves_with_base : !contents.any_of({"f"}))
    refuse(equation, base ? "nothing in it moves with the base" : "there is no base and no force f in it");

  const bool absolute = base && contents.switches.count("dy") > 0;  // the coordinate whose speed the switch looks at
  const auto motion = std::make_shared<const EquationOfMotion>(equation_of_motion(equation, coefficients, absolute));
  EquationOscillator result;
  result.drive = base ? DriveKind::base : DriveKind::force;
  result.has_friction = !contents.switches.empty();
  result.oscillator.switches = result.has_friction;
  result.oscillator.x_per_drive = absolute ? -1.0 : 0.0;
  result.oscillator.y_per_drive = base && !absolute ? 1.0 : 0.0;
  // Of each input, which derivative of the drive it is; one that is none is zero.
  const std::array<std::string_view, 3> base_drive{"r", "dr", "ddr"}, force_drive{"f"};
  const auto& drives = base ? base_drive : force_drive;
  std::vector<std::size_t> orders;
  for (const std::string& input : motion->inputs())
    orders.push_back(static_cast<std::size_t>(std::find(drives.begin(), drives.end(), input) - drives.begin()));
  result.oscillator.acceleration = [motion, orders](const sim::DrivenOscillator::Drive& drive, double q, double v,
                                                    double sign) {
    const std::array states{q, v}, sides{sign, sign};  // sgn(v), sgn(dy)
    std::array<double, 4> inputs{};                    // r, dr, ddr, f
    for (std::size_t i = 0; i < orders.size(); ++i)
      if (orders[i] < drive.size()) inputs[i] = drive[orders[i]];
    return motion->acceleration({0.0, states.data(), inputs.data()}, sides.data());
  };
  return result;
}

std::optional<std::pair<double, double>> free_frequencies_hz(const sim::DrivenOscillator& oscillator,
                                                             double largest_x) {
  constexpr int num_amplitudes = 20;
  std::optional<std::pair<double, double>> found;
  const auto add = [&](double stiffness) {
    const double hz = std::sqrt(stiffness) / dsp::two_pi;
    if (!(hz > 0.0) || !std::isfinite(hz)) return;
    found = found ? std::pair(std::min(found->first, hz), std::max(found->second, hz)) : std::pair(hz, hz);
  };
  for (int i = 1; i <= num_amplitudes; ++i) {
    const double place = std::sqrt(0.75) * largest_x * i / num_amplitudes;
    const double pull = oscillator.acceleration({}, -place, 0.0, 0.0) - oscillator.acceleration({}, place, 0.0, 0.0);
    add(pull / (2.0 * place));
  }
  const double step = largest_x / num_amplitudes;
  for (int i = -num_amplitudes; i < num_amplitudes; ++i) {  // where it rests
    const double before = oscillator.acceleration({}, i * step, 0.0, 0.0),
                 behind = oscillator.acceleration({}, (i + 1) * step, 0.0, 0.0);
    if (before >= 0.0 && behind < 0.0) add((before - behind) / step);
  }
  return found;
}

}  // namespace ident
