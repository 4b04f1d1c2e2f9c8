#pragma once
#include <Eigen/Core>

namespace apps {

/// At most `most` values of a series in its order: equal runs of samples are represented by their least and greatest
/// value, in the order these have, so that no spike is lost. Both series come out as they are if they are short enough.
/// NaN is a run in which no value is finite.
struct Envelope {
  Eigen::VectorXd x, y;
};
[[nodiscard]] Envelope envelope(const Eigen::Ref<const Eigen::VectorXd>& x, const Eigen::Ref<const Eigen::VectorXd>& y,
                                Eigen::Index most);

/// Whether x goes in equal steps, to a millionth of one.
[[nodiscard]] bool is_uniform(const Eigen::Ref<const Eigen::VectorXd>& x);

}  // namespace apps
