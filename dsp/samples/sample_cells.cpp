#include "dsp/samples/sample_cells.hpp"

#include <cstdint>
#include <stdexcept>

#include "dsp/filter/dispatch.hpp"

namespace dsp {
namespace {

using Eigen::Index;

struct Cut {
  Index frames_per_cell, num_cells, num_channels, stride;
};

// K successive cells of N neighbouring columns at once: one chain of sums a cell and column, in the order of the
// frames, and chains for the processor to overlap. False for a value that is not finite: the sums have met them all.
template <int N, int K>
inline __attribute__((always_inline)) bool measure_cells(const double* frame, const Cut& cut, const double* before,
                                                         SampleCell* cells) {
  typedef double Row __attribute__((vector_size(N * sizeof(double)), aligned(8), may_alias));
  typedef std::int64_t Bits __attribute__((vector_size(N * sizeof(double))));
  const auto lane = [](const Row& values, int c) { return reinterpret_cast<const double*>(&values)[c]; };
  const Index cell = cut.frames_per_cell * cut.stride;
  Row last[K], low[K], high[K], sum[K] = {}, step[K] = {};
  for (int k = 0; k < K; ++k) {
    last[k] = *reinterpret_cast<const Row*>(k > 0 ? frame + k * cell - cut.stride : before);
    low[k] = high[k] = *reinterpret_cast<const Row*>(frame + k * cell);
  }
  for (Index i = 0; i < cut.frames_per_cell; ++i, frame += cut.stride)
    for (int k = 0; k < K; ++k) {
      const Row now = *reinterpret_cast<const Row*>(frame + k * cell);
      const Row size = reinterpret_cast<Row>(reinterpret_cast<Bits>(now - last[k]) & INT64_MAX);
      low[k] = now < low[k] ? now : low[k];
      high[k] = now > high[k] ? now : high[k];
      step[k] = size > step[k] ? size : step[k];
      sum[k] += now;
      last[k] = now;
    }
  Row doubt = {};
  for (int k = 0; k < K; ++k) {
    const Row mean = sum[k] / static_cast<double>(cut.frames_per_cell);
    doubt += mean - mean;
    for (int c = 0; c < N; ++c)
      cells[c * cut.num_cells + k] = {lane(low[k], c), lane(high[k], c), lane(mean, c), lane(step[k], c)};
  }
  double all = 0.0;
  for (int c = 0; c < N; ++c) all += lane(doubt, c);
  return all == 0.0;
}

template <int N>
inline __attribute__((always_inline)) bool measure_columns(const double* frame, const Cut& cut, const double* before,
                                                           SampleCell* cells) {
  const Index cell = cut.frames_per_cell * cut.stride;
  bool finite = true;
  Index i = 0;
  for (; i + 2 <= cut.num_cells; i += 2) {
    finite &= measure_cells<N, 2>(frame + i * cell, cut, before, cells + i);
    before = frame + (i + 2) * cell - cut.stride;
  }
  if (i < cut.num_cells) finite &= measure_cells<N, 1>(frame + i * cell, cut, before, cells + i);
  return finite;
}

ARDENT_DISPATCH bool measure_all(const double* frame, const Cut& cut, const double* before, SampleCell* cells) {
  bool finite = true;
  Index c = 0;
  for (; c + 4 <= cut.num_channels; c += 4)
    finite &= measure_columns<4>(frame + c, cut, before + c, cells + c * cut.num_cells);
  for (; c + 2 <= cut.num_channels; c += 2)
    finite &= measure_columns<2>(frame + c, cut, before + c, cells + c * cut.num_cells);
  for (; c < cut.num_channels; ++c) finite &= measure_columns<1>(frame + c, cut, before + c, cells + c * cut.num_cells);
  return finite;
}

}  // namespace

CellCutter::CellCutter(Index frames_per_cell, Index num_channels) : waiting_(frames_per_cell, num_channels) {
  if (frames_per_cell < 1 || num_channels < 1) throw std::invalid_argument("CellCutter: no frames or no channels");
}

void CellCutter::measure(const Frames& frames) {
  const Index length = std::min(waiting_.rows(), frames.rows()), num_cells = frames.rows() / length;
  cells_.resize(static_cast<std::size_t>(num_cells * frames.cols()));
  if (!measure_all(frames.data(), {length, num_cells, frames.cols(), frames.outerStride()}, before_.data(),
                   cells_.data()))
    throw std::invalid_argument("sample cells: a value is not finite");
}

}  // namespace dsp
