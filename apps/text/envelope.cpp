#include "apps/text/envelope.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace apps {

using Eigen::Index;
using Eigen::VectorXd;

bool is_uniform(const Eigen::Ref<const VectorXd>& x) {
  if (x.size() < 2) return false;
  const double step = (x(x.size() - 1) - x(0)) / static_cast<double>(x.size() - 1);
  constexpr double tolerance = 1e-6;  // of a step
  for (Index i = 0; i < x.size(); ++i)
    if (!(std::abs(x(i) - x(0) - step * static_cast<double>(i)) <= tolerance * std::abs(step))) return false;
  return true;
}

Envelope envelope(const Eigen::Ref<const VectorXd>& x, const Eigen::Ref<const VectorXd>& y, Index most) {
  const Index n = std::min(x.size(), y.size());
  if (n <= most || most < 2) return {x.head(n), y.head(n)};
  const Index runs = most / 2;
  const bool uniform = is_uniform(x);
  const double span = (x(n - 1) - x(0)) * static_cast<double>(n) / static_cast<double>(n - 1);
  Envelope result{VectorXd(2 * runs), VectorXd(2 * runs)};
  for (Index run = 0; run < runs; ++run) {
    const Index first = n * run / runs, end = n * (run + 1) / runs;
    Index least = -1, greatest = -1;
    for (Index i = first; i < end; ++i) {
      if (!std::isfinite(y(i))) continue;
      if (least < 0 || y(i) < y(least)) least = i;
      if (greatest < 0 || y(i) > y(greatest)) greatest = i;
    }
    const bool any = least >= 0;
    for (const Index half : {2 * run, 2 * run + 1})  // of equal steps where x is: less than a sample aside
      result.x(half) = uniform ? x(0) + span * static_cast<double>(half) / static_cast<double>(2 * runs)
                               : x(half == 2 * run ? first : (first + end) / 2);
    result.y(2 * run) = any ? y(std::min(least, greatest)) : std::numeric_limits<double>::quiet_NaN();
    result.y(2 * run + 1) = any ? y(std::max(least, greatest)) : std::numeric_limits<double>::quiet_NaN();
  }
  return result;
}

}  // namespace apps
