#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "dsp/filter/decimate.hpp"
#include "dsp/io/channel_bodies.hpp"
#include "dsp/io/read_recording.hpp"
#include "dsp/prepare.hpp"
#include "dsp/prepare/intermediate_recorder.hpp"
#include "dsp/prepare/prepare_filters.hpp"
#include "dsp/values/memory_limit.hpp"

// From a recording to the intermediate rate, in one pass for all ways of preparing.

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

std::int64_t fewest_samples(const ColumnFilter& filter, const std::optional<FilterSheet>& raw, double sample_rate_hz) {
  constexpr std::int64_t fewest = 8;
  const double reach_s = std::max(raw ? raw->edge_s : 0.0, filter.edge_s());
  return std::max(fewest, static_cast<std::int64_t>(std::ceil(reach_s * sample_rate_hz)) + 1);
}

void require_length(const Recording& description, Index num_frames, const ColumnFilter& filter,
                    const std::optional<FilterSheet>& raw) {
  constexpr Index some = 200;  // fewer make no equation, whatever the filters
  const Index least = fewest_samples(filter, raw, description.sample_rate_hz);
  if (num_frames >= least) return;
  throw Fault(FaultKind::input, "sample.too_few",
              num_frames < some
                  ? fmt::format("{}: {} samples are too few for an equation. Record some hundred, over many cycles",
                                description.name, num_frames)
                  : fmt::format("{}: {} samples, the filters need at least {}; ask for a higher rate_hz or cutoff_hz",
                                description.name, num_frames, least));
}

// A dead base is only reported: a bench at rest is one.
void require_moving(const Recording& intermediate) {
  for (const auto& check : intermediate.checks) {
    if (check.name != "sample.constant") continue;
    const auto channel = std::find_if(intermediate.channels.begin(), intermediate.channels.end(),
                                      [&](const Channel& other) { return other.name == check.channel; });
    const Role role = channel->role;
    const bool needed = role == Role::x || role == Role::y || role == Role::a || role == Role::ddy ||
                        (role == Role::ddr && intermediate.find(Role::ddy) >= 0);
    if (needed)
      throw Fault(
          FaultKind::input, "sample.constant",
          fmt::format("{}: channel '{}', role {}, never moves: {}. Choose another by use = {{ {} = \"...\" }} or "
                      "leave it out of the sidecar",
                      intermediate.name, channel->name, to_string(role), check.message, to_string(role)));
  }
}

/// An intermediate recording being filled, for all ways of preparing that share it.
struct Filling {
  std::optional<DecimateOptions> filter;
  std::unique_ptr<IntermediateRecorder> recorder;
};

// One for each filter that `options` ask for; `served_by`: which of them serves each.
std::vector<Filling> fillings(const Recording& description, Index num_frames,
                              const std::vector<PrepareOptions>& options, std::vector<std::size_t>& served_by) {
  std::vector<Filling> result;
  for (const PrepareOptions& asked : options) {
    const PrepareOptions o = resolved(asked, description.sample_rate_hz);
    const auto filter = to_intermediate(o, description.sample_rate_hz);
    const auto same = std::find_if(result.begin(), result.end(), [&](const Filling& f) { return f.filter == filter; });
    served_by.push_back(static_cast<std::size_t>(same - result.begin()));
    if (same == result.end())
      result.push_back({filter, std::make_unique<IntermediateRecorder>(description, num_frames, filter)});
    require_length(description, num_frames, column_filter(o), result[served_by.back()].recorder->sheet());
  }
  return result;
}

IntermediateRecording filled(Filling& filling, const Recording& known) {
  IntermediateRecording intermediate{filling.recorder->finish(), known.sample_rate_hz,         filling.filter,
                                     filling.recorder->sheet(),  filling.recorder->spectrum(), {}};
  Recording& recording = intermediate.recording;
  require_moving(recording);
  for (const auto& range : filling.recorder->faulty_ranges())
    if (range.fault == SampleFault::clipped)
      intermediate.clipped.push_back({static_cast<double>(range.first) / known.sample_rate_hz,
                                      static_cast<double>(range.last) / known.sample_rate_hz,
                                      recording.channels[static_cast<std::size_t>(range.channel)].name});
  recording.bad.insert(recording.bad.begin(), known.bad.begin(), known.bad.end());
  recording.checks.insert(recording.checks.begin(), known.checks.begin(), known.checks.end());
  return intermediate;
}

