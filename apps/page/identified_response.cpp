#include "apps/page/identified_response.hpp"

#include <algorithm>
#include <stdexcept>

#include "apps/process/interrupt.hpp"
#include "dsp/values/fault.hpp"
#include "dsp/values/order_statistics.hpp"
#include "ident/equation/equation_oscillator.hpp"
#include "sim/ode/steady_response.hpp"

namespace apps {
namespace {

ident::IdentifiedEquation equation_of(const ChosenEquation& chosen, const dsp::Motion& signals) {
  const ident::Model model = ident::equation_of(chosen.fit->model, 1);
  ident::IdentifiedEquation equation{.target = model.target};
  equation.mean.resize(std::ssize(model.terms));
  for (const ident::ModelTerm& term : model.terms) {
    equation.mean(std::ssize(equation.terms)) = term.mean;
    equation.terms.push_back(term.name);
  }
  equation.base_measured = !base_at_rest(signals);
  return equation;
}

}  // namespace

std::optional<sim::FrequencyResponse> identified_response(const RunResults& results,
                                                          const std::vector<dsp::SteadyStep>& steps) {
  constexpr double num_frequencies = 100.0;
  constexpr int most_periods = 300;  // of one frequency: a picture does not wait for what hardly settles
  const ChosenEquation chosen = chosen_equation(results.ranges);
  std::vector<double> drives, frequencies;
  for (const dsp::SteadyStep& step : steps)
    if (step.tag == dsp::StepTag::final) drives.push_back(step.drive), frequencies.push_back(step.frequency_hz);
  if (chosen.fit == nullptr || chosen.fit->judgement.verdict == ident::Verdict::does_not || frequencies.size() < 3)
    return {};
  const auto [low, high] = std::minmax_element(frequencies.begin(), frequencies.end());
  const sim::FrequencyResponseOptions sweep{.from_hz = *low,
                                            .to_hz = *high,
                                            .step_hz = (*high - *low) / num_frequencies,
                                            .amplitude_m = dsp::median(drives),
                                            .poll = check_interrupted};
  try {
    const ident::IdentifiedEquation equation = equation_of(chosen, results.inputs.front().prepared.signals);
    const auto driven = ident::equation_oscillator(equation, equation.mean);
    return sim::steady_response(driven.oscillator, sweep,
                                {.max_periods = most_periods, .locate_hz = 0.0, .poll = check_interrupted})
        .response;
  } catch (const dsp::Fault&) {             // a sine of base or force does not drive it
  } catch (const std::invalid_argument&) {  // frequencies that make no sweep
  }
  return {};
}

}  // namespace apps
