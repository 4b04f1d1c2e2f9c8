#include "apps/config/study_cells.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "apps/config/identification.hpp"
#include "apps/process/interrupt.hpp"
#include "dsp/faults.hpp"
#include "dsp/names.hpp"
#include "dsp/prepare/motion_band.hpp"
#include "ident/validate/judge.hpp"

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

Config config_of(const StudyRequest& request, const StudyCell& cell) {
  std::vector<std::string> overrides = request.set;
  for (const auto& [key, value] : cell.setting) {
    overrides.push_back(key + "=" + value);
    if (key != cutoff) continue;
    const dsp::PrepareOptions given = read_config(request.input, request.set).prepare;
    if (given.cutoff_hz > 0.0 && given.rolloff_hz > 0.0 && !has(cell, rolloff))
      overrides.push_back(fmt::format("{}={}", rolloff, std::stod(value) * given.rolloff_hz / given.cutoff_hz));
  }
  Config config = read_config(request.input, overrides);
  if (request.adjust) request.adjust(config);
  if (has(cell, train_fraction))
    for (ident::Range& range : config.ranges) range.spec.train_to_s.reset();
  keep_concerned(config.fit.methods, cell);
  check_library(config);
  return config;
}

/// A config that the recording can be prepared with.
Config feasible_config(const StudyRequest& request, const StudyCell& cell) {
  Config config = config_of(request, cell);
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

/// A cell on its way: its place among the cells and its config.
struct Job {
  std::size_t place = 0;
  Config config;
};

/// What a settled config asks of its recordings.
ident::StudyCase case_of(Config& config, const StudyCell& cell, const std::vector<Input>& inputs, int num_threads) {
  if (has(cell, train_fraction))  // ranges of a sidecar have come in
    for (ident::Range& range : config.ranges) range.spec.train_to_s.reset();
  (void)compile_libraries(config, inputs);  // what is wrong with one is said with its place
  return {config.library, config.ranges, identify_options(config, inputs, num_threads)};
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
    for (const ident::StudyRange& range : result.ranges) {
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

/// What can be run of a study, in the order of its cells.
struct StudyPlan {
  std::vector<StudyResult> results;  ///< of every cell, with what keeps some from being run
  std::vector<dsp::PrepareOptions> ways;
  std::vector<std::vector<Job>> groups;  ///< by preparation
  dsp::Faults infeasible;
};

StudyPlan plan_of(const StudyRequest& request) {
  StudyPlan plan;
  std::map<std::string, std::size_t> group_of;
  for (const StudyCell& cell : request.cells) {
    plan.results.push_back({{}, cell});
    Config config;
    try {
      config = feasible_config(request, cell);
    } catch (const dsp::Fault& fault) {
      if (cell.setting.empty() || !is_out_of_range(fault)) throw;
      plan.infeasible.add(fault);
      plan.results.back().trouble = reason_of(fault, cell);
      continue;
    }
    if (std::find(plan.ways.begin(), plan.ways.end(), config.prepare) == plan.ways.end())
      plan.ways.push_back(config.prepare);
    const auto [group, is_new] = group_of.emplace(preparation_key(config), plan.groups.size());
    if (is_new) plan.groups.emplace_back();
    plan.groups[group->second].push_back({plan.results.size() - 1, std::move(config)});
  }
  return plan;
}

/// The cells of one preparation. `console` is told what is the same for every cell, `steps` what is being done.
void run_group(std::vector<Job>& jobs, const StudyRequest& request, std::vector<Input> inputs,
               std::vector<StudyResult>& results, std::size_t& done, Console& console, Console& steps) {
  Console silent({.verbosity = -1, .progress = ProgressMode::never});
  const auto vary = [&](std::size_t k) {
    check_interrupted();
    const StudyCell& cell = results[jobs[k].place].cell;
    steps.step(fmt::format("{}/{}: {}", ++done, request.cells.size(), cell.label()));
    Config& config = jobs[k].config;
    if (k > 0) config.zero.kind = ZeroChoice::Kind::none;  // it is subtracted
    settle(config, inputs, k > 0 ? silent : console);
    refuse_warnings(request.strict, steps);
    ident::StudyCase one = case_of(config, cell, inputs, request.num_threads);
    one.options.poll = shown_poll(
        steps, "study", [&] { return static_cast<double>(done - 1) / static_cast<double>(request.cells.size()); });
    if (k == 0) require_unclipped(config, inputs);
    return one;
  };
  const auto outcomes =
      ident::study(records_of(inputs), jobs.size(), vary,
                   request.max_memory_bytes > 0 ? request.max_memory_bytes : dsp::ReadOptions{}.max_memory_bytes);
  for (std::size_t k = 0; k < jobs.size(); ++k) {
    static_cast<ident::StudyOutcome&>(results[jobs[k].place]) = outcomes[k];
    results[jobs[k].place].keeps_motion = keeps_motion(inputs);
  }
}

}  // namespace

std::vector<StudyResult> run_cells(const StudyRequest& request, Console& console) {
  StudyPlan plan = plan_of(request);
  std::vector<StudyResult>& results = plan.results;
  const bool varies = std::any_of(results.begin(), results.end(), [](const StudyResult& result) {
    return !result.cell.setting.empty() && result.trouble.empty();
  });
  if (!varies) plan.infeasible.raise();
  const auto sources = read_sources(plan.groups.front().front().config, plan.ways, request.max_memory_bytes, console);
  Console silent({.verbosity = -1, .progress = ProgressMode::never});  // what is the same for every cell is said once
  std::size_t done = 0;
  for (std::vector<Job>& jobs : plan.groups) {
    try {
      Console& teller = done == 0 ? console : silent;
      const Config& first = jobs.front().config;
      const auto way = std::find(plan.ways.begin(), plan.ways.end(), first.prepare) - plan.ways.begin();
      std::vector<Input> inputs = prepare_inputs(sources, static_cast<std::size_t>(way), first, teller);
      run_group(jobs, request, std::move(inputs), results, done, teller, console);
    } catch (const dsp::Fault& fault) {  // some settings leave nothing to identify from
      if (jobs.front().place == 0 || fault.kind() == dsp::FaultKind::output) throw;
      for (const Job& job : jobs) results[job.place].trouble = fault.what();
      plan.infeasible.add(fault);
    }
  }
  if (std::none_of(results.begin(), results.end(), [](const auto& result) { return result.trouble.empty(); }))
    plan.infeasible.raise();
  return std::move(plan.results);
}

}  // namespace apps
