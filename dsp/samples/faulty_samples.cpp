#include "dsp/samples/faulty_samples.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>

#include "dsp/samples/clipping.hpp"
#include "dsp/samples/sample_cells.hpp"
#include "dsp/samples/sample_checks.hpp"
#include "dsp/samples/standstill.hpp"

namespace dsp {
namespace {

using Eigen::Index;

constexpr std::size_t cells_per_chunk = 4096;  ///< at least five seconds: a dropout does not teach what is usual
constexpr std::size_t least_cells_to_learn = 256;
constexpr Index least_frames = 10;           ///< fewer may be alike where a slow crest is rounded
constexpr double end_of_range = 1.0 - 5e-4;  ///< 3.998 of 4 V is the end: converters differ by their offset
constexpr double max_edge_width = 0.02;      ///< of the values' range: a wider one holds motion, not only noise
constexpr double max_edge_share = 0.3;       ///< of a record at its extreme value: that is where it rests
constexpr double crest_updates = 2.5;        ///< two like updates make a symmetric crest, three do not
constexpr Index least_crest_cells = 8;       ///< fewer do not tell how often a level is met

Index frames_per_cell(double sample_rate_hz) {
  constexpr double cell_s = 1.25e-3;
  return std::max<Index>(1, std::llround(cell_s * sample_rate_hz));
}

// Single steps are drawn this far apart: all where cells are short, else one of about every eighth cell. By a prime, so
// that of values repeated for any number of samples but its multiples all places have their turn.
Index frames_per_step(Index cell_frames) {
  const auto is_prime = [](Index number) {
    for (Index divisor = 2; divisor * divisor <= number; ++divisor)
      if (number % divisor == 0) return false;
    return true;
  };
  if (cell_frames < 8) return 1;
  Index stride = 8 * cell_frames + 1;
  while (!is_prime(stride)) ++stride;
  return stride;
}

// In order, overlapping and close ones joined.
std::vector<FaultyRange> merged(std::vector<FaultyRange> ranges, Index gap) {
  std::sort(ranges.begin(), ranges.end(),
            [](const auto& a, const auto& b) { return std::pair(a.first, a.last) < std::pair(b.first, b.last); });
  std::vector<FaultyRange> result;
  for (const auto& range : ranges)
    if (!result.empty() && range.first - result.back().last <= gap)
      result.back().last = std::max(result.back().last, range.last);
    else
      result.push_back(range);
  return result;
}

// One channel's way through the record.
struct Track {
  Channel channel;
  std::array<HistogramEdge, 2> edges;
  std::vector<SampleCell> cells;  // of the chunk, behind some of the one before
  std::vector<double> steps;      // single ones, drawn from it
  Index first_frame = 0;          // of the chunk
  StepScale scale;
  bool has_scale = false;
  Standstill standstill;
  SampleStatistics statistics;

  [[nodiscard]] std::size_t num_new() const { return cells.size() - std::min(cells.size(), Standstill::context); }
  void take(const SampleCell& cell) {
    const SampleCell calm{cell.low, cell.low, cell.low, 0.0};
    if (cells.empty()) cells.assign(Standstill::context, calm);
    cells.push_back(cell);
  }
  void follow_chunk(Index cell_frames) {
    if (num_new() == 0) return;
    const auto chunk = std::span<const SampleCell>(cells).subspan(Standstill::context);
    if (!has_scale || chunk.size() >= least_cells_to_learn) scale.learn(chunk, steps);
    has_scale = true;
    standstill.follow(cells, scale);
    statistics.follow(chunk, steps, scale);
    for (HistogramEdge& edge : edges) edge.set_width(2.0 * scale.floor);
    for (const SampleCell& cell : chunk) {
      if (edges[0].width() == 0.0) break;  // looked at sample by sample
      edges[0].look(cell.high, first_frame, cell_frames);
      edges[1].look(-cell.low, first_frame, cell_frames);
      first_frame += cell_frames;
    }
    cells.erase(cells.begin(), cells.end() - Standstill::context);
    steps.clear();
  }
  [[nodiscard]] bool is_extreme(double level) const {
    const double tiny = 1e-3 * (statistics.high() - statistics.low());
    return level >= statistics.high() - tiny || level <= statistics.low() + tiny;
  }
  [[nodiscard]] bool is_dropout(const StillRun& run) const {
    return (run.level == 0.0 || is_extreme(run.level)) && run.jumps(run.before);
  }
  [[nodiscard]] bool is_clipped(const StillRun& run) const { return is_extreme(run.level) && run.is_cut_crest(); }
  // Few cells reach the edge.
  void look_at_edges(const Eigen::Ref<const Eigen::VectorXd, 0, Eigen::InnerStride<>>& samples, const SampleCell& cell,
                     Index first) {
    if (edges[0].width() > 0.0 || (cell.high < edges[0].least() && -cell.low < edges[1].least())) return;
    for (Index i = 0; i < samples.size(); ++i) {
      if (samples(i) >= edges[0].least()) edges[0].look(samples(i), first + i, 1);
      if (-samples(i) >= edges[1].least()) edges[1].look(-samples(i), first + i, 1);
    }
  }
};

}  // namespace

std::string_view to_string(SampleFault fault) {
  static constexpr std::array<std::string_view, 3> names{"clipped", "dropout", "held"};
  return names[static_cast<std::size_t>(fault)];
}

struct FaultySamples::State {
  double sample_rate_hz;
  Index cell_frames, step_stride, merge_gap, num_frames = 0;
  CellCutter cutter;
  std::vector<Track> tracks;

