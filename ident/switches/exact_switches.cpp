#include "ident/switches/exact_switches.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "dsp/filter/decimate.hpp"

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

std::vector<std::string> signals_of(const CandidateLibrary& library) {
  std::vector<std::string> signals;
  const auto add = [&](const Expression& expression) {
    signals.insert(signals.end(), expression.signals().begin(), expression.signals().end());
  };
  for (const Term& term : library.terms) add(term.expression);
  for (const Expression& argument : arguments_of(library)) add(argument);
  return signals;
}

/// A term's course to one side of a break: value and slope there, by two points of it.
struct Beside {
  double value, slope;
};

}  // namespace

ExactSwitches::ExactSwitches(const dsp::Prepared& prepared, const CandidateLibrary& library)
    : prepared_(prepared),
      crossings_(prepared.intermediate, {prepared.options.state_rolloff_hz, prepared.options.state_cutoff_hz},
                 arguments_of(library), signals_of(library)),
      stop_hz_(prepared.filter.stop_hz()) {}

void ExactSwitches::settle(const WeightedTerms& equation) {
  crossings_.settle(equation);
  has_equation_ = !equation.empty();
  formed_ = wanted_;
}

bool ExactSwitches::must_form(const WeightedTerms& equation) const {
  const bool holds_wanted = formed_.from_s <= wanted_.from_s && wanted_.to_s <= formed_.to_s;
  return !equation.empty() || has_equation_ || !holds_wanted;
}

void ExactSwitches::limit_to(const dsp::Stretch& wanted) {
  wanted_ = wanted;
  // What the state band took away is restored from the course up to so many periods of its flank.
  constexpr double flank_periods = 50.0;
  const double flank_hz = prepared_.options.state_cutoff_hz - prepared_.options.state_rolloff_hz;
  crossings_.limit_to(dsp::input_interval(prepared_, wanted).wider(flank_periods / flank_hz));
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
void ExactSwitches::sharpen(const Crossings::Bound& bound, const std::vector<double>& times,
                            const dsp::ShortLowPass& low_pass, double rate_hz, Index first, VectorXd& values) const {
  const auto reach = static_cast<double>(low_pass.reach()), begin_s = static_cast<double>(first) - reach,
             end_s = static_cast<double>(first + values.size()) + reach;
  const double step_s = 1e-3 / rate_hz;
  const auto side = [&](double t_s, double away_s) {
    const double near = crossings_.value(bound, t_s + away_s), far = crossings_.value(bound, t_s + 2.0 * away_s);
    return Beside{2.0 * near - far, (far - near) / away_s};
  };
  for (std::size_t k = 0; k < times.size();) {
    const double first_s = times[k];
    while (++k < times.size() && times[k] <= first_s + 4.0 * step_s) {
    }
    if (first_s * rate_hz < begin_s) continue;
    if (first_s * rate_hz > end_s) break;
    const double last_s = times[k - 1];  // switches that share a zero are one break
    const Beside before = side(first_s, -step_s), after = side(last_s, step_s);
    const double jump = after.value - before.value, kink = (after.slope - before.slope) / rate_hz;
    if (!std::isfinite(jump) || !std::isfinite(kink)) continue;
    const double at = first_s * rate_hz;
    const auto begin = std::max(first, static_cast<Index>(std::ceil(std::max(0.0, at - reach))));
    const auto end = std::min(static_cast<Index>(at + reach), first + values.size() - 1);
    for (Index i = begin; i <= end; ++i) {
      const double t = static_cast<double>(i) - at;
      values(i - first) += jump * (low_pass.switched_on(0, t) - (t >= 0.0 ? 1.0 : 0.0)) +
                           kink * (low_pass.switched_on(1, t) - std::max(0.0, t));
    }
  }
}

VectorXd ExactSwitches::acting(VectorXd samples) const {
  if (acting_.size() > 0) samples.array() *= acting_.array();
  return samples;
}

VectorXd ExactSwitches::samples(const Expression& term) const {
  const Index factor = rate_factor(term), num_rows = prepared_.intermediate.num_samples();
  const double base_hz = prepared_.intermediate.sample_rate_hz, rate_hz = static_cast<double>(factor) * base_hz;
  const Crossings::Bound bound = crossings_.bind(term);
  const std::vector<double> times = breaks(term);
  constexpr double attenuation_db = 100.0;   // of what folds: 1e-5 of a column
  constexpr double least_transition = 0.02;  // of the rate: where columns go up to half of it, the last of them folds
  const double transition_hz = std::max(rate_hz - 2.0 * stop_hz_, least_transition * rate_hz);
  const dsp::ShortLowPass low_pass(0.5 * rate_hz, transition_hz, attenuation_db, rate_hz);
  std::optional<dsp::Decimator> decimator;
  if (factor > 1)
    decimator.emplace(
        rate_hz, 1,
        dsp::DecimateOptions{
            .output_rate_hz = base_hz, .passband_end_hz = stop_hz_, .stopband_start_hz = base_hz - stop_hz_});

  const dsp::Stretch input_interval =
      dsp::input_interval(prepared_, wanted_).wider(decimator ? decimator->sheet().edge_s : 0.0);
  VectorXd result(num_rows);
  Index done = 0;
  const auto keep = [&](const Eigen::Ref<const VectorXd>& values) {
    result.segment(done, values.size()) = values;
    done += values.size();
  };
  constexpr Index block_rows = 16384;
  for (Index first = 0; first < num_rows * factor; first += block_rows) {
    const Index count = std::min(block_rows, num_rows * factor - first);
    if (static_cast<double>(first + count) <= input_interval.from_s * rate_hz ||
        static_cast<double>(first) > input_interval.to_s * rate_hz) {
      const VectorXd unwanted = VectorXd::Zero(count);
      keep(decimator ? VectorXd(decimator->push(unwanted)) : unwanted);
      continue;
    }
    std::vector<VectorXd> own;
    for (const std::string& name : term.signals()) own.push_back(crossings_.samples(name, factor, first, count));
    for (const std::size_t argument : bound.switches) own.push_back(crossings_.signs(argument, factor, first, count));
    std::vector<const double*> columns;
    for (const VectorXd& values : own) columns.push_back(values.data());
    VectorXd values = term.evaluate(columns, count);
    for (double& value : values)
      if (!std::isfinite(value)) value = 0.0;
    sharpen(bound, times, low_pass, rate_hz, first, values);
    keep(decimator ? VectorXd(decimator->push(values)) : values);
  }
  if (decimator) keep(VectorXd(decimator->finish()));
  return acting(std::move(result));
}

}  // namespace ident
