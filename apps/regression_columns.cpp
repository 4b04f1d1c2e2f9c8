#include "apps/regression_columns.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <new>
#include <string>

#include "apps/clipped_training.hpp"
#include "apps/process/interrupt.hpp"
#include "dsp/fault.hpp"
#include "dsp/memory_limit.hpp"
#include "dsp/signals.hpp"
#include "ident/validate/judge.hpp"

namespace apps {
namespace {

/// A fault about terms, with their place in the config before it.
template <class Call>
auto at_place(const std::string& place, Call&& call) {
  try {
    return call();
  } catch (const dsp::Fault& fault) {
    throw dsp::Fault(fault.kind(), fault.name(), place + ": " + fault.what());
  }
}

/// Relative, payload's and base's motion of one order are one identity, relative = payload - base: with its other
/// members among the terms the target explains itself. Without a base the first two are the same signal.
void refuse_identity(const ident::CandidateLibrary& library, const std::string& target, const dsp::Motion& signals,
                     const std::string& place) {
  const dsp::SignalInfo* known = dsp::find_signal(target);
  if (known == nullptr || known->order < 0) return;
  const auto among_terms = [&](const std::string& name) {
    const ident::Expression signal(name);
    return std::any_of(library.terms.begin(), library.terms.end(),
                       [&](const auto& term) { return term.expression.ratio_to(signal).has_value(); });
  };
  std::vector<std::string> others;
  for (const dsp::Body body : {dsp::Body::relative, dsp::Body::payload, dsp::Body::base})
    if (const std::string name(dsp::motion_signal(body, known->order).name);
        name != target && signals.find(name) != nullptr)
      others.push_back(name);
  if (!others.empty() && std::all_of(others.begin(), others.end(), among_terms))
    throw dsp::Fault(
        dsp::FaultKind::usage, "library.target",
        fmt::format("{}: the target {} is {} by definition and would explain itself. Remove {}.", place, target,
                    others.size() == 1 ? "the term " + others.front() + " here, where no base moves,"
                                       : fmt::format("made of the terms {}", fmt::join(others, " and ")),
                    others.size() == 1 ? "it" : "one of them"));
}

}  // namespace

void check_library(const Config& config) {
  dsp::Motion usual;
  for (const dsp::SignalInfo& signal : dsp::signal_table())
    if (signal.role != dsp::Role::other) usual.signals.push_back({std::string(signal.name), "", {}});
  try {
    at_place(config.library_place, [&] { return ident::make_library(config.library, config.fit.target, usual); });
  } catch (const dsp::Fault& fault) {
    if (fault.name() != "term.unknown_name") throw;  // a channel may have that name
  }
}

std::vector<ident::CandidateLibrary> compile_libraries(const Config& config, const std::vector<Input>& inputs) {
  const FitConfig& fit = config.fit;
  std::vector<ident::CandidateLibrary> libraries;
  for (const Input& input : inputs) {
    const dsp::Motion& signals = input.prepared.signals;
    if (signals.find(fit.target) == nullptr) {
      std::string known;
      for (const dsp::Signal& signal : signals.signals) known += (known.empty() ? "" : ", ") + signal.name;
      throw dsp::Fault(dsp::FaultKind::usage, "target.unknown",
                       fmt::format("{}: target: {} has no signal '{}', want one of {}.", fit.place, input.prepared.name,
                                   fit.target, known));
    }
    libraries.push_back(
        at_place(config.library_place, [&] { return ident::make_library(config.library, fit.target, signals); }));
    refuse_identity(libraries.back(), fit.target, signals, config.library_place);
  }
  return libraries;
}

namespace {

/// What a recording takes while it is fitted: signals on the bus and filtered, the column of every term, and some
/// twenty more for regimes, residuals and free runs (measured: 33 + 0.98 a term for seven signals); speeds with their
/// kinks, the signs of switches and a column on its way are four.
double fit_bytes(const dsp::Motion& signals, std::size_t num_terms) {
  const double columns = 2.0 * static_cast<double>(signals.signals.size()) + static_cast<double>(num_terms) + 24.0;
  return sizeof(double) * columns * static_cast<double>(signals.num_samples());
}

}  // namespace

std::vector<ident::Columns> all_columns(const Config& config, const std::vector<Input>& inputs,
                                        const std::vector<ident::CandidateLibrary>& libraries,
                                        std::size_t max_memory_bytes, Console& console) {
  if (max_memory_bytes == 0) max_memory_bytes = dsp::ReadOptions{}.max_memory_bytes;
  for (const ident::Range& range : config.ranges) require_unclipped(range, inputs, config.max_clipped);
  std::vector<ident::Columns> columns;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const dsp::Prepared& prepared = inputs[i].prepared;
    const std::size_t bytes =
        sizeof(double) * static_cast<std::size_t>(prepared.signals.num_samples()) * libraries[i].terms.size();
    console.step(fmt::format("{}: forming {} columns ({:.1f} MB)", prepared.name, libraries[i].terms.size(),
                             1e-6 * static_cast<double>(bytes)));
    dsp::require_memory(prepared.name, fit_bytes(prepared.signals, libraries[i].terms.size()), max_memory_bytes);
    try {
      columns.push_back(ident::form_columns(libraries[i], config.fit.target, prepared, check_interrupted));
      columns.back().regimes = inputs[i].regimes;
      columns.back().power = inputs[i].power;
      columns.back().sensors = ident::sensor_parameters(inputs[i]);
    } catch (const std::bad_alloc&) {
      throw dsp::Fault(dsp::FaultKind::numerics, "memory.exhausted",
                       fmt::format("{}: no memory for {} columns, {:.1f} MB. Use fewer terms or a lower rate.",
                                   prepared.name, libraries[i].terms.size(), 1e-6 * static_cast<double>(bytes)));
    }
  }
  return columns;
}

ident::IdentifyOptions identify_options(const Config& config, const std::vector<Input>& inputs, int num_threads) {
  return {.target = config.fit.target,
          .target_unit = inputs.front().prepared.signals.find(config.fit.target)->unit,
          .methods = config.fit.settings.options_of(config.fit.methods),
          .num_threads = num_threads,
          .poll = check_interrupted};
}

std::vector<ident::RangeResult> identify_ranges(Config& config, std::vector<ident::Columns>& columns,
                                                const ident::CandidateLibrary& library,
                                                const ident::IdentifyOptions& options, Console& console) {
  std::vector<ident::RangeResult> ranges;
  for (ident::Range& range : config.ranges) {
    console.step(fmt::format("range {}: fitting", range.spec.name));
    ranges.push_back(ident::identify(range, columns, library, options));
    range.spec = ranges.back().spec;
    for (const ident::DroppedTerm& term : ranges.back().dropped) {
      const std::string text = fmt::format("range {}: {} is left out: {}", range.spec.name, term.name, term.reason);
      // The constant comes with every polynomial, and behind AC-coupled sensors it says nothing.
      const auto& asked = config.library.terms;
      if (term.name == "1" && std::find(asked.begin(), asked.end(), "1") == asked.end())
        console.note(text);
      else
        console.warning("term.left_out", text);
    }
  }
  ident::judge(ranges);
  return ranges;
}

}  // namespace apps
