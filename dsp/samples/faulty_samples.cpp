#include "dsp/samples/faulty_samples.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <span>
#include <stdexcept>
#include <utility>

#include "dsp/samples/clipping.hpp"
#include "dsp/samples/hold_length.hpp"
#include "dsp/samples/sample_cells.hpp"
#include "dsp/samples/sample_checks.hpp"
#include "dsp/samples/standstill.hpp"

namespace dsp {
namespace {

constexpr std::size_t cells_per_chunk = 4096;  ///< at least five seconds: a dropout does not teach what is usual
constexpr std::size_t least_cells_to_learn = 256;
constexpr Eigen::Index least_dropout_cells = 8, least_dropout_frames = 16;
constexpr Eigen::Index least_equal_frames = 64;
constexpr double max_extreme_fraction = 0.3;  ///< of a record at its extreme value: that is where it rests

// A rounded crest that stands still for eight cells has risen by 2.25 steps over the two cells before (parabola).
bool is_cut_off(const StillRun& run) {
  return run.num_cells() >= 8 && run.rise >= 6.0;
}

Eigen::Index frames_per_cell(double sample_rate_hz) {
  constexpr double cell_s = 1.25e-3;
  return std::max<Eigen::Index>(1, std::llround(cell_s * sample_rate_hz));
}

bool is_prime(Eigen::Index number) {
  for (Eigen::Index divisor = 2; divisor * divisor <= number; ++divisor)
    if (number % divisor == 0) return false;
  return true;
}

// Single steps are drawn this far apart: all where cells are short, else one of about every eighth cell. By a prime, so
// that of values repeated for any number of samples but its multiples all places have their turn.
Eigen::Index frames_per_step(Eigen::Index cell_frames) {
  if (cell_frames < 8) return 1;
  Eigen::Index stride = 8 * cell_frames + 1;
  while (!is_prime(stride)) ++stride;
  return stride;
}

double tolerant(double limit, double tolerance) {
  return std::isfinite(limit) ? limit - tolerance * std::abs(limit) : limit;
}

bool overlaps(const FaultyRange& a, const std::vector<FaultyRange>& others) {
  return std::any_of(others.begin(), others.end(),
                     [&](const FaultyRange& b) { return a.first < b.last && b.first < a.last; });
}

// In order, overlapping and close ones joined.
std::vector<FaultyRange> merged(std::vector<FaultyRange> ranges, Eigen::Index gap) {
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
  ExtremeValue upper, lower;
  std::vector<SampleCell> cells;  // of the chunk
  std::vector<double> steps;      // single ones, drawn from it
  StepScale scale;
  bool has_scale = false;
  Standstill standstill;
  SampleStatistics statistics;

  void follow_chunk() {
    if (cells.empty()) return;
    if (!has_scale || cells.size() >= least_cells_to_learn) scale.learn(cells, steps);
    has_scale = true;
    standstill.follow(cells, scale);
    statistics.follow(cells, steps, scale);
    cells.clear();
    steps.clear();
  }
};

}  // namespace

std::string_view to_string(SampleFault fault) {
  switch (fault) {
    case SampleFault::clipped:
      return "clipped";
    case SampleFault::dropout:
      return "dropout";
    case SampleFault::held:
      break;
  }
  return "held";
}

struct FaultySamples::State {
  double sample_rate_hz;
  FaultySampleOptions options;
  Eigen::Index cell_frames, step_stride, merge_gap, num_frames = 0, num_cells = 0;
  CellCutter cutter;
  std::vector<Track> tracks;
  std::vector<HoldLength> holds;

  State(double rate_hz, std::vector<Channel> channels, const FaultySampleOptions& chosen);
  /// Frames from this one on to the next whose step is drawn.
  [[nodiscard]] Eigen::Index to_next_step(Eigen::Index frame) const {
    return (step_stride - frame % step_stride) % step_stride;
  }
  void take(const Eigen::RowVectorXd& before, const Eigen::Ref<const FrameBlock>& frames,
            std::span<const SampleCell> cells);
  void judge(Eigen::Index c, SampleFaults& faults) const;
  [[nodiscard]] std::vector<FaultyRange> clipped(Eigen::Index c, std::string& remark) const;
  [[nodiscard]] std::vector<FaultyRange> stood_still(Eigen::Index c, std::string& remark) const;
  void add_shorter_crests(Eigen::Index c, std::vector<FaultyRange>& still) const;
  [[nodiscard]] FaultyRange in_frames(Eigen::Index c, SampleFault fault, const StillRun& run) const;
};

FaultySamples::State::State(double rate_hz, std::vector<Channel> channels, const FaultySampleOptions& chosen)
    : sample_rate_hz(rate_hz),
      options(chosen),
      cell_frames(frames_per_cell(rate_hz)),
      step_stride(frames_per_step(cell_frames)),
      merge_gap(std::llround(chosen.merge_gap_s * rate_hz)),
      cutter(cell_frames, static_cast<Eigen::Index>(channels.size())),
      holds(channels.size()) {
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const auto limits = options.limits.empty() ? ChannelLimits{} : options.limits[c];
    tracks.push_back({std::move(channels[c]),
                      ExtremeValue(1.0, tolerant(limits.high, options.limit_tolerance), merge_gap),
                      ExtremeValue(-1.0, tolerant(-limits.low, options.limit_tolerance), merge_gap)});
  }
}

