#include "apps/page/remedies.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "dsp/names.hpp"
#include "dsp/sensors/sensor_checks.hpp"
#include "dsp/sensors/sensor_problems.hpp"

namespace apps {
namespace {

/// As in the sidecar of this input, or where it should be.
Remedy sensor_remedy(const Input& input, const dsp::SensorProblem& problem, bool corrected) {
  const auto spec = std::find_if(input.channels.begin(), input.channels.end(),
                                 [&](const dsp::ChannelSpec& channel) { return channel.name == problem.channel; });
  const char* doubt = problem.either ? " (or its partner: which of the two is wrong cannot be seen)" : "";
  return {fmt::format("{}{}; {}. In {}:", problem.sentence, doubt,
                      corrected ? "corrected in this run" : "not corrected", input.sidecar),
          {"[[channel]]", "name = " + dsp::toml_quoted(problem.channel),
           dsp::remedy(problem, spec == input.channels.end() ? nullptr : &*spec)}};
}

/// Of all sensor pairs of the inputs; which of them by whether they were corrected.
void add_sensors(const RunResults& results, bool corrected, std::vector<Remedy>& found) {
  for (const Input& input : results.inputs)
    for (const auto* relations : {&input.prepared.relations, &input.prepared.derivatives})
      for (const dsp::SensorRelation& relation : *relations)
        for (const dsp::SensorProblem& problem : dsp::sensor_problems(relation, input.prepared.options.scale))
          if (dsp::is_corrected(input.prepared, relation, problem) == corrected)
            found.push_back(sensor_remedy(input, problem, corrected));
}

std::string quoted_list(const std::vector<std::string>& terms) {
  std::vector<std::string> quoted;
  for (const std::string& term : terms) quoted.push_back(dsp::toml_quoted(term));
  return fmt::format("[{}]", fmt::join(quoted, ", "));
}

/// What the judgement of an equation found, as settings of the config.
void add_cause(const RunResults& results, const ident::JudgedFit& fit, std::vector<Remedy>& found) {
  if (!fit.judgement.cause || fit.judgement.verdict == ident::Verdict::describes) return;
  switch (*fit.judgement.cause) {
    case ident::Cause::missing_input:
    case ident::Cause::switch_variable:
      if (fit.explanation) {
        std::vector<std::string> terms = results.config.library.terms;
        terms.push_back(fit.explanation->what);
        found.push_back({fmt::format("{} explains {:.0f} % of what the equation leaves over. In the config:",
                                     fit.explanation->what, 100.0 * fit.explanation->fraction),
                         {"[library]", "terms = " + quoted_list(terms)}});
      } else {
        found.push_back(
            {"Something drives the motion that is not in the equation: record it, or leave those times out.", {}});
      }
      break;
    case ident::Cause::wide_band:
      found.push_back({fmt::format("Above {:.3g} Hz the target is noise. In the config:", fit.noise.needed_hz),
                       {"[prepare]", fmt::format("cutoff_hz = {:.3g}", fit.noise.needed_hz)}});
      break;
    case ident::Cause::missing_term:
      found.push_back(
          {"What is left over returns with the state, so a term is missing: try a larger library. In the "
           "config:",
           {"[library]", fmt::format("order = {}", results.config.library.order + 2)}});
      break;
    case ident::Cause::noise:
    case ident::Cause::not_found:
      break;
  }
}

bool is_of_sensor_pair(const dsp::Check& check) {
  return check.name.starts_with("sensor.") && check.name != "sensor.relation";
}

}  // namespace

std::vector<Remedy> remedies(const RunResults& results) {
  std::vector<Remedy> found;
  add_sensors(results, false, found);
  if (const ChosenEquation chosen = chosen_equation(results.ranges); chosen.fit != nullptr)
    add_cause(results, *chosen.fit, found);
  for (const Input& input : results.inputs)
    for (const dsp::Check& check : input.prepared.checks)
      if ((check.status == dsp::CheckStatus::warning || check.status == dsp::CheckStatus::failed) &&
          !is_of_sensor_pair(check))
        found.push_back({fmt::format("{}: {}", input.prepared.name, check.message), {}});
  add_sensors(results, true, found);
  return found;
}

}  // namespace apps
