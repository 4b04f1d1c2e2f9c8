#include "apps/page/remedies.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "apps/process/console.hpp"
#include "dsp/prepare/power_check.hpp"
#include "dsp/prepare/sensor_checks.hpp"
#include "dsp/sensors/sensor_problems.hpp"
#include "dsp/values/names.hpp"
#include "dsp/values/signals.hpp"
#include "ident/equation/percent.hpp"
#include "ident/judgement/findings.hpp"
#include "ident/judgement/verdict_rules.hpp"
#include "ident/library/expression.hpp"

namespace apps {
namespace {

/// Keys of a sidecar's [[channel]], each channel once.
using ChannelLines = std::vector<std::pair<std::string, std::vector<std::string>>>;

void add_line(ChannelLines& channels, const std::string& name, const std::string& line) {
  auto channel = std::find_if(channels.begin(), channels.end(), [&](const auto& one) { return one.first == name; });
  if (channel == channels.end()) channel = channels.insert(channels.end(), {name, {}});
  channel->second.push_back(line);
}

/// Of a sidecar that is not there yet the whole, as it names every channel that is to be read.
std::vector<std::string> to_paste(const Input& input, const ChannelLines& channels) {
  const bool is_there = std::any_of(input.files.begin(), input.files.end(),
                                    [&](const auto& file) { return file.filename() == input.sidecar; });
  ChannelLines blocks = channels;
  if (!is_there) {
    blocks.clear();
    for (const dsp::Channel& channel : input.prepared.channels) {
      add_line(blocks, channel.name, "name = " + dsp::toml_quoted(channel.name));
      for (const auto& [name, keys] : channels)
        for (const std::string& key : keys)
          if (name == channel.name) add_line(blocks, name, key);
    }
  }
  std::vector<std::string> lines;
  if (!is_there) lines.push_back("schema = 1");
  for (const auto& [name, keys] : blocks) {
    lines.push_back(is_there ? "[[channel]]  # " + dsp::toml_quoted(name) + ": add or replace" : "[[channel]]");
    lines.insert(lines.end(), keys.begin(), keys.end());
  }
  return lines;
}

/// What calls visit(relation, problem) for every problem of every sensor pair of an input.
template <class Visit>
void for_each_problem(const Input& input, const Visit& visit) {
  for (const auto* relations : {&input.prepared.relations, &input.prepared.derivatives})
    for (const dsp::SensorRelation& relation : *relations)
      for (const dsp::SensorProblem& problem : dsp::sensor_problems(relation, input.prepared.options.scale))
        visit(relation, problem);
}

std::string line_for(const Input& input, const dsp::SensorProblem& problem) {
  const auto spec = std::find_if(input.channels.begin(), input.channels.end(),
                                 [&](const dsp::ChannelSpec& channel) { return channel.name == problem.channel; });
  return dsp::remedy(problem, spec == input.channels.end() ? nullptr : &*spec);
}

void add_uncorrected(const RunResults& results, std::vector<Remedy>& found) {
  for (const Input& input : results.inputs)
    for_each_problem(input, [&](const dsp::SensorRelation& relation, const dsp::SensorProblem& problem) {
      if (dsp::is_corrected(input.prepared, relation, problem)) return;
      const char* doubt =
          problem.either ? " (or of its partner: the record does not show which of the two is wrong)" : "";
      ChannelLines lines;
      add_line(lines, problem.channel, line_for(input, problem));
      const std::vector<std::string> pasted = to_paste(input, lines);
      const auto same =
          std::find_if(found.begin(), found.end(), [&](const Remedy& one) { return one.lines == pasted; });
      if (same != found.end())  // one channel beside several others
        same->why.insert(0, problem.sentence + "; ");
      else
        found.push_back({fmt::format("{}; not corrected. In {}{}:", problem.sentence, input.sidecar, doubt), pasted});
    });
}

/// One for each sidecar.
void add_corrected(const RunResults& results, std::vector<Remedy>& found) {
  for (const Input& input : results.inputs) {
    ChannelLines lines;
    for_each_problem(input, [&](const dsp::SensorRelation& relation, const dsp::SensorProblem& problem) {
      if (dsp::is_corrected(input.prepared, relation, problem))
        add_line(lines, problem.channel, line_for(input, problem));
    });
    if (!lines.empty())
      found.push_back({fmt::format("Optional, as it is corrected in this run: gains, lags and AC couplings that {} "
                                   "does not state were found. To state them there:",
                                   input.sidecar),
                       to_paste(input, lines), true});
  }
}

std::string quoted_list(const std::vector<std::string>& terms) {
  std::vector<std::string> quoted;
  for (const std::string& term : terms) quoted.push_back(dsp::toml_quoted(term));
  return fmt::format("[{}]", fmt::join(quoted, ", "));
}

/// All products of x and v, one degree further than the candidates go now.
std::vector<std::string> larger_library(const Config& config) {
  constexpr double most = 7.0;
  double degree = config.library.order;
  for (const std::string& term : config.library.terms)
    if (const ident::Expression expression(term); expression.switches().empty())
      degree = std::max(degree, std::min(most, expression.band_factor()));
  return {"[library]", fmt::format("order = {:.0f}", std::max(3.0, degree + 1.0))};
}

/// The candidates of the config and these.
std::vector<std::string> with_terms(const Config& config, const std::vector<std::string>& more) {
  std::vector<std::string> terms = config.library.terms;
  terms.insert(terms.end(), more.begin(), more.end());
  return {"[library]", "terms = " + quoted_list(terms)};
}

/// What a turning body adds to the candidates: gravity and the like act by sine and cosine of its angle. Nothing where
/// they are tried, or where x is no angle.
std::vector<std::string> terms_of_angle(const ident::RangeResult& range, const dsp::Motion& signals) {
  const dsp::Signal* x = signals.find("x");
  if (x == nullptr || x->unit != "rad") return {};
  std::vector<std::string> terms{"sin(x)", "cos(x)"};
  std::erase_if(terms, [&](const std::string& term) {
    return std::find(range.terms.begin(), range.terms.end(), term) != range.terms.end();
  });
  return terms;
}

Remedy with_explanation(const Config& config, const ident::Explanation& explanation) {
  const std::string without = explanation.instead_of.empty()
                                  ? std::string()
                                  : fmt::format(" without {}", fmt::join(explanation.instead_of, " and "));
  return {fmt::format("{} explains {:.0f} % of the power of the residual{}. In the config:", explanation.what,
                      100.0 * explanation.fraction, without),
          with_terms(config, explanation.parts.empty() ? std::vector{explanation.what} : explanation.parts)};
}

/// A candidate that was not taken, because noise drowns it: in a narrower band there is less of that.
Remedy with_less_noise(const ident::JudgedFit& fit, const ident::Explanation& candidate) {
  const std::string why = fmt::format(
      "{} is a candidate that was not taken and shows at the frequencies of the motion, under noise", candidate.what);
  if (!ident::has_wide_band(fit.noise)) return {why + ": a longer record, or one with less noise, would tell.", {}};
  return {fmt::format("{}, most of it above {:.3g} Hz. In the config:", why, fit.noise.needed_hz),
          {"[prepare]", fmt::format("cutoff_hz = {:.3g}", fit.noise.needed_hz)}};
}

/// Of the rules that took the verdict down.
void add_rules(const ident::JudgedFit& fit, std::vector<Remedy>& found) {
  for (const ident::VerdictRule* rule : fit.judgement.rules)
    if (!rule->remedy.empty()) found.push_back({std::string(rule->remedy), {}});
}

/// Of an input that drives the motion and is not in the equation.
Remedy of_input(const RunResults& results, const ident::RangeResult& range, const ident::JudgedFit& fit) {
  if (fit.judgement.named) return with_explanation(results.config, *fit.judgement.named);
  const auto untried = inputs_not_tried(range, results.inputs.front().prepared.signals, fit.model.target);
  if (!untried.empty())
    return {fmt::format("An input that drives the motion is not in the equation; {} {} recorded and {} no candidate. "
                        "In the config:",
                        fmt::join(untried, " and "), untried.size() == 1 ? "was" : "were",
                        untried.size() == 1 ? "is" : "are"),
            with_terms(results.config, untried)};
  return {
      "An input that drives the motion is not in the equation: record it, or keep to times without it. If nothing "
      "drives it from outside, it excites itself, and a term is missing.",
      {}};
}

/// Whether one can be looked for with the config as it is: refuse_settings of run_bodies.cpp.
bool may_have_inner(const RunResults& results) {
  const Config& config = results.config;
  return config.test_recordings.empty() && config.fit.target == "a" && config.fit.stage != ident::Stage::regression &&
         std::all_of(config.ranges.begin(), config.ranges.end(),
                     [](const ident::Range& range) { return range.spec.place.empty(); });
}

/// What an inner state is found from.
bool has_displacement(const RunResults& results) {
  const auto& channels = results.inputs.front().prepared.channels;
  return std::any_of(channels.begin(), channels.end(), [](const dsp::Channel& channel) {
    const dsp::SignalInfo& role = dsp::info_of(channel.role);
    return role.order == 0 && (role.body == dsp::Body::relative || role.body == dsp::Body::payload);
  });
}

Remedy of_late_input(const RunResults& results) {
  const std::string why =
      "What drives the motion arrives late, as an actuator that follows its command with a lag of first order";
  if (!has_displacement(results))
    return {why + " would make it: record what arrives, or a displacement, from which a lag is found.", {}};
  if (!may_have_inner(results)) return {why + " would make it: record what arrives.", {}};
  return {why + " would make it. To find whether there is such a lag, set in the config:",
          {"[library]", "inner = \"lag\""}};
}

/// Each channel of the base as that of the payload, and the other way about.
Remedy of_exchanged(const Input& input) {
  ChannelLines lines;
  for (const dsp::Channel& channel : input.prepared.channels) {
    const dsp::SignalInfo& role = dsp::info_of(channel.role);
    if (role.body != dsp::Body::base && role.body != dsp::Body::payload) continue;
    const dsp::Body other = role.body == dsp::Body::base ? dsp::Body::payload : dsp::Body::base;
    add_line(lines, channel.name, fmt::format("role = \"{}\"", dsp::motion_signal(other, role.order).name));
  }
  return {fmt::format("Base and payload may be exchanged. If they are, in {}:", input.sidecar), to_paste(input, lines)};
}

Remedy of_missing_term(const RunResults& results, const ident::JudgedFit& fit) {
  const std::optional<ident::Explanation>& named = fit.judgement.named;
  if (named && !named->is_term) {
    const std::string why = fmt::format(
        "{} explains {} of the residual's power, and no term of x and v can: the force depends on the past. If it can "
        "be measured, give its channel role = \"z\".",
        named->what, ident::percent(named->fraction));
    if (!has_displacement(results) || !may_have_inner(results)) return {why, {}};
    return {why + " To find it unmeasured, set in the config:", {"[library]", "inner = \"hysteresis\""}};
  }
  if (named && named->candidate && named->at_motion) return with_less_noise(fit, *named);
  if (named) return with_explanation(results.config, *named);
  return {
      "The residual repeats whenever the motion returns to the same state, so a term is missing. Try more "
      "candidates; in the config:",
      larger_library(results.config)};
}

/// What the judgement of an equation found, as settings of the config.
void add_cause(const RunResults& results, const ident::RangeResult& range, const ident::JudgedFit& fit,
               std::vector<Remedy>& found) {
  if (!fit.judgement.cause || fit.judgement.verdict == ident::Verdict::describes) return;
  const bool has_name = fit.judgement.named.has_value();
  const ident::Cause cause = *fit.judgement.cause;
  const dsp::Prepared& prepared = results.inputs.front().prepared;
  if (results.config.fit.target == "f" && has_displacement(results) && results.config.test_recordings.empty() &&
      (cause == ident::Cause::missing_term || cause == ident::Cause::not_found)) {
    found.push_back(
        {"A force that x and v alone do not explain may have a memory. To find whether it has one, set in "
         "the config:",
         {"[library]", "inner = \"hysteresis\""}});
    return;
  }
  if ((cause == ident::Cause::missing_term && !has_name) || cause == ident::Cause::not_found)
    if (const auto angle = terms_of_angle(range, prepared.signals); !angle.empty()) {
      found.push_back(
          {fmt::format(
               "x is an angle, and {} {} no candidate: gravity, if it turns with it, acts by them. In the config:",
               fmt::join(angle, " and "), angle.size() == 1 ? "is" : "are"),
           with_terms(results.config, angle)});
      return;
    }
  if (prepared.integrated() && !has_name &&
      (cause == ident::Cause::missing_term || cause == ident::Cause::missing_input || cause == ident::Cause::not_found))
    found.push_back({fmt::format("No displacement was recorded: what of x is slower than {:.3g} Hz is in no power of "
                                 "it, and may be what is left over. Record a displacement.",
                                 prepared.options.integrate_from_hz),
                     {}});
  switch (cause) {
    case ident::Cause::missing_input:
    case ident::Cause::switch_variable:
      found.push_back(of_input(results, range, fit));
      break;
    case ident::Cause::wide_band:
      found.push_back({fmt::format("Above {:.3g} Hz the target is noise. In the config:", fit.noise.needed_hz),
                       {"[prepare]", fmt::format("cutoff_hz = {:.3g}", fit.noise.needed_hz)}});
      break;
    case ident::Cause::missing_term:
      found.push_back(of_missing_term(results, fit));
      break;
    case ident::Cause::late_input:
      found.push_back(of_late_input(results));
      break;
    case ident::Cause::exchanged_roles:
      for (std::size_t i = 0; i < results.inputs.size(); ++i)
        if (range.recording == 0 || range.recording == static_cast<int>(i) + 1)
          found.push_back(of_exchanged(results.inputs[i]));
      break;
    case ident::Cause::imposed_motion:
      if (!has_displacement(results) || !may_have_inner(results)) {
        found.push_back(
            {"If a machine imposes the motion, its force is what an equation is to be for: from a recorded "
             "displacement, without ranges of your own.",
             {}});
        break;
      }
      found.push_back({"If a machine imposes the motion, its force is what an equation is to be for. In the config:",
                       {"[library]", "inner = \"hysteresis\"", "[fit]", "target = \"f\""}});
      break;
    case ident::Cause::noise:
    case ident::Cause::not_found:
      break;
  }
}

/// Said by the lines above, or put right: signals that were out of step as recorded and are in step now.
bool is_said(const dsp::Check& check, const Input& input) {
  if (check.name == "power.balance" && input.power)
    return dsp::largest_balance(*input.power, dsp::RegimeSet::mixed(), &dsp::RegimePower::corrected) <= check.limit;
  return check.name.starts_with("sensor.") && check.name != "sensor.relation";
}

/// What that check proposes: a range whose rows are chosen by the payload's own speed.
bool has_slip_range(const RunResults& results) {
  return std::any_of(results.ranges.begin(), results.ranges.end(), [](const ident::RangeResult& range) {
    const std::string& where = range.spec.where;
    if (where.empty()) return false;
    const ident::Expression condition(where);
    return std::find(condition.signals().begin(), condition.signals().end(), "dy") != condition.signals().end();
  });
}

/// What is to be mended first then, and is said by its check.
bool rests_on_the_ground(const RunResults& results) {
  return std::any_of(results.inputs.begin(), results.inputs.end(), [](const Input& input) {
    return std::any_of(input.prepared.checks.begin(), input.prepared.checks.end(),
                       [](const dsp::Check& check) { return check.name == "regime.ground"; });
  });
}

}  // namespace

bool may_act(const dsp::Signal& signal) {
  return ident::acts_from_outside(signal) || (dsp::find_signal(signal.name) == nullptr && signal.values.size() > 0 &&
                                              signal.values.maxCoeff() > signal.values.minCoeff());
}

std::vector<std::string> inputs_not_tried(const ident::RangeResult& range, const dsp::Motion& signals,
                                          const std::string& target) {
  std::vector<std::string> untried;
  for (const dsp::Signal& signal : signals.signals) {
    if (signal.name == target || !may_act(signal)) continue;
    if (std::none_of(range.terms.begin(), range.terms.end(), [&](const std::string& term) {
          const ident::Expression candidate(term);
          const auto& names = candidate.signals();
          return std::find(names.begin(), names.end(), signal.name) != names.end();
        }))
      untried.push_back(signal.name);
  }
  return untried;
}

std::vector<Remedy> remedies(const RunResults& results) {
  std::vector<Remedy> found;
  add_uncorrected(results, found);
  if (const ChosenEquation chosen = chosen_equation(results.ranges); chosen.fit != nullptr) {
    add_cause(results, *chosen.range, *chosen.fit, found);
    add_rules(*chosen.fit, found);
  } else if (!rests_on_the_ground(results)) {
    const auto untried =
        inputs_not_tried(results.ranges.front(), results.inputs.front().prepared.signals, results.config.fit.target);
    found.push_back({"No candidate explains more than noise does. Try more candidates; in the config:",
                     untried.empty() ? larger_library(results.config) : with_terms(results.config, untried)});
  }
  for (const Input& input : results.inputs)
    for (const dsp::Check& check : input.prepared.checks)
      if ((check.status == dsp::CheckStatus::warning || check.status == dsp::CheckStatus::failed) &&
          !is_said(check, input) && !(check.name == "regime.ground" && has_slip_range(results)))
        found.push_back({fmt::format("{}: {}{}{} [{}]", input.prepared.name, channel_prefix(check),
                                     check.name == "sample.clipped" ? "clipped: " : "", check.message, check.name),
                         {}});
  add_corrected(results, found);
  return found;
}

}  // namespace apps
