#include "apps/inputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/interrupt.hpp"
#include "dsp/names.hpp"
#include "dsp/sidecar.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

using Eigen::Index;

/// Messages name files as they were found; outputs are not to hold where that is on this machine.
std::string without_folder(std::string message, const fs::path& folder) {
  const std::string prefix = folder.string() + "/";
  for (std::size_t at = 0; folder != fs::path() && (at = message.find(prefix, at)) != std::string::npos;)
    message.erase(at, prefix.size());
  return message;
}

void report_checks(const std::vector<dsp::Check>& checks, const std::string& name, Console& console) {
  for (const dsp::Check& check : checks) {
    const std::string line =
        fmt::format("{}: {}{}", name, check.channel.empty() ? "" : check.channel + ": ", check.message);
    if (check.status == dsp::CheckStatus::warning || check.status == dsp::CheckStatus::failed)
      console.warning(check.name, line);
    else if (check.status == dsp::CheckStatus::note)
      console.note(line);
  }
}

/// The whole recording in memory, with progress. Its checks and bad stretches are complete once it has been read.
dsp::Recording read_whole(dsp::RecordingReader& reader, const std::string& name, std::size_t max_memory_bytes,
                          Console& console) {
  constexpr Index block_frames = 65536;
  const auto channels = static_cast<Index>(reader.description().channels.size());
  const double bytes =
      static_cast<double>(sizeof(double)) * static_cast<double>(channels) * static_cast<double>(reader.num_frames());
  if (bytes > static_cast<double>(max_memory_bytes))
    throw dsp::Fault(dsp::FaultKind::numerics, "memory.limit",
                     fmt::format("{}: needs {:.0f} MB in memory, at most {:.0f} MB are allowed. Raise --max-memory.",
                                 name, 1e-6 * bytes, 1e-6 * static_cast<double>(max_memory_bytes)));
  Eigen::MatrixXd samples(static_cast<Index>(reader.num_frames()), channels);
  dsp::FrameBlock block;
  Index done = 0;
  while (const Index count = reader.read(block, block_frames)) {
    samples.middleRows(done, count) = block.topRows(count);
    done += count;
    check_interrupted();
    console.progress("reading " + name, static_cast<double>(done) / static_cast<double>(samples.rows()));
  }
  dsp::Recording recording = reader.description();
  recording.samples = samples.topRows(done);
  return recording;
}

Input prepare_input(const RecordingConfig& recording, const Config& config, std::size_t max_memory_bytes,
                    Console& console) {
  const std::string name = recording.file.filename().string();
  console.step(fmt::format("reading {}", name));
  const dsp::ReadOptions options = read_options(recording, max_memory_bytes);
  dsp::RecordingReader reader(recording.file, options);
  Input input;
  input.files = reader.files();
  if (!reader.sidecar().file.empty()) input.files.push_back(reader.sidecar().file);
  input.ranges = reader.sidecar().ranges;
  const dsp::Recording& description = reader.description();
  input.x_is_difference =
      description.find(dsp::Role::x) < 0 && description.find(dsp::Role::y) >= 0 && description.find(dsp::Role::r) >= 0;
  console.step(fmt::format("preparing {}", name));
  input.prepared = dsp::prepare(read_whole(reader, name, options.max_memory_bytes, console), config.prepare);
  input.prepared.name = name;
  for (dsp::Check& check : input.prepared.checks)
    check.message = without_folder(std::move(check.message), recording.file.parent_path());
  report_checks(input.prepared.checks, name, console);
  const dsp::Motion& signals = input.prepared.signals;
  console.step(fmt::format("{}: {} samples at {:.9g} Hz, {} at either end set aside, {} stretches excluded", name,
                           signals.num_samples(), signals.sample_rate_hz, signals.edge_samples,
                           input.prepared.excluded.size()));
  return input;
}

/// The ranges a run without any in its config gets.
std::vector<RangeConfig> default_ranges(const std::vector<Input>& inputs) {
  std::vector<RangeConfig> ranges;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const int recording = static_cast<int>(i) + 1;
    for (const dsp::RangeSpec& spec : inputs[i].ranges) ranges.push_back({spec, recording});
    if (!inputs[i].ranges.empty()) continue;
    dsp::RangeSpec spec;
    spec.name = inputs.size() == 1 ? "all" : fs::path(inputs[i].prepared.name).stem().string();
    const bool taken = std::any_of(ranges.begin(), ranges.end(),
                                   [&](const RangeConfig& range) { return range.spec.name == spec.name; });
    if (taken) spec.name += fmt::format("-{}", recording);
    ranges.push_back({std::move(spec), recording});
  }
  return ranges;
}

/// Mean of x over the first range of the recording, excluded samples and spoilt ends apart.
double regime_mean(const dsp::Motion& signals, const std::vector<RangeConfig>& ranges, int recording) {
  const auto first = std::find_if(ranges.begin(), ranges.end(), [&](const RangeConfig& range) {
    return range.recording == 0 || range.recording == recording;
  });
  const double from_s = first == ranges.end() ? 0.0 : first->spec.from_s;
  const double to_s = first == ranges.end() ? INFINITY : first->spec.to_s;
  const Eigen::VectorXd& x = signals.at("x");
  double sum = 0.0;
  Index count = 0;
  for (Index i = signals.edge_samples; i < x.size() - signals.edge_samples; ++i) {
    const double t = static_cast<double>(i) / signals.sample_rate_hz;
    if (t < from_s || t >= to_s || (!signals.excluded.empty() && signals.excluded[static_cast<std::size_t>(i)] != 0))
      continue;
    sum += x(i);
    ++count;
  }
  return count == 0 ? 0.0 : sum / static_cast<double>(count);
}

/// What a library of polynomials in x and v cannot do without: dry friction, and whatever drives the motion from
/// outside.
void settle_terms(Config& config, const std::vector<Input>& inputs) {
  if (!config.default_terms) return;
  config.library.terms = {"sgn(v)"};
  for (const char* name : {"ddr", "f", "z"})
    if (std::all_of(inputs.begin(), inputs.end(),
                    [&](const Input& input) { return input.prepared.signals.find(name) != nullptr; }))
      config.library.terms.emplace_back(name);
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
    const double zero_m =
        mean ? regime_mean(inputs[i].prepared.signals, config.ranges, static_cast<int>(i) + 1) : config.zero.value_m;
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
  return files;
}

std::vector<Input> prepare_inputs(const Config& config, std::size_t max_memory_bytes, Console& console) {
  std::vector<Input> inputs;
  for (const RecordingConfig& recording : config.recordings)
    inputs.push_back(prepare_input(recording, config, max_memory_bytes, console));
  return inputs;
}

void settle(Config& config, std::vector<Input>& inputs, Console& console) {
  if (config.ranges.empty()) config.ranges = default_ranges(inputs);
  for (std::size_t a = 0; a < config.ranges.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) {
      const dsp::RangeSpec &first = config.ranges[b].spec, &second = config.ranges[a].spec;
      const bool apart = first.to_s <= second.from_s || second.to_s <= first.from_s ||
                         config.ranges[a].recording != config.ranges[b].recording;
      if (!apart) console.note(fmt::format("ranges {} and {} overlap", first.name, second.name));
    }
  settle_terms(config, inputs);
  settle_zero(config, inputs, console);
  settle_prepare(config.prepare, inputs);
}

}  // namespace apps
