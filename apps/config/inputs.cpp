#include "apps/config/inputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

#include "apps/config/recording_name.hpp"
#include "apps/config/segments_file.hpp"
#include "apps/process/interrupt.hpp"
#include "apps/process/printable.hpp"
#include "dsp/io/input_file.hpp"
#include "dsp/io/read_recording.hpp"
#include "dsp/prepare/sensor_checks.hpp"
#include "dsp/values/faults.hpp"
#include "dsp/values/names.hpp"
#include "ident/records/left_out.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

using Eigen::Index;

/// Messages name files as they were found. Outputs name files relative to the recording,
/// never by absolute path.
std::string without_place(std::string message, const fs::path& file) {
  const std::string prefix = file.parent_path().string() + "/", name = file.filename().string() + ": ";
  for (std::size_t at = 0; prefix != "/" && (at = message.find(prefix, at)) != std::string::npos;)
    message.erase(at, prefix.size());
  if (message.starts_with(name)) return message.substr(name.size());
  const std::string line = file.filename().string() + ":";
  const bool names_line = message.starts_with(line) && message.size() > line.size() &&
                          std::isdigit(static_cast<unsigned char>(message[line.size()])) != 0;
  return names_line ? "line " + message.substr(line.size()) : message;
}

/// The intervals of the config's file, meant for recordings by the names that these have here.
std::vector<LabelledInterval> segments_of(const Config& config) {
  std::vector<LabelledInterval> intervals = read_segments(config.segment_file);
  for (LabelledInterval& interval : intervals) {
    if (interval.recording.empty()) continue;
    const std::vector<std::size_t> meant = recordings_called(interval.recording, config.recordings);
    if (meant.size() == 1) interval.recording = printable(config.recordings[meant.front()].name);
  }
  return intervals;
}

void find_regimes(Input& input, const Config& config, int num_threads, Console& console) {
  if (!config.segment_file.empty())
    ident::set_regimes(input, apply_segments(segments_of(config), config.segment_file, input.prepared));
  else if (config.segment)
    ident::find_regimes(input, config.segment_options, num_threads);
  else
    input.prepared.checks.push_back(ident::left_out(input));
  for (const std::string& remark : input.segmentation.remarks)
    console.note(fmt::format("{}: {}", input.prepared.name, remark));
}

/// What is known of a recording before it is prepared.
Input described(const dsp::RecordingReader& reader, const RecordingConfig& recording) {
  Input input;
  input.prepared.name = recording.name;
  input.files = reader.files();
  if (!reader.sidecar().file.empty()) input.files.push_back(reader.sidecar().file);
  input.sidecar = (reader.sidecar().file.empty() ? dsp::sidecar_path(input.files.front()) : reader.sidecar().file)
                      .filename()
                      .string();
  input.channels = reader.sidecar().channels;
  input.ranges = reader.sidecar().ranges;
  return input;
}

dsp::StreamOptions stream_options(const std::string& name, std::size_t max_memory_bytes, int num_threads,
                                  Console& console) {
  return {.max_memory_bytes = max_memory_bytes,
          .progress = shown_progress(console, "reading " + name),
          .num_threads = num_threads};
}

/// Everything after the signals: regimes, the power check, and what is said of them.
void complete(Input& input, const std::string& name, double recorded_hz, const Config& config, int num_threads,
              Console& console) {
  const fs::path file = input.files.front();
  input.prepared.name = name;
  input.recorded_rate_hz = recorded_hz;
  for (dsp::Check& check : input.prepared.checks) check.message = without_place(std::move(check.message), file);
  for (dsp::Check& check : dsp::sensor_checks(input.prepared, input.channels, input.sidecar))
    input.prepared.checks.push_back(std::move(check));
  find_regimes(input, config, num_threads, console);
  report_checks(input.prepared.checks, name, console);
  const dsp::Motion& signals = input.prepared.signals;
  console.step(fmt::format(
      "{}: {} samples at {:.9g} Hz (recorded at {:.9g} Hz), {} at either end set aside, {} intervals excluded", name,
      signals.num_samples(), signals.sample_rate_hz, recorded_hz, signals.edge_samples,
      input.prepared.excluded.size()));
}

