#include "apps/config/study_cells.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "apps/config/identification.hpp"
#include "apps/process/interrupt.hpp"
#include "dsp/prepare/motion_band.hpp"
#include "dsp/values/faults.hpp"
#include "dsp/values/names.hpp"
#include "ident/judgement/judge.hpp"

namespace apps {
namespace {

constexpr const char *train_fraction = "fit.train_share", *cutoff = "prepare.cutoff_hz",
                     *rolloff = "prepare.rolloff_hz";

bool has(const StudyCell& cell, const std::string& key) {
  return std::any_of(cell.setting.begin(), cell.setting.end(), [&](const auto& pair) { return pair.first == key; });
}

/// Methods that do not have an axis' setting are left out of its cells.
void keep_concerned(std::vector<ident::Method>& methods, const StudyCell& cell) {
  if (cell.axis < 0) return;
  const std::string& key = cell.setting.front().first;
  const auto concerned = [&](ident::Method method) {
    const auto& settings = ident::description(method).settings;
    return std::any_of(settings.begin(), settings.end(),
                       [&](const auto& setting) { return key == study_key(std::string(setting.name)); });
  };
  if (std::any_of(methods.begin(), methods.end(), concerned))
    std::erase_if(methods, [&](ident::Method method) { return !concerned(method); });
}

/// A training fraction that is varied replaces the time that training ends at.
void leave_train_to(Config& config, const StudyCell& cell) {
  if (has(cell, train_fraction))
    for (ident::Range& range : config.ranges) range.spec.train_to_s.reset();
}

/// A config that the recording can be prepared with.
Config feasible_config(const StudyRequest& request, const StudyCell& cell) {
  std::vector<std::string> overrides;
  for (const auto& [key, value] : cell.setting) {
    overrides.push_back(key + "=" + value);
    if (key != cutoff) continue;
    const dsp::PrepareOptions given = request.config_with({}).prepare;
    if (given.cutoff_hz > 0.0 && given.rolloff_hz > 0.0 && !has(cell, rolloff))
      overrides.push_back(fmt::format("{}={}", rolloff, std::stod(value) * given.rolloff_hz / given.cutoff_hz));
  }
  Config config = request.config_with(overrides);
  leave_train_to(config, cell);
  keep_concerned(config.fit.methods, cell);
  check_library(config);
  (void)dsp::resolved(dsp::rate_by_cutoff(config.prepare, request.sample_rate_hz), request.sample_rate_hz);
  return config;
}

/// Whether a value is one of its setting, but does not go with the others or the recording: only its cell is skipped.
bool is_out_of_range(const dsp::Fault& fault) {
  const std::string& name = fault.name();
  return name == "config.range" || name == "library.too_large" || name.starts_with("prepare.");
}

/// Without the override that nobody typed.
std::string reason_of(const dsp::Fault& fault, const StudyCell& cell) {
  std::string what = fault.what();
  for (const auto& [key, value] : cell.setting)
    if (const std::string place = fmt::format("--set {}={}: ", key, value); what.starts_with(place))
      what.erase(0, place.size());
  return "skipped: " + what;
}

/// Configs with the same key share their prepared signals: all but library, fit and split.
std::string preparation_key(Config config) {
  config.library = {};
  config.fit = {};
  for (ident::Range& range : config.ranges) range.spec.train_to_s.reset();
  return to_toml(config, ".");
}

/// Models and figures only: no columns of a prediction.
StudyRange summary_of(ident::RangeResult result) {
  StudyRange range{result.spec.name, std::move(result.terms), result.rows.train.size(), result.rows.test.size(), {}};
  for (ident::JudgedFit& fit : result.fits) {
    fit.predicted.resize(0);
    fit.predicted_std.resize(0);
    range.fits.push_back(std::move(fit));
  }
  return range;
}

bool keeps_motion(const std::vector<Input>& inputs) {
  return std::none_of(inputs.begin(), inputs.end(), [](const Input& input) {
    const auto& checks = input.prepared.checks;
    return std::any_of(checks.begin(), checks.end(), [](const dsp::Check& check) {
      return check.name == "prepare.band" && check.status == dsp::CheckStatus::warning;
    });
  });
}

}  // namespace

StudyAxis parse_axis(const std::string& text) {
  const std::size_t equals = text.find('=');
  const auto refuse = [&](const std::string& what) {
    throw dsp::Fault(dsp::FaultKind::usage, "study.over",
                     fmt::format("--over {}: {}, want KEY=V1,V2,... as in --over tau=5,10,20", text, what));
  };
  if (equals == std::string::npos || equals == 0) refuse("no key");
  StudyAxis axis{study_key(text.substr(0, equals)), {""}};
  if (axis.key.find('.') == std::string::npos) {
    const std::string near = dsp::nearest(axis.key, study_names());
    refuse(near.empty() ? "no such setting" : fmt::format("no such setting (did you mean {}?)", near));
  }
  int depth = 0;
  bool quoted = false;
  for (const char c : text.substr(equals + 1)) {
    if (c == '"') quoted = !quoted;
    if (!quoted) depth += c == '[' || c == '{' ? 1 : c == ']' || c == '}' ? -1 : 0;
    if (c == ',' && depth == 0 && !quoted)
      axis.values.emplace_back();
    else
      axis.values.back() += c;
  }
  if (std::any_of(axis.values.begin(), axis.values.end(), [](const auto& value) { return value.empty(); }))
    refuse("an empty value");
  return axis;
}

std::vector<StudyAxis> default_axes(const Config& config, double rate_hz, std::int64_t num_samples) {
  std::vector<StudyAxis> axes;
  if (config.library.order > 0) axes.push_back({"library.order", {"1", "2", "3", "4", "5"}});
  for (const ident::MethodSetting& setting : ident::method_settings())
    if (!setting.study_values.empty() &&
        std::any_of(config.fit.methods.begin(), config.fit.methods.end(),
                    [&](ident::Method method) { return ident::description(method).has(setting.name); }))
      axes.push_back(
          {study_key(std::string(setting.name)), {setting.study_values.begin(), setting.study_values.end()}});
  axes.push_back({train_fraction, {"0.15", "0.3", "0.45", "0.6", "0.75"}});
  axes.push_back({cutoff, {}});
  const double cutoff_hz = dsp::resolved(dsp::rate_by_cutoff(config.prepare, rate_hz), rate_hz).cutoff_hz;
  // A decade to either side; where the rate ends before, all of it below.
  constexpr double decade = 10.0, of_rate = 0.4;
  constexpr int per_decade = 3;
  const double asked_hz = config.prepare.rate_hz > 0.0 ? config.prepare.rate_hz : rate_hz;
  const double most_hz = std::max(cutoff_hz, std::min(decade * cutoff_hz, of_rate * asked_hz));
  for (int k = 2 * per_decade; k >= 0; --k) {
    const std::string value = fmt::format("{:.3g}", most_hz * std::pow(decade, -static_cast<double>(k) / per_decade));
    dsp::PrepareOptions options = config.prepare;
    options.cutoff_hz = std::stod(value);
    if (options.rolloff_hz > 0.0) options.rolloff_hz *= options.cutoff_hz / cutoff_hz;
    if (dsp::fewest_samples(dsp::rate_by_cutoff(options, rate_hz), rate_hz) <= num_samples)
      axes.back().values.push_back(value);
  }
  return axes;
}

int best_cutoff(const std::vector<StudyResult>& results) {
  int best = -1;
  std::pair<int, double> best_score;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const StudyResult& result = results[i];
    if (!has(result.cell, cutoff) || !result.keeps_motion || result.ranges.empty()) continue;
    std::pair<int, double> score{ident::preference(ident::Verdict::describes), 0.0};  // of the worst range
    for (const StudyRange& range : result.ranges) {
      if (range.fits.empty()) continue;
      const ident::JudgedFit& fit = range.fits.front();
      const double error = fit.free_run.nmse_centred;
      score.first = std::min(score.first, ident::preference(fit.judgement.verdict));
      score.second = std::min(score.second, std::isfinite(error) ? -error : -HUGE_VAL);
    }
    if (best >= 0 && score <= best_score) continue;
    best = static_cast<int>(i);
    best_score = score;
  }
  return best;
}

