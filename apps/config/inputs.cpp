#include "apps/config/inputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/output/segments_file.hpp"
#include "apps/process/interrupt.hpp"
#include "apps/sensor_checks.hpp"
#include "dsp/io/sidecar.hpp"
#include "dsp/names.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

using Eigen::Index;

/// Messages name files as they were found. Outputs are not to hold where that is on this machine, and the recording
/// stands beside its checks.
std::string without_place(std::string message, const fs::path& file) {
  const std::string prefix = file.parent_path().string() + "/", name = file.filename().string() + ": ";
  for (std::size_t at = 0; prefix != "/" && (at = message.find(prefix, at)) != std::string::npos;)
    message.erase(at, prefix.size());
  return message.starts_with(name) ? message.substr(name.size()) : message;
}

void report_checks(const std::vector<dsp::Check>& checks, const std::string& name, Console& console) {
  for (const dsp::Check& check : checks) {
    const std::string line = fmt::format("{}: {}{}", name, channel_prefix(check), check.message);
    if (check.status == dsp::CheckStatus::warning || check.status == dsp::CheckStatus::failed)
      console.warning(check.name, line);
    else if (check.status == dsp::CheckStatus::note)
      console.note(line);
  }
}

bool has(const Input& input, dsp::Regime regime) {
  return std::find(input.regimes.begin(), input.regimes.end(), regime) != input.regimes.end();
}

std::vector<dsp::Regime> moving_regimes(const Input& input) {
  std::vector<dsp::Regime> found;
  for (const dsp::RegimeInfo& known : dsp::regime_table())
    if (known.moving && has(input, known.regime)) found.push_back(known.regime);
  return found;
}

/// Told where everything that moves lies within the filters' reach of something excluded, as free decays do.
void tell_if_nothing_moves(Input& input) {
  if (!has(input, dsp::Regime::stick) || !has(input, dsp::Regime::excluded) || !moving_regimes(input).empty()) return;
  const auto& signals = input.prepared.signals;
  input.prepared.checks.push_back(
      {.name = "regime.no_motion",
       .status = dsp::CheckStatus::warning,
       .message = fmt::format("only rest is left: whatever moves lies within {:.2g} s, the filters' reach, of samples "
                              "that are excluded. A higher prepare.rate_hz and prepare.cutoff_hz reach less far",
                              static_cast<double>(signals.edge_samples) / signals.sample_rate_hz)});
}

void find_regimes(Input& input, const Config& config, Console& console) {
  if (!config.segment_file.empty())
    input.segmentation = apply_segments(read_segments(config.segment_file), config.segment_file, input.prepared);
  else if (config.segment)
    input.segmentation = dsp::segment_regimes(input.prepared.bus, config.segment_options);
  else
    return;
  input.regimes = regimes_at(input.segmentation, input.prepared);
  for (const std::string& remark : input.segmentation.remarks)
    console.note(fmt::format("{}: {}", input.prepared.name, remark));
  tell_if_nothing_moves(input);
  if (input.prepared.raw_v.size() == 0) return;
  input.power = power_check(input.prepared, input.regimes);
  input.prepared.checks.push_back(judged(*input.power, input.prepared.relations));
}

/// What is known of a recording before it is prepared.
Input described(const dsp::RecordingReader& reader) {
  Input input;
  input.files = reader.files();
  if (!reader.sidecar().file.empty()) input.files.push_back(reader.sidecar().file);
  input.sidecar = (reader.sidecar().file.empty() ? dsp::sidecar_path(input.files.front()) : reader.sidecar().file)
                      .filename()
                      .string();
  input.channels = reader.sidecar().channels;
  input.ranges = reader.sidecar().ranges;
  const dsp::Recording& description = reader.description();
  input.x_is_difference =
      description.find(dsp::Role::x) < 0 && description.find(dsp::Role::y) >= 0 && description.find(dsp::Role::r) >= 0;
  return input;
}

