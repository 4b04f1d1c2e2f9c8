#include "apps/config/identification.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "apps/process/interrupt.hpp"
#include "dsp/io/read_recording.hpp"
#include "dsp/values/faults.hpp"
#include "dsp/values/signals.hpp"
#include "ident/records/clipped_training.hpp"

namespace apps {
namespace {

/// Calls what looks at the library and the target of a config; a fault gets their place in it put before it.
template <class Call>
auto with_places_of(const Config& config, Call&& call) {
  dsp::Faults found, placed;
  std::optional<decltype(call())> result;
  found.attempt([&] { result.emplace(call()); });
  for (const dsp::Fault& fault : found.all()) {
    const std::string& place = fault.name() == "target.unknown" ? config.fit.place : config.library_place;
    placed.add(dsp::Fault(fault.kind(), fault.name(), place + ": " + fault.what()));
  }
  placed.raise();
  return std::move(*result);
}

void report_dropped(const ident::RangeResult& range, const ident::LibraryOptions& library, Console& console) {
  for (const ident::DroppedTerm& term : range.dropped) {
    const std::string text = fmt::format("range {}: {} is left out: {}", range.spec.name, term.name, term.reason);
    // The constant comes with every polynomial, and behind AC-coupled sensors it says nothing.
    if (term.name == "1" && std::find(library.terms.begin(), library.terms.end(), "1") == library.terms.end())
      console.note(text);
    else
      console.warning("term.left_out", text);
  }
}

/// Where the time of a range went: for the log, the only document that differs from one run to the same again.
std::string times_of(const ident::RangeResult& range) {
  std::string text = fmt::format("range {}: {:.3g} s for its matrix", range.spec.name, range.accumulate_s);
  for (const ident::JudgedFit& fit : range.fits)
    text += fmt::format(", {:.3g} s for {}", fit.solve_s, to_string(fit.fit.method));
  return text;
}

}  // namespace

void check_library(const Config& config) {
  dsp::Motion usual;
  for (const dsp::SignalInfo& signal : dsp::signal_table())
    if (signal.role != dsp::Role::other) usual.signals.push_back({std::string(signal.name), "", {}});
  dsp::Faults found, certain;
  found.attempt([&] {
    (void)with_places_of(config, [&] { return ident::make_library(config.library, config.fit.target, usual); });
  });
  for (const ident::Range& range : config.ranges) found.attempt([&] { ident::require_condition(range, usual); });
  for (const dsp::Fault& fault : found.all())
    if (fault.name() != "term.unknown_name") certain.add(fault);  // a channel may have that name
  certain.raise();
}

void name_channels(Config& config, const std::vector<Input>& inputs) {
  using Names = std::pair<std::string, std::string>;  // of a channel, and of its signal
  std::vector<Names> names;
  const auto is_other = [](unsigned char c) { return std::isalnum(c) == 0; };
  for (const Input& input : inputs)
    for (const dsp::Channel& channel : input.prepared.channels) {
      if (channel.name.find(' ') == std::string::npos) continue;  // without a blank it may be an expression
      std::string wanted = channel.name;
      std::replace_if(wanted.begin(), wanted.end(), is_other, '_');
      if (input.prepared.signals.find(wanted) != nullptr) names.emplace_back(channel.name, wanted);
    }
  std::sort(names.begin(), names.end(), [](const Names& a, const Names& b) { return a.first.size() > b.first.size(); });
  for (std::vector<std::string>* terms : {&config.library.terms, &config.library.variables})
    for (std::string& term : *terms)
      for (const auto& [channel, signal] : names)
        for (std::size_t at = 0; (at = term.find(channel, at)) != std::string::npos;)
          term.replace(at, channel.size(), signal);
}

std::vector<ident::CandidateLibrary> compile_libraries(const Config& config, const std::vector<Input>& inputs) {
  if (config.inner != ident::Inner::none)
    throw dsp::Fault(dsp::FaultKind::usage, "config.range",
                     "[library] inner is for ardent run, check and batch alone. Leave it out here, or try ardent run");
  std::vector<ident::CandidateLibrary> libraries;
  dsp::Faults faults;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const dsp::Prepared& prepared = inputs[i].prepared;
    faults.attempt([&] {
      libraries.push_back(
          with_places_of(config, [&] { return ident::record_library(config.library, config.fit.target, prepared); }));
    });
    for (const ident::Range& range : config.ranges)
      if (range.covers(i)) faults.attempt([&] { ident::require_condition(range, prepared.signals); });
  }
  faults.raise();
  return libraries;
}

void require_unclipped(const Config& config, const std::vector<Input>& inputs) {
  for (const ident::Range& range : config.ranges)
    ident::require_unclipped(range, records_of(inputs), config.max_clipped);
}

std::vector<ident::Columns> all_columns(const Config& config, const std::vector<Input>& inputs,
                                        const std::vector<ident::CandidateLibrary>& libraries,
                                        std::size_t max_memory_bytes, int num_threads, Console& console) {
  if (max_memory_bytes == 0) max_memory_bytes = dsp::ReadOptions{}.max_memory_bytes;
  require_unclipped(config, inputs);
  std::vector<ident::Columns> columns;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const std::size_t num_terms = libraries[i].terms.size();
    console.step(fmt::format("{}: forming {} columns ({:.1f} MB)", inputs[i].prepared.name, num_terms,
                             1e-6 * ident::column_bytes(inputs[i].prepared.signals, num_terms)));
    columns.push_back(ident::record_columns(libraries[i], config.fit.target, inputs[i], max_memory_bytes,
                                            shown_poll(console, "forming columns"), num_threads));
  }
  return columns;
}

ident::IdentifyOptions identify_options(const Config& config, const std::vector<Input>& inputs, int num_threads) {
  return {.target = config.fit.target,
          .target_unit = inputs.front().prepared.signals.find(config.fit.target)->unit,
          .methods = config.fit.settings.options_of(config.fit.methods),
          .stage = config.fit.stage,
          .num_threads = num_threads,
          .poll = check_interrupted};
}

std::vector<ident::RangeResult> identify_ranges(Config& config, std::vector<ident::Columns>& columns,
                                                const ident::CandidateLibrary& library, ident::IdentifyOptions options,
                                                Console& console) {
  std::size_t begun = 0;
  options.poll = shown_poll(console, "fitting", [&] {
    return begun < 2 ? std::nan("") : static_cast<double>(begun - 1) / static_cast<double>(config.ranges.size());
  });
  options.before_range = [&](const ident::Range& range) {
    ++begun;
    console.step(fmt::format("range {}: fitting", range.spec.name));
  };
  options.after_range = [&](const ident::RangeResult& range) {
    report_dropped(range, config.library, console);
    console.note(times_of(range));
  };
  std::vector<ident::RangeResult> results = ident::identify(config.ranges, columns, library, options);
  for (std::size_t i = 0; i < results.size(); ++i) config.ranges[i].spec = results[i].spec;
  return results;
}

}  // namespace apps
