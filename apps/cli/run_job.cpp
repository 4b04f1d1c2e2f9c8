#include "apps/cli/run_job.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "apps/cli/run_bodies.hpp"
#include "apps/config/identification.hpp"
#include "apps/config/other_recording.hpp"
#include "apps/output/equation_file.hpp"
#include "apps/output/factors_file.hpp"
#include "apps/output/fit_outcome.hpp"
#include "apps/output/metrics_file.hpp"
#include "apps/output/prediction.hpp"
#include "apps/output/report_text.hpp"
#include "apps/page/page_files.hpp"
#include "apps/process/beside.hpp"
#include "dsp/values/names.hpp"
#include "dsp/values/signals.hpp"
#include "ident/columns/signals_read.hpp"
#include "ident/identify.hpp"
#include "ident/judgement/findings.hpp"
#include "ident/judgement/judge.hpp"
#include "ident/validate/predict.hpp"

namespace apps {
namespace {

/// 4 and a message where a range has no fit to show.
int exit_code_of(const std::vector<ident::RangeResult>& ranges, Console& console) {
  int code = 0;
  for (const ident::RangeResult& range : ranges)
    code = std::max(code, outcome_of(range.fits, fmt::format("range '{}'", range.spec.name), console));
  return code;
}

/// 4 and a message where the verdict on a range is lower than asked for.
int required_verdicts(const std::vector<ident::RangeResult>& ranges, const std::string& require, Console& console) {
  const auto least = ident::verdict_from_string(require);
  if (!least) return 0;
  int code = 0;
  for (const ident::RangeResult& range : ranges) {
    if (range.fits.empty()) continue;  // said already
    const ident::Verdict verdict = range.fits[ident::chosen_method(range)].judgement.verdict;
    if (ident::preference(verdict) >= ident::preference(*least)) continue;
    console.error(
        "verdict.required",
        fmt::format("range '{}': the verdict is {}, --require {} wants {}", range.spec.name, to_string(verdict),
                    require, *least == ident::Verdict::describes ? "describes" : "in_part or better"));
    code = 4;
  }
  return code;
}

/// The name of the recording with these bytes, of those that were fitted; empty: none has them.
std::string name_of_same(const std::vector<std::vector<ManifestFile>>& fitted, const std::vector<Input>& inputs,
                         const std::string& hash) {
  const auto same =
      std::find_if(fitted.begin(), fitted.end(), [&](const auto& files) { return files.front().sha256 == hash; });
  return same == fitted.end() ? "" : inputs[static_cast<std::size_t>(same - fitted.begin())].prepared.name;
}

/// The chosen equation run free on the recordings that were kept for that: predict-NAME.json and .csv for each.
std::vector<ident::RecordPrediction> predict_test_recordings(
    const Work& work, const std::vector<ident::RangeResult>& ranges,
    const std::vector<std::vector<ManifestFile>>& fitted, const RunArguments& arguments, RunFolder& results,
    HashesBeside& hashes, std::vector<std::filesystem::path>& files, Console& console) {
  const std::optional<ident::ChosenFit> chosen = ident::chosen_fit(ranges);
  std::vector<ident::RecordPrediction> predictions;
  if (!chosen || work.config.test_recordings.empty()) return predictions;
  const ident::RangeResult& range = ranges[chosen->range];
  for (std::size_t i = 0; i < work.config.test_recordings.size(); ++i) {
    const RecordingConfig& recording = work.config.test_recordings[i];
    const Input input =
        other_recording(work.config, recording, arguments.max_memory_bytes, arguments.num_threads, console);
    results.add_files({input}, hashes);
    files.insert(files.end(), input.files.begin(), input.files.end());
    predictions.push_back(
        ident::predict(range.fits[chosen->method].model, range.linear, input,
                       {.fitted_as = name_of_same(fitted, work.inputs, hashes.of(input.files.front())),
                        .where = range.spec.where,
                        .num_threads = arguments.num_threads,
                        .poll = shown_poll(console, "free run")}));
    const std::string name = fmt::format("predict-{}-{}", i + 1, dsp::slug(recording.file.stem().string()));
    results.write(name + ".json", prediction_json(predictions.back()));
    if (work.config.rows) results.write(prediction_table(name + ".csv", predictions.back()), console);
  }
  return predictions;
}

/// What the first screen leaves out.
std::string details_text(const RunResults& found) {
  std::string text = report_text(found.ranges) + findings_text(found.inputs);
  for (const ident::RecordPrediction& prediction : found.predictions) text += prediction_text(prediction);
  return text;
}

/// Names alone: wherever the folder lies, the R factors are the same.
std::vector<std::vector<ident::FactorSource>> sources_of(const std::vector<std::vector<ManifestFile>>& files) {
  std::vector<std::vector<ident::FactorSource>> sources;
  for (const auto& of_one : files) {
    sources.emplace_back();
    for (const ManifestFile& file : of_one)
      sources.back().push_back({std::filesystem::path(file.path).filename().string(), file.sha256});
  }
  return sources;
}

bool base_is_measured(const std::vector<Input>& inputs) {
  const auto signals = dsp::signal_table();
  return std::any_of(signals.begin(), signals.end(), [&](const dsp::SignalInfo& signal) {
    return signal.body == dsp::Body::base && std::any_of(inputs.begin(), inputs.end(), [&](const Input& input) {
             return input.prepared.signals.find(signal.name) != nullptr;
           });
  });
}

/// From a config to what its ranges say.
struct Identified {
  Work work;
  std::vector<ident::CandidateLibrary> libraries;
  std::vector<ident::Columns> columns;
  ident::IdentifyOptions options;
  std::vector<ident::RangeResult> ranges;
  std::vector<RecordingSteps> steps;
  std::optional<ident::BandSplit> split{};  ///< of the whole band, where that was lowered
};

Identified identify_in_band(const Config& config, const RunArguments& arguments, Console& console) {
  Identified found{.work = prepare_work(config, arguments, console)};
  Work& work = found.work;
  found.libraries = compile_libraries(work.config, work.inputs);
  auto steps = beside(arguments.num_threads, [&] { return steady_steps(work.inputs); });
  found.columns = all_columns(work.config, work.inputs, found.libraries, arguments.max_memory_bytes,
                              arguments.num_threads, console);
  for (std::size_t i = 0; i < work.inputs.size(); ++i)
    ident::free_signals_read(work.inputs[i].prepared, found.libraries[i], work.config.fit.target);
  found.options = identify_options(work.config, work.inputs, arguments.num_threads);
  found.options.most_blocks = most_factor_blocks;
  found.ranges = identify_ranges(work.config, found.columns, found.libraries.front(), found.options, console);
  found.steps = steps.get();
  for (ident::Columns& columns : found.columns) columns.phi.resize(0, 0), columns.switches.reset();
  for (Input& input : work.inputs)  // the page shows a spectrum of the target
    std::erase_if(input.prepared.intermediate.signals,
                  [&](const dsp::Signal& signal) { return signal.name != found.options.target; });
  return found;
}

/// Of the equation that speaks for the run; none where it holds in the whole band, or follows the record in none: a
/// part of the band that follows another one makes a term seem missing.
const ident::BandSplit* split_of(const std::vector<ident::RangeResult>& ranges) {
  const std::optional<ident::ChosenFit> chosen = ident::chosen_fit(ranges);
  if (!chosen) return nullptr;
  const ident::JudgedFit& fit = ranges[chosen->range].fits[chosen->method];
  if (fit.by_likelihood && ranges[chosen->range].likelihood.missing) return nullptr;
  const bool lacks_term = fit.judgement.cause == ident::Cause::missing_term &&
                          ident::findings_of(ranges[chosen->range], fit).follows_roughly();
  if (!lacks_term && ident::preference(fit.judgement.verdict) < ident::preference(ident::Verdict::in_part))
    return nullptr;
  const std::optional<ident::BandSplit>& band = fit.band;
  return band && !band->term.empty() ? &*band : nullptr;
}

/// No equation that follows the record, and of its terms none beside x: what else there is may lie under noise that a
/// lower cut-off leaves out, or above the cut-off. Of one closed orbit nothing more is to be found.
bool finds_nothing(const std::vector<ident::RangeResult>& ranges) {
  const auto speaks = [](const ident::RangeResult& range) {
    const ident::JudgedFit& chosen = range.fits[ident::chosen_method(range)];
    const auto& terms = range.fits.front().model.terms;
    return range.orbit || ident::preference(chosen.judgement.verdict) >= ident::preference(ident::Verdict::in_part) ||
           std::any_of(terms.begin(), terms.end(), [](const ident::ModelTerm& term) { return term.name != "x"; });
  };
  return std::none_of(ranges.begin(), ranges.end(),
                      [&](const ident::RangeResult& range) { return !range.fits.empty() && speaks(range); });
}

/// Why the likelihood does not speak in a lower band, by the names of ranges: what it said of the same samples.
std::map<std::string, std::string> reasons_of(const std::vector<ident::RangeResult>& ranges) {
  std::map<std::string, std::string> reasons;
  for (const ident::RangeResult& range : ranges)
    reasons[range.spec.name] = range.likelihood.speaks() ? "one equation does not hold in the whole recorded band"
                                                         : range.likelihood.silent_because;
  return reasons;
}
void tell(const std::map<std::string, std::string>& reasons, std::vector<ident::RangeResult>& ranges) {
  for (ident::RangeResult& range : ranges)
    if (const auto found = reasons.find(range.spec.name); found != reasons.end())
      range.likelihood.silent_because = found->second;
}

/// The same with other cut-offs, an octave apart, until one finds an equation; else `found`.
Identified identify_in_other_bands(Config config, Identified found, const RunArguments& arguments, Console& console) {
  const dsp::PrepareOptions chosen = found.work.inputs.front().prepared.options;
  config.fit.stage = ident::Stage::regression;  // what was recorded is the same
  for (const double octaves : {-1.0, 1.0, -2.0, -3.0}) {
    config.prepare.cutoff_hz = std::stod(fmt::format("{:.3g}", chosen.cutoff_hz * std::exp2(octaves)));
    constexpr double of_rate = 0.4;  // beyond, hardly anything is left out
    if (config.prepare.cutoff_hz >= of_rate * found.work.inputs.front().recorded_rate_hz) continue;
    console.step(
        fmt::format("No equation was found up to {:.3g} Hz. It is identified again with cutoff_hz = {:.3g}; "
                    "[prepare] cutoff_hz sets another",
                    chosen.cutoff_hz, config.prepare.cutoff_hz));
    try {
      Identified other = identify_in_band(config, arguments, console);
      tell(reasons_of(found.ranges), other.ranges);
      if (!finds_nothing(other.ranges)) return other;
    } catch (const dsp::Fault& fault) {  // such as no row left beside longer filters
      if (fault.kind() != dsp::FaultKind::input) throw;
    }
  }
  return found;
}

/// Where the band is left to the choice, what does not follow one equation with the rest is left out of it.
Identified identify_where_one_equation_holds(Config config, const RunArguments& arguments, Console& console) {
  const bool open = config.prepare.rate_hz == 0.0 && config.prepare.cutoff_hz == 0.0;
  // How much lower it holds cannot be seen: what does not follow the equation has had its part in which terms it has.
  const double step = std::exp2(-1.0 / 6.0);
  std::vector<RecordedBand> recorded;
  std::optional<ident::BandSplit> first;
  std::map<std::string, std::string> reasons;
  for (;;) {
    Identified found = identify_in_band(config, arguments, console);
    found.split = first;
    tell(reasons, found.ranges);
    const ident::BandSplit* split = open ? split_of(found.ranges) : nullptr;
    if (split == nullptr)
      return open && finds_nothing(found.ranges) ? identify_in_other_bands(config, std::move(found), arguments, console)
                                                 : std::move(found);
    if (recorded.empty()) recorded = recorded_bands(config, arguments.max_memory_bytes);
    const std::optional<double> cutoff_hz = cutoff_below(step * split->stop_hz, recorded);
    if (!cutoff_hz || *cutoff_hz >= found.work.inputs.front().prepared.options.cutoff_hz) return found;
    if (!first) first = *split, reasons = reasons_of(found.ranges);
    console.step(fmt::format("{}. It is identified again with cutoff_hz = {:.3g}; [prepare] cutoff_hz sets another",
                             to_text(*split), *cutoff_hz));
    config.prepare.cutoff_hz = *cutoff_hz;
    config.fit.stage = ident::Stage::regression;  // the likelihood takes the whole band
  }
}

RunOutcome run_one_body_into(RunFolder& results, const Config& config, const RunArguments& arguments,
                             Console& console) {
  HashesBeside hashes(input_files(config), arguments.num_threads);
  Identified identified = identify_where_one_equation_holds(config, arguments, console);
  auto& [work, libraries, columns, options, ranges, steps, split] = identified;
  const auto files_of = results.add_files(work.inputs, hashes);
  RunOutcome outcome;
  for (const Input& input : work.inputs)
    outcome.files.insert(outcome.files.end(), input.files.begin(), input.files.end());
  const RunResults found{
      work.config,
      work.inputs,
      columns,
      ranges,
      std::move(steps),
      predict_test_recordings(work, ranges, files_of, arguments, results, hashes, outcome.files, console),
      split};
  refuse_warnings(arguments.strict, console);
  const FirstScreen first = first_screen(found);
  outcome.report = to_text(first);
  outcome.equation = equation_json(ranges, base_is_measured(work.inputs));
  results.write("equation.txt", outcome.report);
  results.write("details.txt", details_text(found));
  results.write("equation.tex", report_latex(ranges));
  results.write("equation.json", outcome.equation);
  results.write("metrics.json", metrics_json(ranges, options));
  std::vector<ident::RecordFactors> factors =
      record_factors(ranges, columns, sources_of(files_of), libraries.front(), options);
  for (std::size_t i = 0; i < factors.size(); ++i) {
    const Input& input = work.inputs[static_cast<std::size_t>(std::max(ranges[i].recording, 1) - 1)];
    if (input.zero_is_known) factors[i].stated_zero_m = input.zero;
  }
  results.write(factors_name, factors_json(factors));
  if (work.config.rows) results.write(predictions_table(ranges, columns), console);
  write_page(found, first, arguments.num_threads, results, console);
  outcome.exit_code = std::max(exit_code_of(ranges, console), required_verdicts(ranges, arguments.require, console));
  results.finish(work.config, work.inputs, found.steps, console, outcome.exit_code);
  outcome.config = std::move(work.config);
  return outcome;
}

}  // namespace

RunOutcome run_into(RunFolder& results, const Config& config, const RunArguments& arguments, Console& console) {
  if (config.inner != ident::Inner::none) return run_bodies_into(results, config, arguments, console);
  try {
    return run_one_body_into(results, config, arguments, console);
  } catch (const dsp::Fault& fault) {  // known once the recording is open, which of a large table takes a while
    if (!is_of_bodies(fault)) throw;
  }
  return run_bodies_into(results, config, arguments, console);
}

}  // namespace apps