void FaultySamples::State::take(const Eigen::RowVectorXd& before, const Eigen::Ref<const FrameBlock>& frames,
                                std::span<const SampleCell> cells) {
  const std::size_t count = cells.size() / tracks.size();
  for (std::size_t c = 0; c < tracks.size(); ++c) {
    auto& track = tracks[c];
    const auto samples = frames.col(static_cast<Eigen::Index>(c));
    const auto own = cells.subspan(c * count, count);
    const auto row_of = [&](std::size_t k) { return static_cast<Eigen::Index>(k) * cell_frames; };
    double upper = track.upper.least(), lower = track.lower.least();
    for (std::size_t k = 0; k < count; ++k) {
      const bool high = own[k].high >= upper, low = -own[k].low >= lower;
      if (!high && !low) continue;
      const auto in_cell = samples.segment(row_of(k), std::min(cell_frames, samples.size() - row_of(k)));
      if (high) track.upper.scan(in_cell, num_frames + row_of(k));
      if (low) track.lower.scan(in_cell, num_frames + row_of(k));
      upper = track.upper.least();
      lower = track.lower.least();
    }
    for (std::size_t first = 0, taken = 0; first < count; first += taken) {
      taken = std::min(count - first, cells_per_chunk - track.cells.size());
      track.cells.insert(track.cells.end(), own.begin() + first, own.begin() + first + taken);
      const auto end = std::min(row_of(first + taken), samples.size());
      for (Eigen::Index i = row_of(first) + to_next_step(num_frames + row_of(first)); i < end; i += step_stride)
        track.steps.push_back(std::abs(samples(i) - (i > 0 ? samples(i - 1) : before(static_cast<Eigen::Index>(c)))));
      if (track.cells.size() == cells_per_chunk) track.follow_chunk();
    }
  }
  num_frames += frames.rows();
  num_cells += static_cast<Eigen::Index>(count);
}

FaultyRange FaultySamples::State::in_frames(Eigen::Index c, SampleFault fault, const StillRun& run) const {
  // It may have begun anywhere in the cell before, and end anywhere in the one behind.
  const Eigen::Index first = std::max<Eigen::Index>(0, (run.first - 1) * cell_frames);
  const Eigen::Index last = std::min(num_frames, run.last * cell_frames + cell_frames - 1);
  return {c, fault, first, last, run.level};
}

std::vector<FaultyRange> FaultySamples::State::clipped(Eigen::Index c, std::string& remark) const {
  const auto& track = tracks[static_cast<std::size_t>(c)];
  // One sample may be a chance hit; two like updates make a symmetric crest.
  constexpr Eigen::Index at_limit = 2;
  const Eigen::Index usual = track.standstill.usual_cells();
  const double update =
      std::max(track.statistics.repeats(), usual > 1 ? static_cast<double>(usual * cell_frames) : 1.0);
  const auto at_extreme = static_cast<Eigen::Index>(std::ceil(2.5 * update));
  std::vector<FaultyRange> found;
  for (const double sign : {1.0, -1.0}) {
    const auto& side = sign > 0 ? track.upper : track.lower;
    for (const auto& range : side.at_limit().list())
      if (range.longest >= at_limit) found.push_back({c, SampleFault::clipped, range.first, range.last, side.value()});
    if (side.piled_up(at_extreme)) {
      const double fraction = static_cast<double>(side.count()) / static_cast<double>(num_frames);
      if (fraction > max_extreme_fraction)
        remark = fmt::format("; {:.0f} % of the record is at {:.6g} {}: treated as rest", 100 * fraction, side.value(),
                             track.channel.unit);
      else
        for (const auto& range : side.at_extreme().list())
          found.push_back({c, SampleFault::clipped, range.first, range.last, side.value()});
    }
    const double plateau = track.standstill.levels().plateau(sign);
    const auto on_plateau = [&](const StillRun& run) { return sign * run.level >= sign * plateau; };
    const auto& runs = track.standstill.extreme_runs();
    if (std::any_of(runs.begin(), runs.end(), [&](const auto& run) { return on_plateau(run) && is_cut_off(run); }))
      for (const auto& run : runs)
        if (on_plateau(run)) found.push_back(in_frames(c, SampleFault::clipped, run));
  }
  return merged(std::move(found), merge_gap);
}