dsp::StreamOptions stream_options(const std::string& name, std::size_t max_memory_bytes, Console& console) {
  return {.max_memory_bytes = max_memory_bytes, .progress = [&console, name](double share) {
            check_interrupted();
            console.progress("reading " + name, share);
          }};
}

/// Everything after the signals: regimes, the power check, and what is said of them.
void complete(Input& input, double recorded_hz, const Config& config, Console& console) {
  const fs::path file = input.files.front();
  const std::string name = file.filename().string();
  input.prepared.name = name;
  for (dsp::Check& check : input.prepared.checks) check.message = without_place(std::move(check.message), file);
  for (dsp::Check& check : sensor_checks(input.prepared, input.channels, input.sidecar))
    input.prepared.checks.push_back(std::move(check));
  find_regimes(input, config, console);
  report_checks(input.prepared.checks, name, console);
  const dsp::Motion& signals = input.prepared.signals;
  console.step(fmt::format(
      "{}: {} samples at {:.9g} Hz (recorded at {:.9g} Hz), {} at either end set aside, {} stretches excluded", name,
      signals.num_samples(), signals.sample_rate_hz, recorded_hz, signals.edge_samples,
      input.prepared.excluded.size()));
}

Input prepare_input(const RecordingConfig& recording, const Config& config, std::size_t max_memory_bytes,
                    Console& console) {
  const std::string name = recording.file.filename().string();
  console.step(fmt::format("reading {}", name));
  const dsp::ReadOptions options = read_options(recording, max_memory_bytes);
  dsp::RecordingReader reader(recording.file, options);
  const double rate_hz = reader.description().sample_rate_hz;
  Input input = described(reader);
  console.step(fmt::format("preparing {}", name));
  input.prepared = dsp::prepare(reader, rate_settled(config.prepare, rate_hz),
                                stream_options(name, options.max_memory_bytes, console));
  complete(input, rate_hz, config, console);
  return input;
}

/// The ranges of a recording for which neither config nor sidecar names any.
std::vector<Range> ranges_of(const Input& input, int recording, bool alone) {
  const std::string name = alone ? "" : fs::path(input.prepared.name).stem().string();
  const auto range = [&](const std::string& label, const dsp::RegimeSet& regime) {
    Range result{{}, recording, regime};
    result.spec.name = alone ? label : regime.any() ? name : name + " " + label;
    return result;
  };
  const std::vector<dsp::Regime> moving = moving_regimes(input);
  if (moving.empty() || (moving.size() == 1 && !has(input, dsp::Regime::stick))) return {range("all", {})};
  std::vector<Range> ranges;
  for (const dsp::Regime regime : moving) ranges.push_back(range(std::string(to_string(regime)), regime));
  if (moving.size() > 1) ranges.push_back(range(dsp::RegimeSet::mixed().name(), dsp::RegimeSet::mixed()));
  return ranges;
}

std::vector<Range> default_ranges(const std::vector<Input>& inputs) {
  std::vector<Range> ranges;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const int recording = static_cast<int>(i) + 1;
    for (const dsp::RangeSpec& spec : inputs[i].ranges) ranges.push_back({spec, recording, {}});
    if (!inputs[i].ranges.empty()) continue;
    for (Range& range : ranges_of(inputs[i], recording, inputs.size() == 1)) {
      const bool taken = std::any_of(ranges.begin(), ranges.end(),
                                     [&](const Range& other) { return other.spec.name == range.spec.name; });
      if (taken) range.spec.name += fmt::format("-{}", recording);
      ranges.push_back(std::move(range));
    }
  }
  return ranges;
}

/// Every range as two, by the sign of the velocity: "low+" and "low-".
std::vector<Range> split_by_direction(const std::vector<Range>& ranges) {
  std::vector<Range> halves;
  for (const Range& range : ranges)
    for (const auto& [sign, condition] : {std::pair{"+", "v > 0"}, std::pair{"-", "v < 0"}}) {
      Range half = range;
      half.spec.name += sign;
      half.spec.where = range.spec.where.empty() ? condition : fmt::format("({}) && {}", range.spec.where, condition);
      halves.push_back(std::move(half));
    }
  return halves;
}

