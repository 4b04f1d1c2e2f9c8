#pragma once
#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "dsp/io/range_spec.hpp"
#include "dsp/regimes/regime.hpp"
#include "dsp/values/recording.hpp"
#include "ident/columns/columns.hpp"

namespace ident {

/// Rows that are fitted together: intervals of time, of one recording or of all, in one amplitude regime or in any.
struct Range {
  dsp::RangeSpec spec;
  int recording = 0;            ///< 1-based; 0: all
  dsp::RegimeSet regime;        ///< of its samples
  double train_fraction = 0.6;  ///< of its rows, where its train_to is left out
  /// Whether it is about the recording at this index (0-based).
  [[nodiscard]] bool covers(std::size_t index) const {
    return recording == 0 || static_cast<std::size_t>(recording) == index + 1;
  }
};

/// Pairs of ranges (indices, the later first) that may hold the same samples; no more than `most` of them.
[[nodiscard]] std::vector<std::pair<std::size_t, std::size_t>> overlaps(const std::vector<Range>& ranges,
                                                                        std::size_t most);

/// Every range as two, by the sign of the velocity: "low+" and "low-".
[[nodiscard]] std::vector<Range> split_by_direction(const std::vector<Range>& ranges);

/// Throws dsp::Fault (usage, "term.*") with the range's place where its condition cannot be computed from signals of
/// these names.
void require_condition(const Range& range, const dsp::Motion& signals);

/// A sample of one of the recordings.
struct Row {
  std::size_t recording = 0;
  Eigen::Index sample = 0;
};

/// Rows [first, result) are of successive samples of one recording; at most up to `end`.
[[nodiscard]] Eigen::Index end_of_stretch(const std::vector<Row>& rows, Eigen::Index first, Eigen::Index end);

/// Rows that are fitted together, and rows they are tried on; in the order of recordings and time.
struct RangeRows {
  std::vector<Row> train, test;
  std::vector<dsp::Interval> train_s, test_s;       ///< intervals without an excluded gap; rows that `where` drops do
                                                    ///< not split
  std::vector<std::vector<Eigen::Index>> usable{};  ///< per recording: samples of the range before `where`
};

/// Samples of the range: inside [from, to), not excluded, not at a spoilt end, of its regime, `where` true; training
/// rows before train_to, or the first train_share of each recording's rows. Throws dsp::Fault (usage, "range.outside",
/// "range.empty", "term.*" for the condition) with the range's place in the config; "range.empty" of a range that has
/// no place there is a fault of the input.
[[nodiscard]] RangeRows range_rows(const Range& range, const std::vector<Columns>& recordings);

/// The signals of a recording (0-based) on those of these rows that are its own, of which about `most`, evenly spread,
/// are looked at. No samples where none is.
[[nodiscard]] dsp::Motion some_samples(const std::vector<Row>& rows, std::size_t recording,
                                       const std::vector<Columns>& recordings, std::size_t most);

}  // namespace ident
