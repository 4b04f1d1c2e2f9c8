#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "dsp/samples/clipping.hpp"
#include "dsp/samples/sample_cells.hpp"

namespace dsp {

/// Of a step over the usual ones: seldom are they so large.
inline constexpr double jump_ratio = 8.0;
/// Seldom do so many cells in a row hold but equal values.
inline constexpr Eigen::Index least_equal_cells = 4;

/// Cells [first, last) without a step.
struct StillRun {
  Eigen::Index first = 0, last = 0;
  Eigen::Index num_equal = 0;                           ///< of them, cells of equal values
  double level = 0.0, level_in = 0.0, level_out = 0.0;  ///< in it, two cells before and behind
  double jump_in = 0.0, jump_out = 0.0;  ///< steps at its ends, over the usual ones and those farther out
  double rise = 0.0;                     ///< into it, over two cells, in `least` steps
  bool abrupt = false;                   ///< it ends, or begins, at a pace that is usual for the channel
  [[nodiscard]] Eigen::Index num_cells() const { return last - first; }
};

/// What steps a channel makes, learnt from some thousand cells and remembered where they teach nothing.
struct StepScale {
  double floor = 0.0;    ///< a cell without a larger step stands still
  double typical = 0.0;  ///< median of the cells that do not
  double least = 0.0;    ///< the smallest of them but for noise: the sensor's resolution
  double large = 0.0;    ///< nine cells in ten stay below
  double smallest = std::numeric_limits<double>::infinity();  ///< step met so far that is not zero
  /// `steps`: single steps between neighbouring samples, drawn evenly from the same range.
  void learn(std::span<const SampleCell> cells, std::span<const double> steps);
};

/// Follows one channel and keeps where it stands still.
class Standstill {
 public:
  /// The next cells, on the scale learnt from them.
  void follow(std::span<const SampleCell> cells, const StepScale& scale);
  void finish();
  [[nodiscard]] const std::vector<StillRun>& runs() const& {
    return runs_;
  }  ///< of eight cells and more, or four equal
  void runs() const&& = delete;
  /// Near the lowest and highest level met, where noise lies on top: of any length, and single cells that move.
  [[nodiscard]] const std::vector<StillRun>& extreme_runs() const& { return extreme_runs_; }
  void extreme_runs() const&& = delete;
  [[nodiscard]] const LevelHistogram& levels() const& { return levels_; }
  void levels() const&& = delete;
  /// Half of the record is spent in runs not longer than this; 1 where it seldom stands still.
  [[nodiscard]] Eigen::Index usual_cells() const;
  [[nodiscard]] std::int64_t num_equal_cells() const { return num_equal_; }  ///< in the whole record

 private:
  [[nodiscard]] std::size_t num_moving(std::span<const SampleCell> cells, double floor) const;
  void pass(std::span<const SampleCell> moving);
  void note(const SampleCell& cell);
  void note_extreme(const SampleCell& cell);
  void close(const StepScale& scale);

  Eigen::Index cell_ = 0;          // the next one
  std::array<double, 4> steps_{};  // of the latest cells, newest first
  StillRun open_;
  bool is_open_ = false;
  std::array<double, 2> levels_before_{};  // of the latest cells, newest first
  std::int64_t num_equal_ = 0;
  Eigen::Index ripening_ = 0;  // cells still to see behind the last of runs_
  double step_out_ = 0.0;
  double low_ = std::numeric_limits<double>::infinity(), high_ = -low_;  // levels while it moves, jumps left out
  std::vector<StillRun> runs_, extreme_runs_;
  LevelHistogram levels_;
  std::vector<std::int64_t> cells_in_runs_ = std::vector<std::int64_t>(1024);  // by length of the run; longer: last
};

}  // namespace dsp
