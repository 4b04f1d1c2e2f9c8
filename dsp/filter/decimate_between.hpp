#pragma once
#include <Eigen/Core>
#include <functional>

#include "dsp/filter/decimate.hpp"

namespace dsp {

/// decimate() where only outputs [first, end) are wanted; the others are zero. `read` is asked for no more than those
/// lean on, in order, and nothing is predicted beyond an end of the record that they do not reach. Throws as it does.
[[nodiscard]] Eigen::MatrixXd decimate_between(
    Eigen::Index first, Eigen::Index end, Eigen::Index num_samples, Eigen::Index num_channels,
    const std::function<Eigen::MatrixXd(Eigen::Index first, Eigen::Index count)>& read, const FilterSheet& design);

}  // namespace dsp
