#include "dsp/regimes/common_motion.hpp"

#include <cmath>
#include <utility>
#include <vector>

#include "dsp/values/linear.hpp"
#include "dsp/values/order_statistics.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double least_interval_s = 2.0, end_s = 0.5, least_duration_s = 10.0;

using IndexPair = std::pair<Index, Index>;  // first, behind the last

/// Ten times what half of the samples of stick do not exceed: seven standard deviations of noise, which no record
/// reaches.
double largest_speed_at_rest(const VectorXd& v, const Segmentation& segmentation) {
  constexpr double medians = 10.0;
  std::vector<double> speeds;
  for (const Segment& segment : segmentation.segments)
    if (segment.regime == Regime::stick)
      for (Index i = segment.first; i < segment.last; ++i) speeds.push_back(std::abs(v(i)));
  return speeds.empty() ? 0.0 : medians * median(std::move(speeds));
}

/// Runs of stick in which the payload stays still.
std::vector<IndexPair> still_ranges(const Motion& motion, const Segmentation& segmentation) {
  const VectorXd& v = motion.at("v");
  const double limit = largest_speed_at_rest(v, segmentation), rate_hz = motion.sample_rate_hz;
  const auto trim = static_cast<Index>(std::ceil(end_s * rate_hz));
  std::vector<IndexPair> ranges;
  const auto close = [&](Index first, Index last) {
    if (static_cast<double>(last - first) >= least_interval_s * rate_hz) ranges.emplace_back(first + trim, last - trim);
  };
  for (const Segment& segment : segmentation.segments) {
    if (segment.regime != Regime::stick) continue;
    Index first = std::max(segment.first, motion.edge_samples);
    const Index last = std::min(segment.last, v.size() - motion.edge_samples);
    for (Index i = first; i < last; ++i)
      if (!(std::abs(v(i)) <= limit)) {  // faulty samples are no stick
        close(first, i);
        first = i + 1;
      }
    close(first, last);
  }
  return ranges;
}

/// Rows r, dr, t and y of all ranges, each about its own mean.
Eigen::MatrixXd rows_of(const Motion& motion, const std::vector<IndexPair>& ranges, std::vector<Index>& ends) {
  Index count = 0;
  for (const auto& [first, last] : ranges) ends.push_back(count += last - first);
  Eigen::MatrixXd rows(count, 4);
  Index row = 0;
  for (const auto& [first, last] : ranges) {
    const Index n = last - first;
    auto block = rows.middleRows(row, n);
    block.col(0) = motion.at("r").segment(first, n);
    block.col(1) = motion.at("dr").segment(first, n);
    block.col(2) =
        VectorXd::LinSpaced(n, static_cast<double>(first), static_cast<double>(last - 1)) / motion.sample_rate_hz;
    block.col(3) = motion.at("y").segment(first, n);
    for (Index c = 0; c < 4; ++c) block.col(c).array() -= block.col(c).mean();
    row += n;
  }
  return rows;
}

}  // namespace

std::optional<CommonMotion> find_common_motion(const Motion& motion, const Segmentation& segmentation) {
  for (const char* name : {"r", "dr", "y", "v"})
    if (motion.find(name) == nullptr) return {};
  std::vector<Index> ends;
  const Eigen::MatrixXd rows = rows_of(motion, still_ranges(motion, segmentation), ends);
  CommonMotion found{.duration_s = static_cast<double>(rows.rows()) / motion.sample_rate_hz};
  if (found.duration_s < least_duration_s) return {};
  const Eigen::Vector3d scale = rows.leftCols<3>().colwise().norm();
  if (!(scale.minCoeff() > 0.0)) return {};
  const Eigen::MatrixX3d X = rows.leftCols<3>() * scale.cwiseInverse().asDiagonal();
  const Eigen::Matrix3d inverse = inverse_of_symmetric(X.transpose() * X);
  const Eigen::Vector3d c = inverse * (X.transpose() * rows.col(3));
  const VectorXd residual = rows.col(3) - X * c;
  Eigen::Matrix3d scores = Eigen::Matrix3d::Zero();
  const auto second = static_cast<Index>(std::lround(motion.sample_rate_hz));
  Index first = 0, blocks = 0;
  for (const Index end : ends)
    for (; first < end; ++blocks) {
      const Index n = std::min(second, end - first);
      const Eigen::Vector3d sum = X.middleRows(first, n).transpose() * residual.segment(first, n);
      scores += sum * sum.transpose();
      first += n;
    }
  const double spent = static_cast<double>(blocks) / static_cast<double>(blocks - 3);
  const Eigen::Vector3d mean = c.cwiseQuotient(scale),
                        std = (spent * (inverse * scores * inverse).diagonal()).cwiseSqrt().cwiseQuotient(scale);
  found.gain = mean(0);
  found.gain_std = std(0);
  found.lead_s = mean(1) / mean(0);
  found.lead_std_s = std(1) / std::abs(mean(0));
  return found;
}

void adopt(Motion& motion, double gain, double lead_s) {
  const auto values = [&](const char* name) -> VectorXd* {
    for (Signal& signal : motion.signals)
      if (signal.name == name) return &signal.values;
    return nullptr;
  };
  // Each is led by the one after it before that one changes; accelerometers keep their clock.
  constexpr const char* base[] = {"r", "dr", "ddr"};
  constexpr const char* relative[] = {"x", "v", "a"};
  for (std::size_t order = 0; order < 3; ++order) {
    VectorXd* of_base = values(base[order]);
    if (of_base == nullptr) continue;
    VectorXd change = (gain - 1.0) * *of_base;
    if (const VectorXd* next = order < 2 ? values(base[order + 1]) : nullptr) change += gain * lead_s * *next;
    *of_base += change;
    if (VectorXd* difference = values(relative[order])) *difference -= change;
  }
}

}  // namespace dsp