/// Whether two ranges may hold the same samples.
bool may_overlap(const Range& a, const Range& b) {
  const bool other_time = a.spec.to_s <= b.spec.from_s || b.spec.to_s <= a.spec.from_s || a.recording != b.recording;
  return !other_time && a.regime.meets(b.regime) && a.spec.where == b.spec.where;
}

/// Mean of x over the first range of the recording; where that is of a regime, over its first run.
double regime_mean(const Input& input, const std::vector<Range>& ranges, int recording) {
  const dsp::Prepared& prepared = input.prepared;
  const auto first = std::find_if(ranges.begin(), ranges.end(), [&](const Range& range) {
    return range.recording == 0 || range.recording == recording;
  });
  if (first == ranges.end()) return dsp::mean_displacement(prepared, 0.0, INFINITY);
  double from_s = first->spec.from_s, to_s = first->spec.to_s;
  for (const dsp::Segment& segment : input.segmentation.segments) {
    const double begin_s = static_cast<double>(segment.first) / prepared.bus.sample_rate_hz,
                 end_s = static_cast<double>(segment.last) / prepared.bus.sample_rate_hz;
    if (first->regime.any() || !first->regime.holds(segment.regime) || begin_s >= to_s || end_s <= from_s) continue;
    from_s = std::max(from_s, begin_s), to_s = std::min(to_s, end_s);
    break;
  }
  return dsp::mean_displacement(prepared, from_s, to_s);
}

/// What a library of polynomials in x and v cannot do without: dry friction, and whatever drives the motion from
/// outside.
void settle_terms(Config& config, const std::vector<Input>& inputs) {
  if (!config.default_terms) return;
  config.library.terms = {"sgn(v)"};
  for (const dsp::SignalInfo& signal : dsp::signal_table())
    if (signal.in_default_library && std::all_of(inputs.begin(), inputs.end(), [&](const Input& input) {
          return input.prepared.signals.find(signal.name) != nullptr;
        }))
      config.library.terms.emplace_back(signal.name);
}

void settle_zero(Config& config, std::vector<Input>& inputs, Console& console) {
  if (config.zero.kind == ZeroChoice::Kind::automatic) {
    const bool difference =
        std::any_of(inputs.begin(), inputs.end(), [](const Input& input) { return input.x_is_difference; });
    config.zero.kind = difference ? ZeroChoice::Kind::regime_mean : ZeroChoice::Kind::none;
  }
  if (config.zero.kind == ZeroChoice::Kind::none) return;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const bool mean = config.zero.kind == ZeroChoice::Kind::regime_mean;
    const double zero_m = mean ? regime_mean(inputs[i], config.ranges, static_cast<int>(i) + 1) : config.zero.value_m;
    dsp::set_displacement_zero(inputs[i].prepared, zero_m);
    console.step(fmt::format("{}: zero of x {:.6g} subtracted ({})", inputs[i].prepared.name, zero_m,
                             mean ? "mean of the first range" : "as given"));
  }
}

/// An option that came out the same for every recording is written down; else it stays to be found again.
void settle_prepare(dsp::PrepareOptions& options, const std::vector<Input>& inputs) {
  for (const auto member : {&dsp::PrepareOptions::rate_hz, &dsp::PrepareOptions::cutoff_hz,
                            &dsp::PrepareOptions::rolloff_hz, &dsp::PrepareOptions::state_cutoff_hz,
                            &dsp::PrepareOptions::state_rolloff_hz, &dsp::PrepareOptions::bus_rate_hz}) {
    const double first = inputs.front().prepared.options.*member;
    if (std::all_of(inputs.begin(), inputs.end(),
                    [&](const Input& input) { return input.prepared.options.*member == first; }))
      options.*member = first;
  }
}

}  // namespace

