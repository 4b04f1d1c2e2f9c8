#include "ident/state_space/inputs.hpp"

#include <cstddef>

namespace ident::state_space {
namespace {

constexpr int points = 6, before = 2;  // samples of a polynomial, and of these before the interval

/// The cubic through the four values `step` apart from `end` inwards, `beyond` steps outwards of it.
double continued(const double* end, std::ptrdiff_t step, int beyond) {
  double value[4];
  for (int i = 0; i < 4; ++i) value[i] = end[i * step];
  for (int i = 0; i < beyond; ++i) {
    const double next = 4.0 * value[0] - 6.0 * value[1] + 4.0 * value[2] - value[3];
    for (int j = 3; j > 0; --j) value[j] = value[j - 1];
    value[0] = next;
  }
  return value[0];
}

}  // namespace

Inputs::Inputs(const Eigen::MatrixXd& samples, Eigen::Index num_samples, double sample_rate_hz)
    : num_samples_(num_samples), num_inputs_(static_cast<int>(samples.cols())), sample_rate_hz_(sample_rate_hz) {
  constexpr int behind = points - before;
  const auto width = static_cast<std::size_t>(num_inputs_);
  padded_.assign(static_cast<std::size_t>(num_samples + points) * width, 0.0);
  for (Eigen::Index i = 0; i < samples.cols(); ++i) {
    double* first = padded_.data() + static_cast<std::size_t>(before) * width + i;
    const auto step = static_cast<std::ptrdiff_t>(width);
    for (Eigen::Index k = 0; k < num_samples; ++k) first[k * step] = samples(k, i);
    double* last = first + (num_samples - 1) * step;
    for (int beyond = 1; beyond <= before; ++beyond) first[-beyond * step] = continued(first, step, beyond);
    for (int beyond = 1; beyond <= behind; ++beyond) last[beyond * step] = continued(last, -step, beyond);
  }
}

Inputs::Place::Place(double at) : fraction(at) {
  for (int i = 0; i < points; ++i) {  // Lagrange's polynomials on -2 ... 3
    double product = 1.0, sum = 0.0;
    for (int j = 0; j < points; ++j) {
      if (j == i) continue;
      const double factor = (fraction - (j - before)) / (i - j);
      sum = sum * factor + product / (i - j);
      product *= factor;
    }
    weight[static_cast<std::size_t>(i)] = product, slope[static_cast<std::size_t>(i)] = sum;
  }
}

void Inputs::at(Eigen::Index k, const Place& place, double* values, double* rates, int apart) const {
  const double* row = padded_.data() + static_cast<std::size_t>(k) * static_cast<std::size_t>(num_inputs_);
  for (int u = 0; u < num_inputs_; ++u) {
    double value = 0.0, rate = 0.0;
    for (std::size_t i = 0; i < points; ++i) {
      const double sample = row[i * static_cast<std::size_t>(num_inputs_) + static_cast<std::size_t>(u)];
      value += place.weight[i] * sample, rate += place.slope[i] * sample;
    }
    values[u * apart] = value;
    if (rates != nullptr) rates[u * apart] = rate * sample_rate_hz_;
  }
  values[num_inputs_ * apart] = (static_cast<double>(k) + place.fraction) / sample_rate_hz_;
  if (rates != nullptr) rates[num_inputs_ * apart] = 1.0;
}

}  // namespace ident::state_space
