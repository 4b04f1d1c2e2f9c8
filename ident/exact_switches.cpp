#include "ident/exact_switches.hpp"

#include <algorithm>
#include <cmath>

#include "dsp/decimate.hpp"
#include "dsp/filter/short_low_pass.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

std::vector<Expression> arguments_of(const CandidateLibrary& library) {
  std::vector<Expression> arguments;
  for (const Term& term : library.terms) {
    const std::vector<Switch> found = term.expression.all_switches();
    for (auto one = found.rbegin(); one != found.rend(); ++one)  // inner ones first
      if (std::none_of(arguments.begin(), arguments.end(),
                       [&](const Expression& known) { return known.text() == one->argument.text(); }))
        arguments.push_back(one->argument);
  }
  return arguments;
}

/// A term's course to one side of a break: value and slope there, by two points of it.
struct Beside {
  double value, slope;
};

}  // namespace

ExactSwitches::ExactSwitches(const dsp::Prepared& prepared, const CandidateLibrary& library)
    : prepared_(prepared),
      crossings_(prepared.intermediate, {prepared.options.state_rolloff_hz, prepared.options.state_cutoff_hz},
                 arguments_of(library)),
      stop_hz_(prepared.filter.stop_hz()) {}

void ExactSwitches::settle(const WeightedTerms& equation) {
  crossings_.settle(equation);
  settled_ = !equation.empty();
}

bool ExactSwitches::depends_on_equation(const Expression& term) const {
  const auto& signals = term.signals();
  return !term.all_switches().empty() ||
         std::any_of(signals.begin(), signals.end(), [&](const auto& name) { return crossings_.restores(name); });
}

Index ExactSwitches::rate_factor(const Expression& term) const {
  constexpr Index most = 8;
  const double rate_hz = prepared_.intermediate.sample_rate_hz;
  // Too short a record for the filter back, whose taps take 8 to 16 periods of its transition.
  if (static_cast<double>(prepared_.intermediate.num_samples()) * (rate_hz - 2.0 * stop_hz_) < 16.0 * rate_hz) return 1;
  const double band_hz = prepared_.options.state_cutoff_hz;
  // Jumps of curvature are not sharpened: at four samples a wave of the band they count for a thousandth.
  const double least_hz =
      std::max(stop_hz_ + term.band_factor() * band_hz, term.all_switches().empty() ? 0.0 : 4.0 * band_hz);
  Index factor = 1;
  while (factor < most && static_cast<double>(factor) * rate_hz < least_hz) factor *= 2;
  return factor;
}

/// Times at which the term jumps or has a kink, in order.
std::vector<double> ExactSwitches::breaks(const Expression& term) const {
  std::vector<std::string> own;
  for (const Switch& one : term.all_switches()) own.push_back(one.argument.text());
  const auto& signals = term.signals();
  const bool has_speed =
      std::any_of(signals.begin(), signals.end(), [&](const auto& name) { return crossings_.restores(name); });
  std::vector<double> times;
  for (std::size_t i = 0; i < crossings_.arguments().size(); ++i) {
    const bool switched = std::find(own.begin(), own.end(), crossings_.arguments()[i].text()) != own.end();
    for (const Crossing& crossing : crossings_.of(i))
      if (switched || (has_speed && crossing.slope_jump != 0.0)) times.push_back(crossing.t_s);
  }
  std::sort(times.begin(), times.end());
  return times;
}

/// Makes of point samples what an anti-alias filter would have made of the course: at each jump and kink the
/// filter's own response to it, less the jump itself.
void ExactSwitches::sharpen(const Expression& term, Index factor, VectorXd& values) const {
  const std::vector<double> times = breaks(term);
  if (times.empty()) return;
  constexpr double attenuation_db = 100.0;  // of what folds: 1e-5 of a column
  const double rate_hz = static_cast<double>(factor) * prepared_.intermediate.sample_rate_hz;
  constexpr double least_transition = 0.02;  // of the rate: where columns go up to half of it, the last of them folds
  const double transition_hz = std::max(rate_hz - 2.0 * stop_hz_, least_transition * rate_hz);
  const dsp::ShortLowPass low_pass(0.5 * rate_hz, transition_hz, attenuation_db, rate_hz);
  const auto reach = static_cast<double>(low_pass.reach());
  const Crossings::Bound bound = crossings_.bind(term);
  const double step_s = 1e-3 / rate_hz;
  const auto side = [&](double t_s, double away_s) {
    const double near = crossings_.value(bound, t_s + away_s), far = crossings_.value(bound, t_s + 2.0 * away_s);
    return Beside{2.0 * near - far, (far - near) / away_s};
  };
  for (std::size_t k = 0; k < times.size();) {
    const double first_s = times[k];
    while (++k < times.size() && times[k] <= first_s + 4.0 * step_s) {
    }
    const double last_s = times[k - 1];  // switches that share a zero are one break
    const Beside before = side(first_s, -step_s), after = side(last_s, step_s);
    const double jump = after.value - before.value, kink = (after.slope - before.slope) / rate_hz;
    if (!std::isfinite(jump) || !std::isfinite(kink)) continue;
    const double at = first_s * rate_hz;
    const auto begin = static_cast<Index>(std::ceil(std::max(0.0, at - reach)));
    const auto end = std::min(static_cast<Index>(at + reach), values.size() - 1);
    for (Index i = begin; i <= end; ++i) {
      const double t = static_cast<double>(i) - at;
      values(i) += jump * (low_pass.switched_on(0, t) - (t >= 0.0 ? 1.0 : 0.0)) +
                   kink * (low_pass.switched_on(1, t) - std::max(0.0, t));
    }
  }
}

VectorXd ExactSwitches::samples(const Expression& term) const {
  const Index factor = rate_factor(term);
  const Index num_rows = prepared_.intermediate.num_samples() * factor;
  std::vector<VectorXd> own;
  own.reserve(term.signals().size() + term.switches().size());
  std::vector<const double*> columns;
  const auto keep = [&](VectorXd values) { columns.push_back(own.emplace_back(std::move(values)).data()); };
  for (const std::string& name : term.signals()) {
    if (factor == 1)
      columns.push_back(crossings_.samples(name).data());
    else
      keep(crossings_.samples(name, factor));
  }
  for (const std::size_t argument : crossings_.bind(term).switches) keep(crossings_.signs(argument, factor));
  VectorXd values = term.evaluate(columns, num_rows);
  for (double& value : values)
    if (!std::isfinite(value)) value = 0.0;
  sharpen(term, factor, values);
  if (factor == 1) return values;
  const double rate_hz = prepared_.intermediate.sample_rate_hz;
  return dsp::decimate(
      values, static_cast<double>(factor) * rate_hz,
      {.output_rate_hz = rate_hz, .passband_end_hz = stop_hz_, .stopband_start_hz = rate_hz - stop_hz_});
}

}  // namespace ident