Input prepare_input(const RecordingConfig& recording, const Config& config, std::size_t max_memory_bytes,
                    int num_threads, Console& console) {
  const std::string& name = recording.name;
  console.step(fmt::format("reading {}", name));
  dsp::ReadOptions options = read_options(recording, max_memory_bytes);
  options.num_threads = num_threads;
  dsp::RecordingReader reader(recording.file, options);
  const double rate_hz = reader.description().sample_rate_hz;
  Input input = described(reader, recording);
  console.step(fmt::format("preparing {}", name));
  input.prepared = dsp::prepare(reader, dsp::rate_by_cutoff(config.prepare, rate_hz),
                                stream_options(name, options.max_memory_bytes, num_threads, console));
  complete(input, name, rate_hz, config, num_threads, console);
  return input;
}

/// Does `use` for each recording. Once something is wrong with one, the others are only looked at, and all that was
/// found is thrown in the end.
template <class Use>
void for_each_recording(const Config& config, std::size_t max_memory_bytes, Use&& use) {
  dsp::Faults faults;
  for (const RecordingConfig& recording : config.recordings)
    faults.attempt([&] {
      if (faults.empty())
        use(recording);
      else
        const dsp::RecordingReader looked_at(recording.file, read_options(recording, max_memory_bytes));
    });
  faults.raise();
}

void note_overlaps(const std::vector<ident::Range>& ranges, Console& console) {
  constexpr std::size_t most_notes = 100;
  const auto pairs = ident::overlaps(ranges, most_notes);
  for (const auto& [a, b] : pairs)
    console.note(fmt::format("ranges {} and {} overlap", ranges[b].spec.name, ranges[a].spec.name));
  if (pairs.size() == most_notes) console.note("further ranges may overlap");
}

void add_default_terms(Config& config, const std::vector<const ident::Record*>& records) {
  std::vector<std::string>& terms = config.library.terms;
  for (std::string& term : ident::default_terms(records))
    if (term != config.fit.target && std::none_of(terms.begin(), terms.end(), [&](std::string typed) {
          std::erase(typed, ' ');
          return typed == term;
        }))
      terms.push_back(std::move(term));
}

void settle_zero(Config& config, std::vector<Input>& inputs, Console& console) {
  if (config.zero.kind == ZeroChoice::Kind::automatic) {
    const bool difference =
        std::any_of(inputs.begin(), inputs.end(), [](const Input& input) { return input.prepared.x_is_difference; });
    config.zero.kind = difference ? ZeroChoice::Kind::fit : ZeroChoice::Kind::as_it_is;
  }
  if (config.zero.kind == ZeroChoice::Kind::as_it_is) return;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const bool fit = config.zero.kind == ZeroChoice::Kind::fit,
               mean = fit || config.zero.kind == ZeroChoice::Kind::mean;
    inputs[i].zero_is_known = !fit;
    inputs[i].zero_is_fitted = fit;
    if (config.zero.kind == ZeroChoice::Kind::none) continue;
    const double zero_m =
        mean ? ident::mean_of_first_range(inputs[i], config.ranges, static_cast<int>(i) + 1) : config.zero.value_m;
    dsp::set_displacement_zero(inputs[i].prepared, zero_m);
    inputs[i].zero = zero_m;
    console.step(fmt::format("{}: zero of x {:.6g} subtracted ({})", inputs[i].prepared.name, zero_m,
                             mean ? "mean of the first range" : "as given"));
  }
}

/// An option that came out the same for every recording is written down; else it stays to be found again.
void settle_prepare(dsp::PrepareOptions& options, const std::vector<Input>& inputs) {
  for (const auto member :
       {&dsp::PrepareOptions::rate_hz, &dsp::PrepareOptions::cutoff_hz, &dsp::PrepareOptions::rolloff_hz,
        &dsp::PrepareOptions::state_cutoff_hz, &dsp::PrepareOptions::state_rolloff_hz,
        &dsp::PrepareOptions::intermediate_rate_hz, &dsp::PrepareOptions::integrate_from_hz}) {
    const double first = inputs.front().prepared.options.*member;
    if (std::all_of(inputs.begin(), inputs.end(),
                    [&](const Input& input) { return input.prepared.options.*member == first; }))
      options.*member = first;
  }
}

}  // namespace

void report_checks(const std::vector<dsp::Check>& checks, const std::string& name, Console& console) {
  for (const dsp::Check& check : checks) {
    const std::string line = fmt::format("{}: {}{}", name, channel_prefix(check), check.message);
    if (check.status == dsp::CheckStatus::warning || check.status == dsp::CheckStatus::failed)
      console.warning(check.name, line);
    else if (check.status == dsp::CheckStatus::note)
      console.note(line);
  }
}