std::string StudyCell::label() const {
  std::string text;
  for (const auto& [key, value] : setting) text += (text.empty() ? "" : " ") + key + "=" + value;
  return text.empty() ? "as it is" : text;
}

std::vector<StudyCell> study_cells(const std::vector<StudyAxis>& axes, bool grid) {
  std::vector<StudyCell> cells{{}};
  if (!grid) {
    for (std::size_t a = 0; a < axes.size(); ++a)
      for (const std::string& value : axes[a].values) cells.push_back({static_cast<int>(a), {{axes[a].key, value}}});
    return cells;
  }
  for (const StudyAxis& axis : axes) {
    std::vector<StudyCell> wider;
    for (const StudyCell& cell : cells)
      for (const std::string& value : axis.values) {
        wider.push_back(cell);
        wider.back().setting.emplace_back(axis.key, value);
      }
    cells = std::move(wider);
  }
  return cells;
}

namespace {

/// A cell on its way: its place among the cells and its config.
struct Job {
  std::size_t place = 0;
  Config config;
};

/// What can be run of a study, those of one preparation together. Why others cannot be is their trouble.
std::vector<std::vector<Job>> by_preparation(const StudyRequest& request, std::vector<StudyResult>& results,
                                             dsp::Faults& infeasible) {
  std::vector<std::vector<Job>> groups;
  std::map<std::string, std::size_t> group_of;
  bool varies = false;
  for (const StudyCell& cell : request.cells) {
    results.push_back({.cell = cell});
    try {
      Config config = feasible_config(request, cell);
      const auto [group, is_new] = group_of.emplace(preparation_key(config), groups.size());
      if (is_new) groups.emplace_back();
      groups[group->second].push_back({results.size() - 1, std::move(config)});
      varies = varies || !cell.setting.empty();
    } catch (const dsp::Fault& fault) {
      if (cell.setting.empty() || !is_out_of_range(fault)) throw;
      infeasible.add(fault);
      results.back().trouble = reason_of(fault, cell);
    }
  }
  if (!varies) infeasible.raise();
  return groups;
}

/// What a run with this config says of its ranges. `config` is settled.
std::vector<StudyRange> identify_cell(Config& config, const StudyRequest& request, const std::vector<Input>& inputs,
                                      std::function<void()> poll, Console& console) {
  const auto libraries = compile_libraries(config, inputs);
  auto columns = all_columns(config, inputs, libraries, request.max_memory_bytes, request.num_threads, console);
  ident::IdentifyOptions options = identify_options(config, inputs, request.num_threads);
  options.poll = std::move(poll);
  std::vector<StudyRange> ranges;
  for (ident::RangeResult& range : ident::identify(config.ranges, columns, libraries.front(), options))
    ranges.push_back(summary_of(std::move(range)));
  return ranges;
}

}  // namespace