std::vector<FaultyRange> FaultySamples::State::stood_still(Eigen::Index c, std::string& remark) const {
  const auto& track = tracks[static_cast<std::size_t>(c)];
  const Eigen::Index usual = track.standstill.usual_cells(), long_cells = options.held_updates * usual;
  Eigen::Index num_still = 0;
  for (const auto& run : track.standstill.runs())
    if (run.num_cells() >= long_cells) num_still += run.num_cells();
  const double whole = static_cast<double>(num_cells), fraction = static_cast<double>(num_still) / whole;
  const bool rests = fraction > options.max_held_fraction;
  if (rests) remark = fmt::format("; {:.0f} % of the record is constant: treated as rest", 100 * fraction);
  const bool seldom_equal =
      static_cast<double>(track.standstill.num_equal_cells()) <= options.max_held_fraction * whole;

  // A crest cut off once may be a value held there; at one level again and again it is a limit.
  const auto is_crest = [](const StillRun& run) { return (run.level_in < run.level) == (run.level_out < run.level); };
  const auto recurs = [&](double level) {
    return std::count_if(track.standstill.runs().begin(), track.standstill.runs().end(), [&](const StillRun& run) {
             return is_crest(run) && std::abs(run.level - level) <= 1e-3 * std::abs(level);
           }) >= 2;
  };
  std::vector<FaultyRange> found;
  const double tiny = 1e-3 * (track.statistics.high() - track.statistics.low());
  const auto is_extreme = [&](double level) {
    return level >= track.statistics.high() - tiny || level <= track.statistics.low() + tiny;
  };
  const auto at_limit = [&](const StillRun& run) {
    return (is_crest(run) && is_extreme(run.level)) || recurs(run.level);
  };
  for (const auto& run : track.standstill.runs()) {
    const bool outermost = run.level == 0.0 || is_extreme(run.level);
    const bool jumps = run.jump_in >= jump_ratio || run.jump_out >= jump_ratio;
    if (outermost && run.jump_in >= jump_ratio && run.num_cells() >= least_dropout_cells * usual &&
        run.num_cells() * cell_frames >= least_dropout_frames)
      found.push_back(in_frames(c, SampleFault::dropout, run));
    else if (run.num_cells() >= long_cells && (jumps || (run.abrupt && !rests)))
      found.push_back(in_frames(c, !jumps && at_limit(run) ? SampleFault::clipped : SampleFault::held, run));
    else if (seldom_equal && run.num_equal >= std::max(least_equal_cells, least_equal_frames / cell_frames) &&
             run.abrupt && !jumps)
      found.push_back(in_frames(c, at_limit(run) ? SampleFault::clipped : SampleFault::held, run));
  }
  return found;
}

// Crests that stand still at one level again and again tell a limit: others that get there are clipped, however short.
void FaultySamples::State::add_shorter_crests(Eigen::Index c, std::vector<FaultyRange>& still) const {
  for (const double sign : {1.0, -1.0}) {
    double limit = -std::numeric_limits<double>::infinity();
    for (const FaultyRange& range : still)
      if (range.fault == SampleFault::clipped && sign * range.level > 0.0) limit = std::max(limit, sign * range.level);
    for (const StillRun& run : tracks[static_cast<std::size_t>(c)].standstill.extreme_runs())
      if (sign * run.level >= tolerant(limit, options.limit_tolerance) && std::isfinite(limit))
        still.push_back(in_frames(c, SampleFault::clipped, run));
  }
}