dsp::PrepareOptions rate_settled(dsp::PrepareOptions options, double sample_rate_hz) {
  constexpr double raw_from_hz = 2000.0, regression_rate_hz = 25.6, cutoff_hz = 10.24;
  if (options.rate_hz > 0.0 || options.cutoff_hz > 0.0 || sample_rate_hz < raw_from_hz) return options;
  options.rate_hz = regression_rate_hz;
  options.cutoff_hz = cutoff_hz;
  return options;
}

dsp::ReadOptions read_options(const RecordingConfig& recording, std::size_t max_memory_bytes) {
  dsp::ReadOptions options;
  options.sidecar = recording.sidecar;
  options.salvage = recording.salvage;
  options.uncalibrated = recording.uncalibrated;
  options.use = recording.use;
  if (max_memory_bytes > 0) options.max_memory_bytes = max_memory_bytes;
  return options;
}

std::vector<fs::path> input_files(const Config& config) {
  std::vector<fs::path> files;
  for (const RecordingConfig& recording : config.recordings) {
    files.push_back(recording.file);
    const fs::path sidecar = recording.sidecar.empty() ? dsp::sidecar_path(recording.file) : recording.sidecar;
    std::error_code ignored;
    if (fs::exists(sidecar, ignored)) files.push_back(sidecar);
  }
  if (!config.segment_file.empty()) files.push_back(config.segment_file);
  return files;
}

std::vector<Input> prepare_inputs(const Config& config, std::size_t max_memory_bytes, Console& console) {
  std::vector<Input> inputs;
  for (const RecordingConfig& recording : config.recordings)
    inputs.push_back(prepare_input(recording, config, max_memory_bytes, console));
  return inputs;
}

std::vector<Source> read_sources(const Config& config, const std::vector<dsp::PrepareOptions>& ways,
                                 std::size_t max_memory_bytes, Console& console) {
  std::vector<Source> sources;
  for (const RecordingConfig& recording : config.recordings) {
    const std::string name = recording.file.filename().string();
    console.step(fmt::format("reading {}", name));
    const dsp::ReadOptions options = read_options(recording, max_memory_bytes);
    dsp::RecordingReader reader(recording.file, options);
    std::vector<dsp::PrepareOptions> settled;
    for (const dsp::PrepareOptions& way : ways)
      settled.push_back(rate_settled(way, reader.description().sample_rate_hz));
    Source source{described(reader), {}};
    source.buses = dsp::read_bus(reader, settled, stream_options(name, options.max_memory_bytes, console));
    sources.push_back(std::move(source));
  }
  return sources;
}

std::vector<Input> prepare_inputs(const std::vector<Source>& sources, std::size_t way, const Config& config,
                                  Console& console) {
  std::vector<Input> inputs;
  for (const Source& source : sources) {
    const dsp::BusRecording& bus = *source.buses.at(way);
    inputs.push_back(source.described);
    inputs.back().prepared = dsp::prepare(bus, rate_settled(config.prepare, bus.input_rate_hz));
    complete(inputs.back(), bus.input_rate_hz, config, console);
  }
  return inputs;
}

void settle(Config& config, std::vector<Input>& inputs, Console& console) {
  if (config.ranges.empty()) config.ranges = default_ranges(inputs);
  if (config.split_by_direction) config.ranges = split_by_direction(config.ranges);
  config.split_by_direction = false;  // done: the ranges say it
  for (std::size_t a = 0; a < config.ranges.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      if (may_overlap(config.ranges[a], config.ranges[b]))
        console.note(fmt::format("ranges {} and {} overlap", config.ranges[b].spec.name, config.ranges[a].spec.name));
  for (Range& range : config.ranges) range.train_share = config.fit.train_share;
  settle_terms(config, inputs);
  settle_zero(config, inputs, console);
  settle_prepare(config.prepare, inputs);
}

}  // namespace apps
