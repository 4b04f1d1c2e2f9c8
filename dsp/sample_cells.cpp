#include "dsp/sample_cells.hpp"

#include <cmath>
#include <stdexcept>

#include "dsp/dispatch.hpp"

namespace dsp {
namespace {

// N neighbouring columns at once. One chain of sums a column, in the order of the frames.
template <int N>
inline __attribute__((always_inline)) void measure_columns(const double* frame, Eigen::Index num_frames,
                                                           Eigen::Index stride, const double* before,
                                                           SampleCell* cells) {
  typedef double Row __attribute__((vector_size(N * sizeof(double)), aligned(8), may_alias));
  Row last = *reinterpret_cast<const Row*>(before), low = *reinterpret_cast<const Row*>(frame), high = low;
  Row sum = {}, step = {};
  for (Eigen::Index i = 0; i < num_frames; ++i, frame += stride) {
    const Row now = *reinterpret_cast<const Row*>(frame), up = now - last, down = last - now;
    const Row size = up > down ? up : down;
    low = now < low ? now : low;
    high = now > high ? now : high;
    step = size > step ? size : step;
    sum += now;
    last = now;
  }
  const auto lane = [](const Row& row, int c) { return reinterpret_cast<const double*>(&row)[c]; };
  for (int c = 0; c < N; ++c)
    cells[c] = {lane(low, c), lane(high, c), lane(sum, c) / static_cast<double>(num_frames), lane(step, c)};
}

ARDENT_DISPATCH void measure_all(const double* frame, Eigen::Index num_frames, Eigen::Index num_channels,
                                 Eigen::Index stride, const double* before, SampleCell* cells) {
  Eigen::Index c = 0;
  for (; c + 4 <= num_channels; c += 4) measure_columns<4>(frame + c, num_frames, stride, before + c, cells + c);
  for (; c + 2 <= num_channels; c += 2) measure_columns<2>(frame + c, num_frames, stride, before + c, cells + c);
  for (; c < num_channels; ++c) measure_columns<1>(frame + c, num_frames, stride, before + c, cells + c);
}

}  // namespace

CellCutter::CellCutter(Eigen::Index frames_per_cell, Eigen::Index num_channels)
    : waiting_(frames_per_cell, num_channels), cells_(static_cast<std::size_t>(num_channels)) {
  if (frames_per_cell < 1 || num_channels < 1) throw std::invalid_argument("CellCutter: no frames or no channels");
}

void CellCutter::measure(const Frames& frames) {
  measure_all(frames.data(), frames.rows(), frames.cols(), frames.outerStride(), before_.data(), cells_.data());
  for (const auto& cell : cells_)  // the sum has met every sample
    if (!std::isfinite(cell.mean)) throw std::invalid_argument("sample cells: a value is not finite");
}

}  // namespace dsp