std::vector<const ident::Record*> records_of(const std::vector<Input>& inputs) {
  std::vector<const ident::Record*> records;
  for (const Input& input : inputs) records.push_back(&input);
  return records;
}

namespace {

/// A cut-off that leaves something of a short record: filters reach over so many of its periods at either end.
double cutoff_for_length(double cutoff_hz, double duration_s) {
  constexpr double reach_periods = 18.6, most_lost = 0.4, well_lost = 0.3;
  const double lost = 2.0 * reach_periods / (cutoff_hz * duration_s);
  if (lost <= most_lost) return cutoff_hz;
  return std::stod(fmt::format("{:.3g}", cutoff_hz * lost / well_lost));
}

}  // namespace

void choose_band(Config& config, std::size_t max_memory_bytes, Console& console) {
  if (config.prepare.rate_hz > 0.0 || config.prepare.cutoff_hz > 0.0) return;
  double highest_hz = 0.0;
  bool is_clear = true;
  for_each_recording(config, max_memory_bytes, [&](const RecordingConfig& recording) {
    if (!is_clear) return;
    const std::string& name = recording.name;
    console.step(fmt::format("{}: looking for the band of its motion", name));
    double duration_s = 0.0;
    const dsp::MotionBand band = dsp::find_motion_band([&] {
      dsp::RecordingReader reader(recording.file, read_options(recording, max_memory_bytes));
      duration_s = static_cast<double>(reader.num_frames()) / reader.description().sample_rate_hz;
      return reader;
    });
    double cutoff_hz = dsp::cutoff_for(band);
    if (cutoff_hz > 0.0) cutoff_hz = cutoff_for_length(cutoff_hz, duration_s);
    constexpr double usable = 0.8;
    if (cutoff_hz > usable * band.nyquist_hz) cutoff_hz = 0.0;
    if (cutoff_hz == 0.0 && band.hold_samples > 1) cutoff_hz = usable * band.nyquist_hz;
    if (cutoff_hz == 0.0) {
      console.note(fmt::format("{}: its motion is above its noise in the whole band, or too slow to tell", name));
      is_clear = false;
      return;
    }
    highest_hz = std::max(highest_hz, cutoff_hz);
    console.note(fmt::format("{}: {} is above its noise up to {:.3g} Hz", name, band.signal, band.to_hz));
  });
  if (!is_clear) return;
  config.prepare.cutoff_hz = highest_hz;
  console.step(fmt::format("cutoff_hz = {:.4g} chosen by the motion; [prepare] cutoff_hz sets another", highest_hz));
}

std::vector<RecordedBand> recorded_bands(const Config& config, std::size_t max_memory_bytes) {
  std::vector<RecordedBand> bands;
  for (const RecordingConfig& recording : config.recordings) {
    double rate_hz = 0.0;
    const dsp::MotionBand band = dsp::find_motion_band([&] {
      dsp::RecordingReader reader(recording.file, read_options(recording, max_memory_bytes));
      rate_hz = reader.description().sample_rate_hz;
      return reader;
    });
    bands.push_back({rate_hz, band});
  }
  return bands;
}

std::optional<double> cutoff_below(double stop_hz, const std::vector<RecordedBand>& recordings) {
  std::optional<double> lowest_hz;
  for (const auto& [rate_hz, motion] : recordings) {
    if (motion.signal.empty()) return std::nullopt;
    // Decimated columns are gone at a quarter more than the cut-off; those at the record's own rate at the cut-off.
    double cutoff_hz = stop_hz / 1.25;
    if (dsp::rate_by_cutoff({.cutoff_hz = cutoff_hz}, rate_hz).rate_hz == 0.0) cutoff_hz = stop_hz;
    cutoff_hz = std::stod(fmt::format("{:.3g}", cutoff_hz));  // more digits are not known of it
    if (dsp::band_check(motion, cutoff_hz).status == dsp::CheckStatus::warning) return std::nullopt;
    lowest_hz = std::min(lowest_hz.value_or(cutoff_hz), cutoff_hz);
  }
  return lowest_hz;
}

dsp::ReadOptions read_options(const RecordingConfig& recording, std::size_t max_memory_bytes) {
  dsp::ReadOptions options;
  options.sidecar = recording.sidecar;
  options.salvage = recording.salvage;
  options.uncalibrated = recording.uncalibrated;
  options.use = recording.use;
  options.run = recording.run;
  if (max_memory_bytes > 0) options.max_memory_bytes = max_memory_bytes;
  return options;
}

