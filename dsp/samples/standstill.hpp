#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "dsp/samples/sample_cells.hpp"

namespace dsp {

/// What steps a channel makes, learnt from some thousand cells and remembered where they teach nothing.
struct StepScale {
  double floor = 0.0;       ///< a cell without a larger step stands still
  double typical = 0.0;     ///< median of the cells that do not
  double resolution = 0.0;  ///< the smallest step but for noise on top
  double large = 0.0;       ///< nine cells in ten stay below
  /// `steps`: single steps between neighbouring samples, drawn evenly from the same range.
  void learn(std::span<const SampleCell> cells, std::span<const double> steps);
};

/// Cells [first, last) of one channel without a step, and the cells beside them.
struct StillRun {
  using Beside = std::array<SampleCell, 3>;
  Eigen::Index first = 0, last = 0;
  double level = 0.0;
  Beside before{}, after{};  ///< the nearest first; like the run itself beyond an end of the record
  StepScale scale;
  [[nodiscard]] Eigen::Index num_cells() const { return last - first; }
  /// The step at an end is several times as large as the usual ones and those farther out.
  [[nodiscard]] bool jumps(const Beside& side) const;
  /// The level left over two cells is one that nothing leaves, or comes to, by degrees.
  [[nodiscard]] bool is_cut(const Beside& side) const;
  /// A crest cut off: what is beside it lies on one side, and is left at full pace.
  [[nodiscard]] bool is_cut_crest() const;
};

/// How long a channel stands still by nature.
class RunLengths {
 public:
  void add(Eigen::Index num_cells);
  /// Runs of so many cells and more are no chance: lengths follow the geometric law by the share of still cells that
  /// the shorter runs make, or `share` if that is more, and one false alarm in a thousand records is accepted. What
  /// fills more than a fifth of the record is its habit, however long.
  [[nodiscard]] Eigen::Index least_improbable(Eigen::Index cells_in_all, double share) const;
  /// Half of the record is spent in runs not longer than this; 1 where it seldom stands still.
  [[nodiscard]] Eigen::Index usual(Eigen::Index cells_in_all) const;

 private:
  std::vector<std::int64_t> counts_ = std::vector<std::int64_t>(1024);  ///< of lengths; the last: as long, or longer
  std::int64_t num_still_ = 0;
};

/// Follows one channel and keeps where it stands still.
class Standstill {
 public:
  static constexpr std::size_t context = 3;  ///< cells
  /// The next cells, on the scale learnt from them, behind the `context` ones before.
  void follow(std::span<const SampleCell> cells, const StepScale& scale);
  void finish();
  /// Of four cells (5 ms) and more: what is shorter is no fault.
  [[nodiscard]] const std::vector<StillRun>& runs() const& { return runs_; }
  void runs() const&& = delete;
  /// The others.
  [[nodiscard]] const RunLengths& short_runs() const& { return short_runs_; }
  void short_runs() const&& = delete;

 private:
  void take_beside(const SampleCell& cell);
  void close();
  void judge(const StillRun& run);

  Eigen::Index cell_ = 0;  ///< the next one
  StillRun open_, ripening_;
  bool is_open_ = false;
  std::size_t num_beside_ = context;  ///< cells seen behind the ripening run
  std::vector<StillRun> runs_;
  RunLengths short_runs_;
};

}  // namespace dsp
