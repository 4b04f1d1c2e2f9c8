#include "dsp/filter/decimate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "dsp/filter/burg.hpp"
#include "dsp/filter/decimate_between.hpp"
#include "dsp/filter/dispatch.hpp"
#include "dsp/filter/filter_design.hpp"
#include "dsp/filter/lanes.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// out[n][c] = sum_i taps[i] x[i + n hop][c] for C neighbouring channels of frames `stride` apart and N outputs, which
// share the taps as they are loaded. Each in four partial sums that are added last: one order whatever the block, and
// chains for the processor to overlap.
template <int C, int N>
inline __attribute__((always_inline)) void weigh(const double* x, Index stride, Index hop, const double* taps,
                                                 Index length, double* out) {
  typedef double Channels __attribute__((vector_size(C * sizeof(double)), aligned(8), may_alias));
  Channels sums[N][4] = {};
  const auto add = [&](Index i, int part) {
    for (int n = 0; n < N; ++n)
      sums[n][part] += taps[i] * *reinterpret_cast<const Channels*>(x + (i + n * hop) * stride);
  };
  Index i = 0;
  for (; i + 4 <= length; i += 4)
    for (int part = 0; part < 4; ++part) add(i + part, part);
  for (; i < length; ++i) add(i, 0);
  for (int n = 0; n < N; ++n)
    *reinterpret_cast<Channels*>(out + n * stride) = (sums[n][0] + sums[n][1]) + (sums[n][2] + sums[n][3]);
}

template <int N>
inline __attribute__((always_inline)) void weigh_channels(const double* x, Index num_channels, Index hop,
                                                          const double* taps, Index length, double* out) {
  Index c = 0;
  for (; c + 4 <= num_channels; c += 4) weigh<4, N>(x + c, num_channels, hop, taps, length, out + c);
  for (; c + 2 <= num_channels; c += 2) weigh<2, N>(x + c, num_channels, hop, taps, length, out + c);
  for (; c < num_channels; ++c) weigh<1, N>(x + c, num_channels, hop, taps, length, out + c);
}

// The same for a single channel, whose rows are neighbours: eight partial sums, one a lane of two vectors (where the
// processor has none so wide, a vector of eight goes through memory).
template <int N>
inline __attribute__((always_inline)) void weigh_one(const double* x, Index hop, const double* taps, Index length,
                                                     double* out) {
  UnalignedLanes sums[N][2] = {};
  Index i = 0;
  for (; i + 8 <= length; i += 8)
    for (int half = 0; half < 2; ++half) {
      const UnalignedLanes weights = *reinterpret_cast<const UnalignedLanes*>(taps + i + 4 * half);
      for (int n = 0; n < N; ++n)
        sums[n][half] += weights * *reinterpret_cast<const UnalignedLanes*>(x + i + 4 * half + n * hop);
    }
  for (int n = 0; n < N; ++n) {
    const UnalignedLanes &low = sums[n][0], &high = sums[n][1];
    double sum = ((low[0] + low[1]) + (low[2] + low[3])) + ((high[0] + high[1]) + (high[2] + high[3]));
    for (Index k = i; k < length; ++k) sum += taps[k] * x[k + n * hop];
    out[n] = sum;
  }
}

// `count` outputs in a row, their rows `hop` apart.
ARDENT_DISPATCH void weigh_all(const double* x, Index num_channels, Index hop, const double* taps, Index length,
                               Index count, double* out) {
  Index n = 0;
  if (num_channels == 1) {
    constexpr int together = 4;  // one alone waits for its sums
    for (; n + together <= count; n += together) weigh_one<together>(x + n * hop, hop, taps, length, out + n);
    for (; n < count; ++n) weigh_one<1>(x + n * hop, hop, taps, length, out + n);
    return;
  }
  constexpr int together = 2;
  for (; n + together <= count; n += together)
    weigh_channels<together>(x + n * hop * num_channels, num_channels, hop, taps, length, out + n * num_channels);
  for (; n < count; ++n)
    weigh_channels<1>(x + n * hop * num_channels, num_channels, hop, taps, length, out + n * num_channels);
}

// One stage of the stream. Rows are numbered from the record's first; the buffer begins at row first_.
constexpr Index fitted_rows = 4096;  // a predictor is fitted to these

class StageStream {
 public:
  StageStream(FilterStage stage, Index num_channels)
      : stage_(std::move(stage)), num_channels_(num_channels), half_((stage_.taps.rows() - 1) / 2) {}

  /// In the middle of a record, of which rows from this one on are pushed. Returns the first output that they make.
  Index begin_at(Index row) {
    first_ = received_ = row;
    begun_ = true;
    next_ = (row + half_) * stage_.up / stage_.down;
    while (next_ * stage_.down / stage_.up - half_ < row) ++next_;
    return next_;
  }

  void push(const double* rows, Index count, std::vector<double>& out) {
    if (!begun_) {
      append(rows, count);
      if (received_ < fitted_rows) return;
      begin();
      produce(buffer_.data(), first_, received_, out);
    } else {
      // Outputs that reach back before this block come from the buffer, the others from the block where it lies.
      const Index block_first = received_, seam = std::min(count, 2 * half_);
      append(rows, seam);
      produce(buffer_.data(), first_, received_, out);
      produce(rows, block_first, block_first + count, out);
      append(rows + seam * num_channels_, count - seam);
    }
    forget();
  }

