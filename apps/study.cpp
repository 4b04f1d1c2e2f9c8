#include "apps/study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "apps/process/interrupt.hpp"
#include "apps/regression_columns.hpp"

namespace apps {
namespace {

constexpr const char *train_fraction = "fit.train_share", *cutoff = "prepare.cutoff_hz",
                     *rolloff = "prepare.rolloff_hz";

std::string number(double value) {
  return fmt::format("{:.6g}", value);
}

bool has(const StudyCell& cell, const std::string& key) {
  return std::any_of(cell.setting.begin(), cell.setting.end(), [&](const auto& pair) { return pair.first == key; });
}

std::string fit_key(const ident::MethodSetting& setting) {
  return fmt::format("fit.{}", setting.name);
}

/// Methods that do not have an axis' setting are left out of its cells.
void keep_concerned(std::vector<ident::Method>& methods, const StudyCell& cell) {
  if (cell.axis < 0) return;
  const std::string& key = cell.setting.front().first;
  const auto concerned = [&](ident::Method method) {
    const auto& settings = ident::description(method).settings;
    return std::any_of(settings.begin(), settings.end(), [&](const auto& setting) { return key == fit_key(setting); });
  };
  if (std::any_of(methods.begin(), methods.end(), concerned))
    std::erase_if(methods, [&](ident::Method method) { return !concerned(method); });
}

Config config_of(const StudyRequest& request, const StudyCell& cell) {
  std::vector<std::string> overrides = request.set;
  for (const auto& [key, value] : cell.setting) {
    overrides.push_back(key + "=" + value);
    if (key != cutoff) continue;
    const dsp::PrepareOptions given = read_config(request.input, request.set).prepare,
                              settled = rate_settled(given, request.sample_rate_hz);
    if (given.rate_hz == 0.0 && settled.rate_hz > 0.0)  // as without the cut-off
      overrides.push_back(fmt::format("prepare.rate_hz={}", settled.rate_hz));
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

/// Configs with the same key share their prepared signals: all but library, fit and split.
std::string preparation_key(Config config) {
  config.library = {};
  config.fit = {};
  for (ident::Range& range : config.ranges) range.spec.train_to_s.reset();
  return to_toml(config, ".");
}

std::string library_key(const Config& config) {
  Config only;
  only.library = config.library;
  only.fit.target = config.fit.target;
  return to_toml(only, ".");
}

/// A cell on its way: its place among the cells and its config.
struct Job {
  std::size_t place = 0;
  Config config;
};

/// ident::Columns of one library on one preparation.
struct FormedColumns {
  std::vector<ident::CandidateLibrary> libraries;
  std::vector<ident::Columns> columns;
};

StudyRange summary_of(ident::RangeResult result) {
  StudyRange range{result.spec.name, std::move(result.terms), result.rows.train.size(), result.rows.test.size(), {}};
  for (ident::JudgedFit& fit : result.fits) {
    fit.predicted.resize(0);
    fit.predicted_std.resize(0);
    range.fits.push_back(std::move(fit));
  }
  return range;
}

}  // namespace

StudyAxis parse_axis(const std::string& text) {
  const std::size_t equals = text.find('=');
  const auto refuse = [&](const char* what) {
    throw dsp::Fault(dsp::FaultKind::usage, "study.over",
                     fmt::format("--over {}: {}, want KEY=V1,V2,... as in --over tau=5,10,20", text, what));
  };
  if (equals == std::string::npos || equals == 0) refuse("no key");
  StudyAxis axis{study_key(text.substr(0, equals)), {""}};
  if (axis.key.find('.') == std::string::npos) refuse("no such setting");
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

std::vector<StudyAxis> default_axes(const Config& config, double rate_hz) {
  std::vector<StudyAxis> axes;
  if (config.library.order > 0) axes.push_back({"library.order", {"1", "2", "3", "4", "5"}});
  for (const ident::MethodSetting& setting : ident::method_settings())
    if (!setting.study_values.empty() &&
        std::any_of(config.fit.methods.begin(), config.fit.methods.end(),
                    [&](ident::Method method) { return ident::description(method).has(setting.name); }))
      axes.push_back({fit_key(setting), {setting.study_values.begin(), setting.study_values.end()}});
  axes.push_back({train_fraction, {"0.15", "0.3", "0.45", "0.6", "0.75"}});
  axes.push_back({cutoff, {}});
  const double cutoff_hz = dsp::resolved(rate_settled(config.prepare, rate_hz), rate_hz).cutoff_hz;
  for (const double fraction : {0.5, 0.65, 0.8, 1.0}) axes.back().values.push_back(number(fraction * cutoff_hz));
  return axes;
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

std::vector<StudyResult> run_cells(const StudyRequest& request, Console& console) {
  std::vector<StudyResult> results;
  std::vector<dsp::PrepareOptions> ways;
  std::map<std::string, std::vector<Job>> groups;  // by preparation
  std::vector<std::string> order;
  for (const StudyCell& cell : request.cells) {
    Config config = config_of(request, cell);
    if (std::find(ways.begin(), ways.end(), config.prepare) == ways.end()) ways.push_back(config.prepare);
    const std::string key = preparation_key(config);
    if (!groups.contains(key)) order.push_back(key);
    groups[key].push_back({results.size(), std::move(config)});
    results.push_back({cell, {}, {}});
  }
  const auto sources = read_sources(groups.at(order.front()).front().config, ways, request.max_memory_bytes, console);
  Console silent({.verbosity = -1, .progress = ProgressMode::never});  // what is the same for every cell is said once
  std::size_t done = 0;
  for (const std::string& key : order) {
    std::vector<Job>& jobs = groups.at(key);
    const Config& first = jobs.front().config;
    const auto way = static_cast<std::size_t>(std::find(ways.begin(), ways.end(), first.prepare) - ways.begin());
    Console& teller = done == 0 ? console : silent;
    std::vector<Input> inputs = prepare_inputs(sources, way, first, teller);
    std::map<std::string, FormedColumns> formed;
    for (Job& job : jobs) {
      check_interrupted();
      StudyResult& result = results[job.place];
      console.step(fmt::format("{}/{}: {}", ++done, request.cells.size(), result.cell.label()));
      const bool zero_is_set = &job != jobs.data();
      if (zero_is_set) job.config.zero.kind = ZeroChoice::Kind::none;
      settle(job.config, inputs, zero_is_set ? silent : teller);
      refuse_warnings(request.strict, console);
      if (has(result.cell, train_fraction))  // ranges of a sidecar have come in
        for (ident::Range& range : job.config.ranges) range.spec.train_to_s.reset();
      try {
        FormedColumns& data = formed[library_key(job.config)];
        if (data.libraries.empty()) {
          data.libraries = compile_libraries(job.config, inputs);
          data.columns = all_columns(job.config, inputs, data.libraries, request.max_memory_bytes, silent);
        }
        const ident::IdentifyOptions options = identify_options(job.config, inputs, request.num_threads);
        for (ident::RangeResult& range :
             identify_ranges(job.config, data.columns, data.libraries.front(), options, silent))
          result.ranges.push_back(summary_of(std::move(range)));
      } catch (const dsp::Fault& fault) {
        if (fault.kind() != dsp::FaultKind::numerics) throw;
        result.trouble = fault.what();
      }
      console.progress("study", static_cast<double>(done) / static_cast<double>(request.cells.size()));
    }
  }
  return results;
}

}  // namespace apps
