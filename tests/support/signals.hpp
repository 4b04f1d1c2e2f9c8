#pragma once
#include <Eigen/Core>
#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

namespace support {

inline Eigen::VectorXd gaussian(Eigen::Index n, std::uint32_t seed, std::floating_point auto std) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal(0.0, std);
  return Eigen::VectorXd::NullaryExpr(n, [&] { return normal(generator); });
}
inline Eigen::VectorXd gaussian(Eigen::Index n, std::uint32_t seed) {
  return gaussian(n, seed, 1.0);
}

/// A sum of harmonics of a slowly swept tone, with exact derivatives: not periodic, and no linear predictor is exact
/// for it.
struct SweptHarmonics {
  double start_hz = 1.66, sweep_hz_per_s = -2e-3;
  std::array<double, 4> amplitudes{8e-3, 0.0, 6e-4, 5e-5};  ///< of harmonics 1, 2, ...

  struct Point {
    double x, v, a;
  };
  [[nodiscard]] Point at(double t) const {
    Point p{0.0, 0.0, 0.0};
    const double phase = 2 * std::numbers::pi * (start_hz * t + 0.5 * sweep_hz_per_s * t * t);
    const double rate = 2 * std::numbers::pi * (start_hz + sweep_hz_per_s * t);
    const double rate_rate = 2 * std::numbers::pi * sweep_hz_per_s;
    for (std::size_t i = 0; i < amplitudes.size(); ++i) {
      const double h = static_cast<double>(i + 1), angle = h * phase + 0.7 * h * h;
      p.x += amplitudes[i] * std::cos(angle);
      p.v -= amplitudes[i] * h * rate * std::sin(angle);
      p.a -= amplitudes[i] * (h * h * rate * rate * std::cos(angle) + h * rate_rate * std::sin(angle));
    }
    return p;
  }
};

/// Sum (estimate - truth)^2 / sum truth^2.
inline double nmse(const Eigen::Ref<const Eigen::VectorXd>& estimate, const Eigen::Ref<const Eigen::VectorXd>& truth) {
  return (estimate - truth).squaredNorm() / truth.squaredNorm();
}

}  // namespace support