  void finish(std::vector<double>& out) {
    if (received_ == 0) return;
    if (!begun_) begin();
    num_outputs_ = (received_ - 1) * stage_.up / stage_.down + 1;
    const RowMajor after = beyond(false);
    append(after.data(), after.rows());
    produce(buffer_.data(), first_, received_, out);
  }

 private:
  Index rows_held() const { return static_cast<Index>(buffer_.size()) / num_channels_; }

  // half_ rows before the first or after the last.
  RowMajor beyond(bool before) const {
    const Eigen::Map<const RowMajor> held(buffer_.data(), rows_held(), num_channels_);
    const Index count = std::min(fitted_rows, rows_held());
    const RowMajor known = before ? held.topRows(count) : held.bottomRows(count);
    RowMajor made(half_, num_channels_);
    constexpr Index order = 128;
    const ExtensionOptions how{half_, std::min(order, count / 4), count};
    for (Index c = 0; c < num_channels_; ++c) {
      const VectorXd x = known.col(c);
      const double mean = x.mean();
      const VectorXd centred = x.array() - mean;
      made.col(c) = (before ? extend_before(centred, how) : extend_after(centred, how)).array() + mean;
    }
    return made;
  }

  void begin() {
    const RowMajor before = beyond(true);
    buffer_.insert(buffer_.begin(), before.data(), before.data() + before.size());
    first_ = -half_;
    begun_ = true;
  }

  void append(const double* rows, Index count) {
    // Of a long block only what the next outputs or the end's predictor need.
    const Index skipped = begun_ ? std::max<Index>(0, count - rows_kept()) : 0;
    if (skipped > 0) {
      buffer_.clear();
      first_ = received_ + skipped;
    }
    buffer_.insert(buffer_.end(), rows + skipped * num_channels_, rows + count * num_channels_);
    received_ += count;
  }

  Index rows_kept() const { return std::max(fitted_rows, 2 * half_ + 1); }

  void forget() {
    const Index done = rows_held() - rows_kept();
    if (done < rows_held() / 2) return;
    buffer_.erase(buffer_.begin(), buffer_.begin() + done * num_channels_);
    first_ += done;
  }

  // All outputs whose rows lie in [first, end), read from `rows`; with up = 1 in one go.
  void produce(const double* rows, Index first, Index end, std::vector<double>& out) {
    while (next_ < num_outputs_) {
      const Index centre = next_ * stage_.down / stage_.up, phase = next_ * stage_.down % stage_.up;
      if (centre + half_ >= end || centre - half_ < first) return;
      const Index room = stage_.up == 1 ? (end - 1 - half_ - centre) / stage_.down + 1 : 1;
      const Index count = std::min(room, num_outputs_ - next_);
      const std::size_t begin = out.size();
      out.resize(begin + static_cast<std::size_t>(count * num_channels_));
      weigh_all(rows + (centre - half_ - first) * num_channels_, num_channels_, stage_.down,
                stage_.taps.col(phase).data(), stage_.taps.rows(), count, out.data() + begin);
      next_ += count;
    }
  }

  FilterStage stage_;
  Index num_channels_, half_, first_ = 0, received_ = 0, next_ = 0;
  Index num_outputs_ = std::numeric_limits<Index>::max();
  bool begun_ = false;
  std::vector<double> buffer_;
};

/// The stages, each fed by the one before.
struct Cascade {
  std::vector<StageStream> stages;
  Index num_channels = 0;

  Cascade(const FilterSheet& design, Index channels) : num_channels(channels) {
    if (num_channels < 1) throw std::invalid_argument("Decimator: num_channels must be at least 1");
    for (const FilterStage& stage : design.stages) stages.emplace_back(stage, num_channels);
  }
  FrameBlock run(const double* rows, Index count, bool last) {
    std::vector<double> in, out;
    for (std::size_t i = 0; i < stages.size(); ++i) {
      out.clear();
      if (count > 0) stages[i].push(rows, count, out);
      if (last) stages[i].finish(out);
      in.swap(out);
      rows = in.data();
      count = static_cast<Index>(in.size()) / num_channels;
    }
    return Eigen::Map<const FrameBlock>(in.data(), count, num_channels);
  }
};

void require_length(const FilterSheet& design, Index num_frames) {
  const double reach = design.stages.empty() ? 0.0 : design.edge_s * design.stages.front().input_rate_hz;
  const Index least = std::max<Index>(8, static_cast<Index>(std::ceil(reach)) + 1);
  if (num_frames < least)
    throw std::invalid_argument(
        fmt::format("decimate: {} samples are fewer than the filter is long; {} are the least", num_frames, least));
}

/// Of a record of so many samples.
Index num_outputs(const FilterSheet& design, Index num_samples) {
  for (const FilterStage& stage : design.stages) num_samples = (num_samples - 1) * stage.up / stage.down + 1;
  return num_samples;
}

