#include "dsp/io/found_derivatives.hpp"

#include <algorithm>
#include <cmath>

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

using Values = Eigen::Ref<const VectorXd>;

/// The lengths of 1, 2, 4 ... samples over which rises are looked at.
std::vector<Index> spans_within(Index num_samples) {
  constexpr Index longest = 1024;  // half a slow cycle of a motion that is sampled a thousand times in it
  std::vector<Index> spans;
  for (Index span = 1; span <= std::min(longest, num_samples / 4); span *= 2) spans.push_back(span);
  return spans;
}

/// The sum of products of the rises of `a` and `b` over each span, about their means.
VectorXd rise_products(const Values& a, const Values& b, const std::vector<Index>& spans) {
  constexpr Index block = 1024;  // with the longest span, of both columns, 32 KiB: the processor's first cache
  VectorXd sums = VectorXd::Zero(std::ssize(spans)), mean_a = sums, mean_b = sums;
  for (Index s = 0; s < sums.size(); ++s) {
    const Index span = spans[static_cast<std::size_t>(s)];
    const auto mean_rise = [&](const Values& values) {
      return (values.tail(span).sum() - values.head(span).sum()) / static_cast<double>(values.size() - span);
    };
    mean_a(s) = mean_rise(a), mean_b(s) = mean_rise(b);
  }
  for (Index first = 0; first < a.size(); first += block)
    for (Index s = 0; s < sums.size(); ++s) {
      const Index span = spans[static_cast<std::size_t>(s)], count = std::min(block, a.size() - span - first);
      if (count <= 0) break;
      const auto rises = [&](const Values& values, double mean) {
        return (values.segment(first + span, count) - values.segment(first, count)).array() - mean;
      };
      sums(s) += (rises(a, mean_a(s)) * rises(b, mean_b(s))).sum();
    }
  return sums;
}

/// The integral of `v` about its mean up to each sample, by trapezes.
VectorXd integral(const Values& v, double sample_rate_hz) {
  VectorXd result(v.size());
  const double mean = v.mean();
  double sum = 0.0;
  for (Index i = 0; i < v.size(); ++i) {
    if (i > 0) sum += 0.5 * (v(i - 1) - mean + (v(i) - mean)) / sample_rate_hz;
    result(i) = sum;
  }
  return result;
}

struct Agreement {
  double correlation = 0.0, factor = 0.0;
};

/// At the span where both columns agree best, by the products of their rises and the norms of either's.
Agreement best_agreement(const VectorXd& products, const VectorXd& norm_x, const VectorXd& norm_v) {
  Agreement best;
  for (Index s = 0; s < products.size(); ++s) {
    if (!(norm_x(s) > 0.0) || !(norm_v(s) > 0.0)) continue;
    const double correlation = products(s) / norm_x(s) / norm_v(s);
    if (correlation > best.correlation) best = {correlation, norm_v(s) / norm_x(s)};
  }
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
  const std::vector<Index> spans = spans_within(samples.rows());
  std::vector<Index> usable;
  if (!spans.empty())
    for (Index i = 0; i < samples.cols(); ++i)
      if (samples.col(i).allFinite() && (samples.col(i).array() != samples(0, i)).any()) usable.push_back(i);
  if (usable.size() < 2) return {};
  const auto rise_norms = [&](const Values& values) -> VectorXd {
    return rise_products(values, values, spans).cwiseSqrt();
  };
  std::vector<VectorXd> norms;
  for (const Index x : usable) norms.push_back(rise_norms(samples.col(x)));
  std::vector<FoundDerivative> found;
  for (const Index v : usable) {
    const VectorXd integral_v = integral(samples.col(v), sample_rate_hz), norm_v = rise_norms(integral_v);
    FoundDerivative best;
    double highest = least_correlation;
    for (std::size_t i = 0; i < usable.size(); ++i) {
      if (usable[i] == v) continue;
      const VectorXd products = rise_products(samples.col(usable[i]), integral_v, spans);
      const Agreement one = best_agreement(products, norms[i], norm_v);
      if (one.correlation <= highest || !is_ratio_of_units(one.factor)) continue;
      highest = one.correlation;
      best = {usable[i], v, one.factor};
    }
    if (highest > least_correlation) found.push_back(best);
  }
  return found;
}

}  // namespace dsp