void look_at_recordings(const Config& config, std::size_t max_memory_bytes) {
  dsp::Faults faults;
  for (const RecordingConfig& recording : config.recordings)
    faults.attempt(
        [&] { const dsp::RecordingReader looked_at(recording.file, read_options(recording, max_memory_bytes)); });
  faults.raise();
}

std::vector<fs::path> input_files(const Config& config) {
  std::vector<fs::path> files;
  for (const auto* recordings : {&config.recordings, &config.test_recordings})
    for (const RecordingConfig& recording : *recordings) {
      const dsp::InputFile there(recording.file);  // said before anything is made for the results
      files.push_back(recording.file);
      const fs::path sidecar = recording.sidecar.empty() ? dsp::sidecar_path(recording.file) : recording.sidecar;
      std::error_code ignored;
      if (fs::exists(sidecar, ignored)) files.push_back(sidecar);
    }
  if (!config.segment_file.empty()) {
    const dsp::InputFile there(config.segment_file);
    files.push_back(config.segment_file);
  }
  return files;
}

std::vector<Input> prepare_inputs(const Config& config, std::size_t max_memory_bytes, int num_threads,
                                  Console& console) {
  Config settled = config;
  choose_band(settled, max_memory_bytes, console);
  std::vector<Input> inputs;
  for_each_recording(settled, max_memory_bytes, [&](const RecordingConfig& recording) {
    inputs.push_back(prepare_input(recording, settled, max_memory_bytes, num_threads, console));
  });
  return inputs;
}

std::vector<Source> read_sources(const Config& config, const std::vector<dsp::PrepareOptions>& ways,
                                 std::size_t max_memory_bytes, Console& console) {
  std::vector<Source> sources;
  for (const RecordingConfig& recording : config.recordings) {
    const std::string& name = recording.name;
    console.step(fmt::format("reading {}", name));
    const dsp::ReadOptions options = read_options(recording, max_memory_bytes);
    dsp::RecordingReader reader(recording.file, options);
    std::vector<dsp::PrepareOptions> settled;
    for (const dsp::PrepareOptions& way : ways)
      settled.push_back(dsp::rate_by_cutoff(way, reader.description().sample_rate_hz));
    Source source{described(reader, recording), {}};
    source.intermediates =
        dsp::read_intermediate(reader, settled, stream_options(name, options.max_memory_bytes, 1, console));
    sources.push_back(std::move(source));
  }
  return sources;
}

std::vector<Input> prepare_inputs(const std::vector<Source>& sources, std::size_t way, const Config& config,
                                  Console& console) {
  std::vector<Input> inputs;
  for (const Source& source : sources) {
    const dsp::IntermediateRecording& intermediate = *source.intermediates.at(way);
    inputs.push_back(source.described);
    inputs.back().prepared =
        dsp::prepare(intermediate, dsp::rate_by_cutoff(config.prepare, intermediate.input_rate_hz));
    complete(inputs.back(), source.described.prepared.name, intermediate.input_rate_hz, config, 1, console);
  }
  return inputs;
}

void settle(Config& config, std::vector<Input>& inputs, Console& console) {
  if (config.ranges.empty()) config.ranges = ident::default_ranges(records_of(inputs));
  if (config.split_by_direction) config.ranges = ident::split_by_direction(config.ranges);
  config.split_by_direction = false;  // done: the ranges say it
  note_overlaps(config.ranges, console);
  for (ident::Range& range : config.ranges) range.train_fraction = config.fit.train_fraction;
  if (config.default_terms) {
    add_default_terms(config, records_of(inputs));
    const std::vector<dsp::Check> missing = ident::inputs_of_some(records_of(inputs));
    report_checks(missing, "all recordings", console);
    auto& checks = inputs.front().prepared.checks;
    checks.insert(checks.end(), missing.begin(), missing.end());
  }
  config.default_terms = false;
  for (ident::RangeCheck& scarce : ident::scarce_ranges(config.ranges, records_of(inputs))) {
    dsp::Prepared& prepared = inputs[scarce.recording].prepared;
    report_checks({scarce.check}, prepared.name, console);
    prepared.checks.push_back(std::move(scarce.check));
  }
  settle_zero(config, inputs, console);
  settle_prepare(config.prepare, inputs);
}

}  // namespace apps
