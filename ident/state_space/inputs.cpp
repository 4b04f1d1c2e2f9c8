#include "ident/state_space/inputs.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "dsp/filter/kaiser.hpp"

namespace ident::state_space {
namespace {

using Eigen::Index;

constexpr int points = 6, before = 2, behind = points - before;  // samples of a polynomial; ahead of the interval
constexpr int fine = 4;    // points a sample, between which the polynomial errs by 1e-4 at 0.65 of half the rate
constexpr int reach = 32;  // samples on either side that a band-limited value is made of

/// Lagrange's polynomials on -2 ... 3: what each of six equidistant values counts for in the value at 0 <= at <= 1, and
/// in the slope.
void weigh(double at, std::array<double, points>& weight, std::array<double, points>& slope) {
  static constexpr std::array<double, points> share{-1.0 / 120.0, 1.0 / 24.0,  -1.0 / 12.0,
                                                    1.0 / 12.0,   -1.0 / 24.0, 1.0 / 120.0};  // over all i - j
  for (std::size_t i = 0; i < points; ++i) {
    double product = share[i], sum = 0.0;
    for (std::size_t j = 0; j < points; ++j) {
      if (j == i) continue;
      const double distance = at - (static_cast<double>(j) - before);
      sum = sum * distance + product;
      product *= distance;
    }
    weight[i] = product, slope[i] = sum;
  }
}

/// The sine cardinal under a window of Kaiser of 140 dB: what 2 x reach samples count for between the middle two.
std::array<double, 2 * reach> band_limited(double at) {
  const dsp::KaiserWindow window(14.5);
  std::array<double, 2 * reach> weight{};
  double sum = 0.0;
  for (int i = 0; i < 2 * reach; ++i) {
    const double d = at - (i - reach + 1), part = d / reach;
    weight[static_cast<std::size_t>(i)] = std::sin(std::numbers::pi * d) / (std::numbers::pi * d) * window(part);
    sum += weight[static_cast<std::size_t>(i)];
  }
  for (double& one : weight) one /= sum;
  return weight;
}

/// The cubic through the four values from `end` inwards, `beyond` steps outwards of it.
double continued(const Eigen::VectorXd& values, Index end, Index inwards, int beyond) {
  double value[4];
  for (int i = 0; i < 4; ++i) value[i] = values(end + i * inwards);
  for (int i = 0; i < beyond; ++i) {
    const double next = 4.0 * value[0] - 6.0 * value[1] + 4.0 * value[2] - value[3];
    for (int j = 3; j > 0; --j) value[j] = value[j - 1];
    value[0] = next;
  }
  return value[0];
}

}  // namespace

Inputs::Inputs(const Eigen::MatrixXd& samples, Index num_samples, double sample_rate_hz, double begin_s)
    : num_samples_(num_samples),
      num_inputs_(static_cast<int>(samples.cols())),
      sample_rate_hz_(sample_rate_hz),
      begin_s_(begin_s) {
  const auto width = static_cast<std::size_t>(num_inputs_);
  padded_.assign(static_cast<std::size_t>(num_samples * fine + points) * width, 0.0);
  std::array<std::array<double, 2 * reach>, fine> inside{};
  std::array<std::array<double, points>, fine> at_ends{}, slope{};
  for (int r = 0; r < fine; ++r) {
    const double at = static_cast<double>(r) / fine;
    weigh(at, at_ends[static_cast<std::size_t>(r)], slope[static_cast<std::size_t>(r)]);
    if (r > 0) inside[static_cast<std::size_t>(r)] = band_limited(at);
  }
  Eigen::VectorXd values(num_samples + points);
  for (Index i = 0; i < samples.cols(); ++i) {
    values.segment(before, num_samples) = samples.col(i).head(num_samples);
    const Index last = before + num_samples - 1;
    for (int beyond = 1; beyond <= before; ++beyond) values(before - beyond) = continued(values, before, 1, beyond);
    for (int beyond = 1; beyond <= behind; ++beyond) values(last + beyond) = continued(values, last, -1, beyond);
    for (Index at = -before; at < num_samples * fine + behind; ++at) {
      const Index k = std::clamp<Index>((at + fine) / fine - 1, 0, num_samples - 1), rest = at - k * fine;
      const auto r = static_cast<std::size_t>(rest & (fine - 1));
      double value = 0.0;
      if (rest == 0) {
        value = values(before + k);
      } else if (rest > 0 && rest < fine && k + 1 >= reach && k + reach < num_samples) {
        for (Index j = 0; j < 2 * reach; ++j)
          value += inside[r][static_cast<std::size_t>(j)] * values(before + k + 1 - reach + j);
      } else if (rest > 0 && rest < fine) {
        for (Index j = 0; j < points; ++j) value += at_ends[r][static_cast<std::size_t>(j)] * values(k + j);
      } else {  // outside of the record
        std::array<double, points> weight{}, unused{};
        weigh(static_cast<double>(rest) / fine, weight, unused);
        for (Index j = 0; j < points; ++j) value += weight[static_cast<std::size_t>(j)] * values(k + j);
      }
      padded_[static_cast<std::size_t>(at + before) * width + static_cast<std::size_t>(i)] = value;
    }
  }
}

Inputs::Place::Place(double at) : fraction(at) {
  const int interval = std::clamp(static_cast<int>(at * fine), 0, fine - 1);
  first = static_cast<std::size_t>(interval);
  weigh(at * fine - interval, weight, slope);
}

void Inputs::at(Index k, const Place& place, double* values, double* rates, int apart) const {
  const double* row =
      padded_.data() + (static_cast<std::size_t>(k) * fine + place.first) * static_cast<std::size_t>(num_inputs_);
  for (int u = 0; u < num_inputs_; ++u) {
    double value = 0.0, rate = 0.0;
    for (std::size_t i = 0; i < points; ++i) {
      const double sample = row[i * static_cast<std::size_t>(num_inputs_) + static_cast<std::size_t>(u)];
      value += place.weight[i] * sample, rate += place.slope[i] * sample;
    }
    values[u * apart] = value;
    if (rates != nullptr) rates[u * apart] = rate * fine * sample_rate_hz_;
  }
  values[num_inputs_ * apart] = begin_s_ + (static_cast<double>(k) + place.fraction) / sample_rate_hz_;
  if (rates != nullptr) rates[num_inputs_ * apart] = 1.0;
}

}  // namespace ident::state_space