std::vector<StudyResult> run_cells(const StudyRequest& request, Console& console) {
  std::vector<StudyResult> results;
  dsp::Faults infeasible;
  std::vector<std::vector<Job>> groups = by_preparation(request, results, infeasible);
  Console silent({.verbosity = -1, .progress = ProgressMode::never});
  std::size_t begun = 0;
  const auto poll = shown_poll(
      console, "study", [&] { return static_cast<double>(begun - 1) / static_cast<double>(request.cells.size()); });
  const auto run_group = [&](std::vector<Job>& jobs) {
    const bool is_first = &jobs == &groups.front();  // what is the same for every cell is said once
    std::vector<Input> inputs =
        prepare_inputs(jobs.front().config, request.max_memory_bytes, request.num_threads, is_first ? console : silent);
    for (Job& job : jobs) {
      StudyResult& result = results[job.place];
      console.step(fmt::format("{}/{}: {}", ++begun, request.cells.size(), result.cell.label()));
      const bool is_settled = &job != &jobs.front();
      if (is_settled) job.config.zero.kind = ZeroChoice::Kind::as_it_is;  // it is subtracted
      settle(job.config, inputs, is_first && !is_settled ? console : silent);
      leave_train_to(job.config, result.cell);  // ranges of a sidecar have come in
      refuse_warnings(request.strict, console);
      result.keeps_motion = keeps_motion(inputs);
      try {
        result.ranges = identify_cell(job.config, request, inputs, poll, silent);
      } catch (const dsp::Fault& fault) {
        if (fault.kind() != dsp::FaultKind::numerics) throw;
        result.trouble = fault.what();
      }
    }
  };
  for (std::vector<Job>& jobs : groups) {
    try {
      run_group(jobs);
    } catch (const dsp::Fault& fault) {  // some settings leave nothing to identify from
      if (jobs.front().place == 0 || fault.kind() == dsp::FaultKind::output) throw;
      for (const Job& job : jobs) results[job.place] = {.cell = results[job.place].cell, .trouble = fault.what()};
      infeasible.add(fault);
    }
  }
  if (std::none_of(results.begin(), results.end(), [](const auto& result) { return result.trouble.empty(); }))
    infeasible.raise();
  return results;
}

}  // namespace apps