// While a file is read: the channels at the intermediate rate, and what is gathered of each.
double reading_bytes(const Recording& description, Index num_frames, double intermediate_rate_hz) {
  const double rate_hz = description.sample_rate_hz;
  const double gathered =
      FaultySamples::bytes_per_channel(rate_hz, num_frames) + RawSpectrum::bytes_per_channel(rate_hz, num_frames);
  return static_cast<double>(description.channels.size()) *
         (sizeof(double) * static_cast<double>(num_frames) * intermediate_rate_hz / rate_hz + gathered);
}

// The intermediate rate holds the channels, and so does what is made of it: x, v, a, y, dy, ddy and t, and r, dr, ddr
// where there is a base, once there and once filtered; four more pass through a filter at a time.
double prepared_bytes(const Recording& description, Index num_frames, double intermediate_rate_hz) {
  const bool base =
      description.find(Role::r) >= 0 || description.find(Role::dr) >= 0 || description.find(Role::ddr) >= 0;
  const double columns = 2.0 * (static_cast<double>(description.channels.size()) + (base ? 10.0 : 7.0)) + 4.0;
  return sizeof(double) * columns * static_cast<double>(num_frames) * intermediate_rate_hz / description.sample_rate_hz;
}

}  // namespace

std::int64_t fewest_samples(const PrepareOptions& options, double sample_rate_hz) {
  const PrepareOptions o = resolved(options, sample_rate_hz);
  const auto filter = to_intermediate(o, sample_rate_hz);
  std::optional<FilterSheet> raw;
  if (filter) {
    const Decimator decimator(sample_rate_hz, 1, *filter);
    raw = decimator.sheet();
  }
  return fewest_samples(column_filter(o), raw, sample_rate_hz);
}

Prepared prepare(const Recording& recording, const PrepareOptions& options) {
  const Index n = recording.samples.rows();
  std::vector<std::size_t> served_by;
  std::vector<Filling> filling = fillings(recording, n, {options}, served_by);
  constexpr Index block = 8192;
  for (Index first = 0; first < n; first += block)
    filling.front().recorder->push(FrameBlock(recording.samples.middleRows(first, std::min(block, n - first))));
  return prepare(filled(filling.front(), recording), options);
}

std::vector<std::shared_ptr<IntermediateRecording>> read_intermediate(RecordingReader& reader,
                                                                      const std::vector<PrepareOptions>& options,
                                                                      const StreamOptions& stream) {
  require_one_body(reader.description());
  const Recording& description = reader.description();
  const auto num_frames = static_cast<Index>(reader.num_frames());
  std::vector<double> reading;
  for (const PrepareOptions& asked : options) {
    const double intermediate_rate_hz = resolved(asked, description.sample_rate_hz).intermediate_rate_hz;
    reading.push_back(reading_bytes(description, num_frames, intermediate_rate_hz));
    require_memory(description.name,
                   std::max(reading.back(), prepared_bytes(description, num_frames, intermediate_rate_hz)),
                   stream.max_memory_bytes);
  }
  std::vector<std::size_t> served_by;
  std::vector<Filling> filling = fillings(description, num_frames, options, served_by);
  double bytes = 0.0;
  for (std::size_t i = 0; i < filling.size(); ++i)  // ways that share one fill it together
    bytes += reading[static_cast<std::size_t>(std::find(served_by.begin(), served_by.end(), i) - served_by.begin())];
  reader.set_bytes_beside(bytes);
  FrameBlock block;
  Index done = 0;
  while (const Index count = reader.read(block, stream.block_frames)) {
    for (Filling& one : filling) one.recorder->push(block.topRows(count));
    done += count;
    if (stream.progress) stream.progress(static_cast<double>(done) / static_cast<double>(num_frames));
  }
  std::vector<std::shared_ptr<IntermediateRecording>> full, result;
  for (Filling& one : filling)
    full.push_back(std::make_shared<IntermediateRecording>(filled(one, reader.description())));
  for (const std::size_t i : served_by) result.push_back(full[i]);
  return result;
}

Prepared prepare(RecordingReader& reader, const PrepareOptions& options, const StreamOptions& stream) {
  const auto intermediate = read_intermediate(reader, {options}, stream).front();
  return prepare(std::move(*intermediate), options, stream.num_threads);
}

}  // namespace dsp