/// What some outputs of a cascade lean on.
struct Feed {
  Index first, end;    ///< of its input
  bool before, after;  ///< whether something is to be predicted beyond the record's start, its end
};

/// Outputs [first, end) of a record of so many samples.
Feed feed_of(const FilterSheet& design, Index first, Index end, Index num_samples) {
  std::vector<Index> lengths{num_samples};
  for (const FilterStage& stage : design.stages) lengths.push_back((lengths.back() - 1) * stage.up / stage.down + 1);
  Feed feed{first, end, false, end >= lengths.back()};
  bool enough_before = true, enough_after = true;  // of what predictors are fitted to
  for (std::size_t i = design.stages.size(); i-- > 0;) {
    const FilterStage& stage = design.stages[i];
    const Index half = (stage.taps.rows() - 1) / 2;
    feed.first = feed.first * stage.down / stage.up - half;
    feed.end = (feed.end - 1) * stage.down / stage.up + half + 1;
    feed.before = feed.before || feed.first < 0;
    feed.after = feed.after || feed.end > lengths[i];
    feed.first = std::max<Index>(0, feed.first);
    feed.end = std::min(feed.end, lengths[i]);
    enough_before = enough_before && feed.end >= fitted_rows;
    enough_after = enough_after && lengths[i] - feed.first >= fitted_rows;
  }
  if (feed.before && !enough_before) feed.after = true;
  if (feed.after && !enough_after) feed.before = true;
  if (feed.before) feed.first = 0;
  if (feed.after) feed.end = num_samples;
  return feed;
}

}  // namespace

struct Decimator::State {
  FilterSheet sheet;
  Cascade cascade;
  Index num_frames = 0;
};

Decimator::Decimator(double input_rate_hz, Index num_channels, const DecimateOptions& options)
    : Decimator(measure(design_decimation(input_rate_hz, options), input_rate_hz, options), num_channels) {}

Decimator::Decimator(const FilterSheet& design, Index num_channels)
    : state_(new State{design, Cascade(design, num_channels)}) {}

Decimator::~Decimator() = default;
Decimator::Decimator(Decimator&&) noexcept = default;
Decimator& Decimator::operator=(Decimator&&) noexcept = default;

FrameBlock Decimator::push(const Eigen::Ref<const FrameBlock>& frames) {
  Cascade& cascade = state_->cascade;
  if (frames.cols() != cascade.num_channels)
    throw std::invalid_argument(
        fmt::format("Decimator::push: {} channels, expected {}", frames.cols(), cascade.num_channels));
  state_->num_frames += frames.rows();
  if (frames.outerStride() == frames.cols()) return cascade.run(frames.data(), frames.rows(), false);
  const FrameBlock packed = frames;
  return cascade.run(packed.data(), packed.rows(), false);
}

FrameBlock Decimator::finish() {
  require_length(state_->sheet, state_->num_frames);
  return state_->cascade.run(nullptr, 0, true);
}

const FilterSheet& Decimator::sheet() const& {
  return state_->sheet;
}

Eigen::MatrixXd decimate(const Eigen::Ref<const Eigen::MatrixXd>& samples, const FilterSheet& design) {
  return decimate(
      samples.rows(), samples.cols(),
      [&](Index first, Index count) -> Eigen::MatrixXd { return samples.middleRows(first, count); }, design);
}

Eigen::MatrixXd decimate(Index num_samples, Index num_channels,
                         const std::function<Eigen::MatrixXd(Index first, Index count)>& read,
                         const FilterSheet& design) {
  require_length(design, num_samples);
  return decimate_between(0, num_outputs(design, num_samples), num_samples, num_channels, read, design);
}

Eigen::MatrixXd decimate_between(Index first, Index end, Index num_samples, Index num_channels,
                                 const std::function<Eigen::MatrixXd(Index first, Index count)>& read,
                                 const FilterSheet& design) {
  Cascade cascade(design, num_channels);
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(num_outputs(design, num_samples), num_channels);
  if (first >= end) return all;
  const Feed feed = feed_of(design, first, end, num_samples);
  if (feed.after) require_length(design, num_samples);
  Index next = feed.first;
  if (!feed.before)
    for (StageStream& stage : cascade.stages) next = stage.begin_at(next);
  const auto keep = [&](const FrameBlock& outputs) {
    all.middleRows(next, outputs.rows()) = outputs;
    next += outputs.rows();
  };
  constexpr Index block = 16384;
  for (Index at = feed.first; at < feed.end; at += block) {
    const FrameBlock frames = read(at, std::min(block, feed.end - at));
    keep(cascade.run(frames.data(), frames.rows(), false));
  }
  if (feed.after) keep(cascade.run(nullptr, 0, true));
  return all;
}

Eigen::MatrixXd decimate(const Eigen::Ref<const Eigen::MatrixXd>& samples, double sample_rate_hz,
                         const DecimateOptions& options, FilterSheet* sheet) {
  const FilterSheet design = measure(design_decimation(sample_rate_hz, options), sample_rate_hz, options);
  if (sheet != nullptr) *sheet = design;
  return decimate(samples, design);
}

}  // namespace dsp
