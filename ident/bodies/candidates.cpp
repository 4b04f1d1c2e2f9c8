#include "ident/bodies/candidates.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "ident/library/library.hpp"

namespace ident {
namespace {

std::string power(const std::string& factor, int exponent) {
  return exponent == 0 ? "" : exponent == 1 ? factor : fmt::format("{}^{}", factor, exponent);
}

std::string product(const std::string& a, const std::string& b) {
  return a.empty() ? b : b.empty() ? a : a + "*" + b;
}

/// Of a rate that may stand in brackets.
std::string sign_of(const std::string& rate) {
  return rate.front() == '(' ? "sgn" + rate : "sgn(" + rate + ")";
}

/// They act as motion of the base against which a body moves.
bool is_motion_of_base(const std::string& input, Frame frame) {
  return input == "r" || input == "dr" || (input == "ddr" && frame != Frame::base);
}

}  // namespace

std::string BodiesLayout::named(char letter, int body) const {
  return num_bodies == 1 ? std::string(1, letter) : fmt::format("{}{}", letter, body);
}
std::string BodiesLayout::target(int equation) const {
  return equation > num_bodies ? "dz" : imposed ? "f" : named('a', equation);
}
std::string BodiesLayout::target_unit(int equation, const std::string& length) const {
  if (imposed) return equation <= num_bodies ? force_unit : force_unit + "/s";
  if (equation <= num_bodies) return length + "/s^2";
  if (inner == Inner::hysteresis || lagging == "ddr") return length + "/s^3";
  return lagging == "f" ? "N/s" : sensor_lags() ? length + "/s" : "";
}
std::string BodiesLayout::position(int body) const {
  return frame == Frame::absolute ? "(" + named('x', body) + " - r)" : named('x', body);
}
std::string BodiesLayout::speed(int body) const {
  return frame == Frame::absolute ? "(" + named('v', body) + " - dr)" : named('v', body);
}
std::string BodiesLayout::stretch(int lower) {
  return fmt::format("(x{} - x{})", lower + 1, lower);
}
std::string BodiesLayout::stretch_rate(int lower) {
  return fmt::format("(v{} - v{})", lower + 1, lower);
}

BodyTerm inner_force() {
  return {1, "z"};
}

double inner_force_coefficient(const BodiesLayout& layout) {
  return layout.imposed ? 1.0 : -1.0;
}

BodyTerm behind_input(const BodiesLayout& layout) {
  return {layout.num_bodies + 1, state_space::lag_term(layout.lagging, "z")};
}

std::vector<BodyTerm> candidates_of(const BodiesLayout& layout, const BodyLibrary& library) {
  std::vector<BodyTerm> candidates;
  for (int body = 1; body <= layout.num_bodies; ++body) {
    const auto add = [&](std::string name) { candidates.push_back({body, std::move(name)}); };
    if (library.order > 0 && library.constant) add("1");
    for (int degree = 1; degree <= library.order; ++degree)
      for (int of_position = degree; of_position >= 0; --of_position)
        add(product(power(layout.position(body), of_position), power(layout.speed(body), degree - of_position)));
    if (library.defaults) {
      add(sign_of(layout.speed(body)));
      for (int lower = std::max(1, body - 1); lower <= std::min(body, layout.num_bodies - 1); ++lower) {
        for (int degree = 1; degree <= std::max(1, library.order); ++degree)
          add(power(BodiesLayout::stretch(lower), degree));
        add(BodiesLayout::stretch_rate(lower));
        add(sign_of(BodiesLayout::stretch_rate(lower)));
      }
      for (const std::string& input : layout.inputs)
        if (!layout.imposed && !is_motion_of_base(input, layout.frame)) add(input == layout.lagging ? "z" : input);
    }
    for (const std::string& term : library.terms)
      add(!layout.lagging.empty() && !layout.sensor_lags() && term == layout.lagging ? "z" : term);
  }
  if (layout.inner == Inner::lag) candidates.push_back(behind_input(layout));
  if (layout.inner != Inner::hysteresis) return candidates;
  const std::string x = layout.position(1), v = layout.speed(1),
                    abs_v = v.front() == '(' ? "abs" + v : "abs(" + v + ")";
  for (const std::string& name :
       {v, "z*" + abs_v, "abs(z)*" + v, "z*abs(z)*" + abs_v, "z^2*" + v, x + "*" + abs_v, std::string("z")})
    candidates.push_back({layout.num_bodies + 1, name});
  return candidates;
}

state_space::Equations equations_of(const BodiesLayout& layout, const std::vector<BodyTerm>& terms,
                                    const std::vector<double>& known) {
  state_space::Equations equations{.states = {}, .inputs = layout.inputs, .terms = {}};
  if (layout.imposed) equations.states.emplace_back("impulse");
  for (int body = 1; body <= layout.num_bodies && !layout.imposed; ++body) {
    equations.states.insert(equations.states.end(), {layout.named('x', body), layout.named('v', body)});
    equations.terms.push_back({.text = equations.states.back(), .state = 2 * body - 2, .known = 1.0});
  }
  if (layout.inner != Inner::none) {
    equations.states.emplace_back("z");
    if (layout.inner == Inner::hysteresis && std::find(terms.begin(), terms.end(), inner_force()) == terms.end())
      equations.terms.push_back(
          {.text = inner_force().name, .state = layout.imposed ? 0 : 1, .known = inner_force_coefficient(layout)});
  }
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const int own = layout.imposed ? terms[i].body - 1 : 2 * terms[i].body - 1;
    state_space::Term term{.text = terms[i].name, .state = std::min(own, layout.num_states() - 1)};
    if (!known.empty()) term.known = known[i];
    equations.terms.push_back(std::move(term));
  }
  return equations;
}

std::string unit_of(const BodyTerm& term, const BodiesLayout& layout, const std::string& length) {
  dsp::Motion signals;
  const auto add = [&](const std::string& name, const std::string& unit) {
    signals.signals.push_back({.name = name, .unit = unit, .values = {}});
  };
  for (int body = 1; body <= layout.num_bodies; ++body)
    add(layout.named('x', body), length), add(layout.named('v', body), length + "/s");
  add("r", length), add("dr", length + "/s"), add("ddr", length + "/s^2"), add("f", "N"), add("t", "s");
  const dsp::Signal* lagging = signals.find(layout.lagging);
  if (layout.inner == Inner::hysteresis) add("z", layout.target_unit(1, length));
  if (lagging != nullptr) add("z", std::string(lagging->unit));
  const Expression expression(term.name);
  const std::vector<std::string>& used = expression.signals();
  if (std::any_of(used.begin(), used.end(), [&](const std::string& name) { return signals.find(name) == nullptr; }))
    return {};
  return coefficient_unit(layout.target_unit(term.body, length), expression.unit(signals));
}

}  // namespace ident