void FaultySamples::State::judge(Eigen::Index c, SampleFaults& faults) const {
  const auto& track = tracks[static_cast<std::size_t>(c)];
  auto checks =
      track.statistics.checks(track.channel, static_cast<double>(cell_frames) / sample_rate_hz, sample_rate_hz);
  faults.checks.insert(faults.checks.end(), checks.begin(), checks.end());
  if (track.statistics.few_values()) return;

  std::string clip_remark, rest_remark;
  const auto clips = clipped(c, clip_remark);
  auto still = stood_still(c, rest_remark);
  add_shorter_crests(c, still);
  std::array<std::vector<FaultyRange>, 3> by_fault;  // each range once: a dropout may look clipped and held, too
  auto &kept_clips = by_fault[0], &dropouts = by_fault[1], &held = by_fault[2];
  std::copy_if(still.begin(), still.end(), std::back_inserter(dropouts),
               [](const auto& x) { return x.fault == SampleFault::dropout; });
  for (const auto& some : {clips, still})
    std::copy_if(some.begin(), some.end(), std::back_inserter(kept_clips),
                 [&](const auto& x) { return x.fault == SampleFault::clipped && !overlaps(x, dropouts); });
  std::copy_if(still.begin(), still.end(), std::back_inserter(held), [&](const auto& x) {
    return x.fault == SampleFault::held && !overlaps(x, kept_clips) && !overlaps(x, dropouts);
  });

  for (const SampleFault fault : {SampleFault::clipped, SampleFault::dropout, SampleFault::held}) {
    const auto ranges = merged(by_fault[static_cast<std::size_t>(fault)], merge_gap);
    Eigen::Index num_samples = 0;
    for (const auto& range : ranges) num_samples += range.last - range.first;
    const double seconds = static_cast<double>(num_samples) / sample_rate_hz;
    std::string message = "none";
    if (!ranges.empty())
      message =
          fmt::format("{} interval{}, {:.6g} s in all, the first at {:.6g} s at {:.6g} {}", ranges.size(),
                      ranges.size() > 1 ? "s" : "", seconds, static_cast<double>(ranges.front().first) / sample_rate_hz,
                      ranges.front().level, track.channel.unit);
    if (fault == SampleFault::clipped) message += clip_remark;
    if (fault == SampleFault::held) message += rest_remark;
    const bool clip = fault == SampleFault::clipped;
    faults.checks.push_back({fmt::format("sample.{}", to_string(fault)), track.channel.name,
                             !ranges.empty()     ? CheckStatus::warning
                             : message != "none" ? CheckStatus::note
                                                 : CheckStatus::ok,
                             clip ? static_cast<double>(num_samples) / static_cast<double>(num_frames) : seconds, 0.0,
                             message});
    for (const auto& range : ranges) {
      faults.ranges.push_back(range);
      faults.bad.push_back({static_cast<double>(range.first) / sample_rate_hz,
                            static_cast<double>(range.last) / sample_rate_hz,
                            fmt::format("{}: {}", track.channel.name, to_string(fault))});
    }
  }
}

FaultySamples::FaultySamples(double sample_rate_hz, std::vector<Channel> channels, const FaultySampleOptions& options) {
  if (!(sample_rate_hz > 0.0) || !std::isfinite(sample_rate_hz))
    throw std::invalid_argument(fmt::format("FaultySamples: sample_rate_hz must be positive, got {}", sample_rate_hz));
  if (channels.empty()) throw std::invalid_argument("FaultySamples: no channels");
  if (!options.limits.empty() && options.limits.size() != channels.size())
    throw std::invalid_argument(
        fmt::format("FaultySamples: limits for {} channels, there are {}", options.limits.size(), channels.size()));
  state_ = std::make_unique<State>(sample_rate_hz, std::move(channels), options);
}
FaultySamples::~FaultySamples() = default;

double FaultySamples::bytes_per_channel(double sample_rate_hz, Eigen::Index num_frames) {
  constexpr double histograms = 4096 * 16 + 1024 * 8;  // of levels and lengths of runs, as Standstill keeps them
  const auto cell_frames = static_cast<double>(frames_per_cell(sample_rate_hz));
  const double cells = static_cast<double>(num_frames) / cell_frames;
  const double steps = cell_frames < 8.0 ? cell_frames : 1.0;  // of a cell, at most
  return sizeof(Track) + histograms +
         (sizeof(SampleCell) + steps * sizeof(double)) * std::min(cells, static_cast<double>(cells_per_chunk));
}

void FaultySamples::push(const Eigen::Ref<const FrameBlock>& frames) {
  if (frames.cols() != static_cast<Eigen::Index>(state_->tracks.size()))
    throw std::invalid_argument(
        fmt::format("FaultySamples: {} columns, want {}", frames.cols(), state_->tracks.size()));
  for (std::size_t c = 0; c < state_->holds.size(); ++c)
    for (Eigen::Index i = 0; i < frames.rows() && !state_->holds[c].holds_none(); ++i)
      state_->holds[c].push(frames(i, static_cast<Eigen::Index>(c)));
  state_->cutter.push(
      frames, [&](const auto& before, const auto& part, const auto& cells) { state_->take(before, part, cells); });
}

SampleFaults FaultySamples::finish() {
  state_->cutter.finish(
      [&](const auto& before, const auto& part, const auto& cells) { state_->take(before, part, cells); });
  SampleFaults faults;
  for (std::size_t c = 0; c < state_->tracks.size(); ++c) {
    state_->tracks[c].follow_chunk();
    state_->tracks[c].standstill.finish();
    if (state_->num_frames > 0) state_->judge(static_cast<Eigen::Index>(c), faults);
    faults.hold_samples.push_back(state_->holds[c].samples());
  }
  return faults;
}

}  // namespace dsp
