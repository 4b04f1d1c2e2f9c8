#include "dsp/filter/burg.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

#include "dsp/filter/dispatch.hpp"
#include "dsp/filter/lanes.hpp"

namespace dsp {

using Eigen::Index;

namespace {

// Eight sums side by side, in two vectors: where the processor has none so wide, one of eight goes through memory.
constexpr int num_halves = 2;

double sum(const Lanes (&x)[num_halves]) {
  return ((x[0][0] + x[0][1]) + (x[0][2] + x[0][3])) + ((x[1][0] + x[1][1]) + (x[1][2] + x[1][3]));
}

// Of the pairs f[i + 1], b[i] that the next order meets.
struct Products {
  double cross = 0.0, power = 0.0;
};

// One order of the lattice, f -= k b and b -= k f over n pairs, and what the next order asks of the result, in a
// single pass: f[i + 1] is updated twice, which is cheaper than to read again what has just been written.
ARDENT_DISPATCH Products reflect(double* f, double* b, Index n, double k) {
  Lanes cross[num_halves] = {}, power[num_halves] = {};
  Index i = 0;
  for (; i + 9 <= n; i += 8)
    for (int half = 0; half < num_halves; ++half) {
      double *f_at = f + i + 4 * half, *b_at = b + i + 4 * half;
      const Lanes f_here = *reinterpret_cast<const UnalignedLanes*>(f_at),
                  f_next = *reinterpret_cast<const UnalignedLanes*>(f_at + 1),
                  b_here = *reinterpret_cast<const UnalignedLanes*>(b_at),
                  b_next = *reinterpret_cast<const UnalignedLanes*>(b_at + 1);
      const Lanes next = f_next - k * b_next;
      const Lanes forward = f_here - k * b_here, backward = b_here - k * f_here;
      *reinterpret_cast<UnalignedLanes*>(f_at) = forward;
      *reinterpret_cast<UnalignedLanes*>(b_at) = backward;
      cross[half] += next * backward;
      power[half] += next * next + backward * backward;
    }
  Products products{sum(cross), sum(power)};
  for (; i < n; ++i) {
    const double forward = f[i] - k * b[i], backward = b[i] - k * f[i];
    f[i] = forward;
    b[i] = backward;
    if (i + 1 == n) break;
    const double next = f[i + 1] - k * b[i + 1];
    products.cross += next * backward;
    products.power += next * next + backward * backward;
  }
  return products;
}

}  // namespace

Eigen::VectorXd burg(const Eigen::Ref<const Eigen::VectorXd>& x, Index order) {
  const Index n = x.size();
  if (order < 0 || order >= n)
    throw std::invalid_argument("burg: order must be in [0, " + std::to_string(n) + "), got " + std::to_string(order));
  // Errors of the best predictors of order m: forward of sample m + i, backward of sample i.
  Eigen::VectorXd reflection = Eigen::VectorXd::Zero(order), forward = x, backward = x;
  // Below this the errors are the rounding of x itself.
  const double floor =
      std::numeric_limits<double>::epsilon() * std::numeric_limits<double>::epsilon() * x.squaredNorm();
  Products products = reflect(forward.data(), backward.data(), n, 0.0);
  for (Index m = 0; m < order && products.power > floor; ++m) {
    reflection(m) = std::clamp(2.0 * products.cross / products.power, -1.0, 1.0);
    products = reflect(forward.data() + m + 1, backward.data(), n - m - 1, reflection(m));
  }
  return reflection;
}

Eigen::VectorXd predict_forward(const Eigen::Ref<const Eigen::VectorXd>& x,
                                const Eigen::Ref<const Eigen::VectorXd>& reflection, Index count) {
  const Index order = reflection.size();
  if (x.size() <= order) throw std::invalid_argument("predict_forward: not more samples than coefficients");
  // Backward errors of order 0 .. order - 1 of the newest sample, grown over the last samples of x.
  Eigen::VectorXd backward = Eigen::VectorXd::Zero(order + 1);
  for (Index i = x.size() - order - 1; i < x.size(); ++i) {
    double f = x(i), newer = f;
    for (Index m = 0; m < order; ++m) {
      const double b = backward(m);
      backward(m) = newer;
      newer = b - reflection(m) * f;
      f -= reflection(m) * b;
    }
  }
  Eigen::VectorXd after(count);
  // Of each new sample the forward error f of full order is zero: it brings nothing unforeseen. It takes one order
  // after the other, each with what the sample before has left there: so the next samples follow, two orders behind.
  const double* const k = reflection.data();
  double* const b = backward.data();
  const auto at_order = [k, b](Index m, double& f) {
    f += k[m] * b[m];
    b[m + 1] = b[m] - k[m] * f;
  };
  constexpr Index together = 4, behind = 2, spread = behind * (together - 1);
  Index i = 0;
  for (; i + together <= count; i += together) {
    double f[together] = {};
    const auto at_ends = [&](Index m) {
      for (Index j = 0; j < together; ++j) {
        const Index own = m + behind * j;
        if (0 <= own && own < order) at_order(own, f[j]);
        if (own == 0) b[0] = f[j];
      }
    };
    Index m = order - 1;
    for (; m > 0 && m + spread >= order; --m) at_ends(m);
    for (; m > 0; --m)
      for (Index j = 0; j < together; ++j) at_order(m + behind * j, f[j]);
    for (m = std::min<Index>(m, 0); m >= -spread; --m) at_ends(m);
    for (Index j = 0; j < together; ++j) after(i + j) = f[j];
  }
  for (; i < count; ++i) {
    double f = 0.0;
    for (Index m = order - 1; m >= 0; --m) at_order(m, f);
    b[0] = after(i) = f;
  }
  return after;
}

ExtensionOptions resolved(const ExtensionOptions& options, Index num_samples, double sample_rate_hz) {
  const bool fast = sample_rate_hz > 100.0;
  ExtensionOptions result = options;
  if (result.num_samples <= 0)
    result.num_samples = std::min(num_samples, static_cast<Eigen::Index>(10.0 * sample_rate_hz) + 1);
  if (result.order <= 0) result.order = fast ? 128 : 64;
  if (result.fit_samples <= 0) result.fit_samples = (fast ? 40 : 8) * result.order;
  result.fit_samples = std::min(result.fit_samples, num_samples);
  // A third of the samples at most: a longer predictor would be fitted to its own noise.
  result.order = std::min(result.order, result.fit_samples / 3);
  return result;
}

Eigen::VectorXd extend_after(const Eigen::Ref<const Eigen::VectorXd>& x, const ExtensionOptions& options) {
  const auto end = x.tail(options.fit_samples);
  return predict_forward(end, burg(end, options.order), options.num_samples);
}

Eigen::VectorXd extend_before(const Eigen::Ref<const Eigen::VectorXd>& x, const ExtensionOptions& options) {
  const Eigen::VectorXd reversed = x.head(options.fit_samples).reverse();
  return extend_after(reversed, options).reverse();
}

}  // namespace dsp
