#include "dsp/filter/kaiser.hpp"

#include <cmath>

namespace dsp {
namespace {

double bessel_i0(double x) {
  double sum = 1.0, term = 1.0;
  for (int k = 1; term > 1e-17 * sum; ++k) {
    term *= (x / (2.0 * k)) * (x / (2.0 * k));
    sum += term;
  }
  return sum;
}

}  // namespace

double kaiser_beta(double attenuation_db) {
  if (attenuation_db > 50.0) return 0.1102 * (attenuation_db - 8.7);
  return 0.5842 * std::pow(attenuation_db - 21.0, 0.4) + 0.07886 * (attenuation_db - 21.0);
}

double kaiser_length(double attenuation_db, double transition_hz, double sample_rate_hz) {
  return (attenuation_db - 7.95) / 14.36 * sample_rate_hz / transition_hz;
}

KaiserWindow::KaiserWindow(double beta) : beta_(beta), crest_(bessel_i0(beta)) {}

double KaiserWindow::operator()(double u) const {
  return std::abs(u) > 1.0 ? 0.0 : bessel_i0(beta_ * std::sqrt(1.0 - u * u)) / crest_;
}

}  // namespace dsp
