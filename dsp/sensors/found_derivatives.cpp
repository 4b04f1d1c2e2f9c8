#include "dsp/sensors/found_derivatives.hpp"

#include <algorithm>
#include <cmath>

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

struct Agreement {
  double correlation = 0.0, factor = 0.0;
};

/// How the rise of `x` over spans of `span` samples follows the integral of `v` over them.
Agreement over_spans(const VectorXd& x, const VectorXd& integral_v, Index span) {
  const Index count = x.size() - span;
  if (count < 2) return {};
  const auto rises = [&](const VectorXd& values) -> VectorXd {
    VectorXd rise = values.tail(count) - values.head(count);
    return rise.array() - rise.mean();
  };
  const VectorXd of_x = rises(x), of_v = rises(integral_v);
  const double xx = of_x.squaredNorm(), vv = of_v.squaredNorm(), xv = of_x.dot(of_v);
  if (!(xx > 0.0) || !(vv > 0.0)) return {};
  return {xv / std::sqrt(xx * vv), std::sqrt(vv / xx)};
}

/// The integral up to each sample by trapezes.
VectorXd integral(const VectorXd& v, double sample_rate_hz) {
  VectorXd result(v.size());
  double sum = 0.0;
  for (Index i = 0; i < v.size(); ++i) {
    if (i > 0) sum += 0.5 * (v(i - 1) + v(i)) / sample_rate_hz;
    result(i) = sum;
  }
  return result;
}

Agreement agreement(const VectorXd& x, const VectorXd& v, double sample_rate_hz) {
  constexpr Index longest = 1024;  // half a slow cycle of a motion that is sampled a thousand times in it
  const VectorXd integral_v = integral(v.array() - v.mean(), sample_rate_hz);
  Agreement best;
  for (Index span = 1; span <= std::min(longest, x.size() / 4); span *= 2)
    if (const Agreement one = over_spans(x, integral_v, span); one.correlation > best.correlation) best = one;
  return best;
}

bool is_ratio_of_units(double factor) {
  constexpr double calibration = 0.02;
  const double power = std::round(std::log10(factor));
  return std::abs(factor / std::pow(10.0, power) - 1.0) < calibration;
}

}  // namespace

std::vector<FoundDerivative> find_derivatives(const Eigen::MatrixXd& samples, double sample_rate_hz) {
  constexpr double least_correlation = 0.99;
  std::vector<FoundDerivative> found;
  for (Index v = 0; v < samples.cols(); ++v) {
    FoundDerivative best;
    double correlation = least_correlation;
    for (Index x = 0; x < samples.cols(); ++x) {
      if (x == v || !samples.col(x).allFinite() || !samples.col(v).allFinite()) continue;
      const Agreement one = agreement(samples.col(x), samples.col(v), sample_rate_hz);
      if (one.correlation <= correlation || !is_ratio_of_units(one.factor)) continue;
      correlation = one.correlation;
      best = {x, v, one.factor};
    }
    if (correlation > least_correlation) found.push_back(best);
  }
  return found;
}

}  // namespace dsp
