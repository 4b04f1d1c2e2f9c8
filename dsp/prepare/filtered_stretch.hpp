#pragma once
#include <Eigen/Core>
#include <functional>
#include <limits>

#include "dsp/prepare/prepared.hpp"

namespace dsp {

/// A stretch of a record; left out: all of it.
struct Stretch {
  double from_s = -std::numeric_limits<double>::infinity(), to_s = std::numeric_limits<double>::infinity();
  [[nodiscard]] Stretch wider(double by_s) const { return {from_s - by_s, to_s + by_s}; }
};

/// The input that affects columns within a stretch: the column filter's reach on either side, and before it what its
/// high-pass has not forgotten; all, where that filter is a taper.
[[nodiscard]] Stretch input_interval(const Prepared& prepared, const Stretch& wanted);

/// prepared.filter.apply of signals at the intermediate rate, where only what lies within a stretch is wanted. There it
/// is the same (behind a high-pass to a millionth of its largest value); beside it anything finite. `read` is asked for
/// no more than that leans on.
[[nodiscard]] Eigen::MatrixXd filtered_within(
    const Prepared& prepared, const Stretch& wanted, Eigen::Index num_signals,
    const std::function<Eigen::MatrixXd(Eigen::Index first, Eigen::Index count)>& read);

}  // namespace dsp