  State(double rate_hz, std::vector<Channel> channels, double merge_gap_s);
  void take(const Eigen::RowVectorXd& before, const Eigen::Ref<const FrameBlock>& frames,
            std::span<const SampleCell> cells);
  void judge(Index c, SampleFaults& faults) const;
  [[nodiscard]] RunLengths habit(Index c) const;
  void add_clipped(Index c, std::vector<FaultyRange>& found, std::string& remark) const;
  void add_stood_still(Index c, std::vector<FaultyRange>& found) const;
  void report(Index c, SampleFault fault, const std::vector<FaultyRange>& found, const std::string& remark,
              SampleFaults& faults) const;
};

FaultySamples::State::State(double rate_hz, std::vector<Channel> channels, double merge_gap_s)
    : sample_rate_hz(rate_hz),
      cell_frames(frames_per_cell(rate_hz)),
      step_stride(frames_per_step(cell_frames)),
      merge_gap(std::llround(merge_gap_s * rate_hz)),
      cutter(cell_frames, static_cast<Index>(channels.size())) {
  for (Channel& channel : channels) {
    const double limit = channel.range > 0.0 ? end_of_range * channel.range : std::numeric_limits<double>::infinity();
    tracks.push_back(
        {std::move(channel), {HistogramEdge(1.0, limit, merge_gap), HistogramEdge(-1.0, limit, merge_gap)}});
  }
}

void FaultySamples::State::take(const Eigen::RowVectorXd& before, const Eigen::Ref<const FrameBlock>& frames,
                                std::span<const SampleCell> cells) {
  const std::size_t count = cells.size() / tracks.size();
  for (std::size_t c = 0; c < tracks.size(); ++c) {
    auto& track = tracks[c];
    const auto samples = frames.col(static_cast<Index>(c));
    Index to_step = (step_stride - num_frames % step_stride) % step_stride;
    for (std::size_t k = 0; k < count; ++k) {
      const SampleCell& cell = cells[c * count + k];
      const Index first = static_cast<Index>(k) * cell_frames, size = std::min(cell_frames, samples.size() - first);
      track.look_at_edges(samples.segment(first, size), cell, num_frames + first);
      track.take(cell);
      for (; to_step < first + size; to_step += step_stride)
        track.steps.push_back(
            std::abs(samples(to_step) - (to_step > 0 ? samples(to_step - 1) : before(static_cast<Index>(c)))));
      if (track.num_new() == cells_per_chunk) track.follow_chunk(cell_frames);
    }
  }
  num_frames += frames.rows();
}

void FaultySamples::State::add_clipped(Index c, std::vector<FaultyRange>& found, std::string& remark) const {
  const auto& track = tracks[static_cast<std::size_t>(c)];
  const Index usual = habit(c).usual(num_frames / cell_frames);
  const double update =
      std::max(track.statistics.repeats(), usual > 1 ? static_cast<double>(usual * cell_frames) : 1.0);
  for (const HistogramEdge& edge : track.edges) {
    const auto add = [&](const SampleRanges& ranges) {
      for (const IndexRange& range : ranges.list())
        found.push_back({c, SampleFault::clipped, range.first, std::min(range.last, num_frames), edge.value()});
    };
    if (edge.at_limit().longest() > 1) add(edge.at_limit());                          // one sample may be chance
    const Index resolved = edge.width() > 0.0 ? least_crest_cells * cell_frames : 1;  // looked at cell by cell
    if (edge.width() > max_edge_width * (track.statistics.high() - track.statistics.low())) continue;
    if (!edge.piles_up(std::max(resolved, static_cast<Index>(std::ceil(crest_updates * update))))) continue;
    const double share = static_cast<double>(edge.count()) / static_cast<double>(num_frames);
    if (share <= max_edge_share)
      add(edge.at_edge());
    else
      remark = fmt::format("; {:.0f} % of the record is at {:.6g} {}: treated as rest", 100 * share, edge.value(),
                           track.channel.unit);
  }
}

// A dropout and a crest cut off are none, unless it rests there.
RunLengths FaultySamples::State::habit(Index c) const {
  const auto& track = tracks[static_cast<std::size_t>(c)];
  RunLengths habit = track.standstill.short_runs(), all = habit;
  Index num_cut = 0;
  for (const StillRun& run : track.standstill.runs()) {
    all.add(run.num_cells());
    if (track.is_dropout(run) || run.is_cut_crest())
      num_cut += run.num_cells() * cell_frames;
    else
      habit.add(run.num_cells());
  }
  return static_cast<double>(num_cut) > max_edge_share * static_cast<double>(num_frames) ? all : habit;
}

void FaultySamples::State::add_stood_still(Index c, std::vector<FaultyRange>& found) const {
  const auto& track = tracks[static_cast<std::size_t>(c)];
  const double repeated = std::pow(1.0 - 1.0 / track.statistics.repeats(), static_cast<double>(cell_frames));
  const Index least = habit(c).least_improbable(num_frames / cell_frames, repeated);
  // A crest cut off once may be a value held there; at one level again and again it is a limit.
  const auto recurs = [&](double level) {
    return std::count_if(track.standstill.runs().begin(), track.standstill.runs().end(), [&](const StillRun& run) {
             return run.is_cut_crest() && std::abs(run.level - level) <= 1e-3 * std::abs(level);
           }) >= 2;
  };
  for (const StillRun& run : track.standstill.runs()) {
    if (run.num_cells() < least || run.num_cells() * cell_frames < least_frames) continue;
    const bool is_cut = run.first > 1 ? run.is_cut(run.before) || run.is_cut(run.after) : run.jumps(run.after);
    const bool is_dropout = track.is_dropout(run);
    if (!is_dropout && !is_cut) continue;
    const bool is_clipped = track.is_clipped(run) || (run.is_cut_crest() && recurs(run.level));
    const SampleFault fault = is_dropout ? SampleFault::dropout : is_clipped ? SampleFault::clipped : SampleFault::held;
    // It may have begun anywhere in the cell before, and end anywhere in the one behind.
    found.push_back({c, fault, std::max<Index>(0, (run.first - 1) * cell_frames),
                     std::min(num_frames, (run.last + 1) * cell_frames - 1), run.level});
  }
}

void FaultySamples::State::judge(Index c, SampleFaults& faults) const {
  const auto& track = tracks[static_cast<std::size_t>(c)];
  auto checks =
      track.statistics.checks(track.channel, static_cast<double>(cell_frames) / sample_rate_hz, sample_rate_hz);
  faults.checks.insert(faults.checks.end(), checks.begin(), checks.end());
  if (track.statistics.few_values()) return;
  std::string remark;
  std::vector<FaultyRange> found;
  add_clipped(c, found, remark);
  add_stood_still(c, found);
  // Each range once: a dropout may look clipped, and a crest cut off held.
  std::vector<FaultyRange> said;
  for (const SampleFault fault : {SampleFault::dropout, SampleFault::clipped, SampleFault::held}) {
    std::vector<FaultyRange> own;
    std::copy_if(found.begin(), found.end(), std::back_inserter(own), [&](const FaultyRange& range) {
      return range.fault == fault && std::none_of(said.begin(), said.end(), [&](const FaultyRange& other) {
               return range.first < other.last && other.first < range.last;
             });
    });
    own = merged(std::move(own), merge_gap);
    said.insert(said.end(), own.begin(), own.end());
  }
  for (const SampleFault fault : {SampleFault::clipped, SampleFault::dropout, SampleFault::held})
    report(c, fault, said, fault == SampleFault::clipped ? remark : "", faults);
}

void FaultySamples::State::report(Index c, SampleFault fault, const std::vector<FaultyRange>& found,
                                  const std::string& remark, SampleFaults& faults) const {
  const Channel& channel = tracks[static_cast<std::size_t>(c)].channel;
  Index num_samples = 0;
  const std::size_t before = faults.ranges.size();
  for (const FaultyRange& range : found) {
    if (range.fault != fault) continue;
    num_samples += range.last - range.first;
    faults.ranges.push_back(range);
    faults.bad.push_back({static_cast<double>(range.first) / sample_rate_hz,
                          static_cast<double>(range.last) / sample_rate_hz,
                          fmt::format("{}: {}", channel.name, to_string(fault))});
  }
  const std::size_t count = faults.ranges.size() - before;
  const double seconds = static_cast<double>(num_samples) / sample_rate_hz;
  const std::string message =
      count == 0 ? "none"
                 : fmt::format("{} interval{}, {:.6g} s in all, the first at {:.6g} s at {:.6g} {}", count,
                               count > 1 ? "s" : "", seconds, faults.bad[faults.bad.size() - count].from_s,
                               faults.ranges[before].level, channel.unit);
  faults.checks.push_back(
      {fmt::format("sample.{}", to_string(fault)), channel.name,
       count > 0         ? CheckStatus::warning
       : !remark.empty() ? CheckStatus::note
                         : CheckStatus::ok,
       fault == SampleFault::clipped ? static_cast<double>(num_samples) / static_cast<double>(num_frames) : seconds,
       0.0, message + remark});
}

FaultySamples::FaultySamples(double sample_rate_hz, std::vector<Channel> channels, double merge_gap_s) {
  if (!(sample_rate_hz > 0.0) || !std::isfinite(sample_rate_hz))
    throw std::invalid_argument(fmt::format("FaultySamples: sample_rate_hz must be positive, got {}", sample_rate_hz));
  if (channels.empty()) throw std::invalid_argument("FaultySamples: no channels");
  state_ = std::make_unique<State>(sample_rate_hz, std::move(channels), merge_gap_s);
}
FaultySamples::~FaultySamples() = default;

double FaultySamples::bytes_per_channel(double sample_rate_hz, Index num_frames) {
  constexpr double lengths_of_runs = 1024 * 8;
  const auto cell_frames = static_cast<double>(frames_per_cell(sample_rate_hz));
  const double cells = static_cast<double>(num_frames) / cell_frames;
  const double steps = cell_frames < 8.0 ? cell_frames : 1.0;  // of a cell, at most
  return sizeof(Track) + lengths_of_runs +
         (sizeof(SampleCell) + steps * sizeof(double)) * std::min(cells, static_cast<double>(cells_per_chunk));
}

void FaultySamples::push(const Eigen::Ref<const FrameBlock>& frames) {
  if (frames.cols() != static_cast<Index>(state_->tracks.size()))
    throw std::invalid_argument(
        fmt::format("FaultySamples: {} columns, want {}", frames.cols(), state_->tracks.size()));
  state_->cutter.push(
      frames, [&](const auto& before, const auto& part, const auto& cells) { state_->take(before, part, cells); });
}

SampleFaults FaultySamples::finish() {
  state_->cutter.finish(
      [&](const auto& before, const auto& part, const auto& cells) { state_->take(before, part, cells); });
  SampleFaults faults;
  for (std::size_t c = 0; c < state_->tracks.size(); ++c) {
    state_->tracks[c].follow_chunk(state_->cell_frames);
    state_->tracks[c].standstill.finish();
    if (state_->num_frames > 0) state_->judge(static_cast<Index>(c), faults);
  }
  return faults;
}

}  // namespace dsp
