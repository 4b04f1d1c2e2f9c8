#include "dsp/filter/kink_kernel.hpp"

#include <catch2/catch.hpp>
#include <cmath>

TEST_CASE("a signal with kinks is its low-passed self and the kernels of its kinks", "[dsp][kink_kernel]") {
  // Slopes of 1 and -1 in turn, changing at irregular times.
  constexpr double rate_hz = 8192.0;
  const dsp::SpectralBand band{12.8, 20.0};
  const std::vector<double> kinks_s{2.0, 2.31, 2.9, 3.4, 4.0007, 4.4, 5.013, 5.6, 6.0};
  Eigen::VectorXd signal(static_cast<Eigen::Index>(8.0 * rate_hz));
  for (Eigen::Index i = 0; i < signal.size(); ++i) {
    const double t = static_cast<double>(i) / rate_hz;
    signal(i) = t - 4.0;
    double sign = -1.0;
    for (const double kink_s : kinks_s) signal(i) += 2.0 * sign * std::max(0.0, t - kink_s), sign = -sign;
  }
  const Eigen::VectorXd low_passed = dsp::ExtendedSpectrum(signal, rate_hz).derivative(0, band);
  const dsp::KinkKernel kernel(band);
  double worst = 0.0, rounded = 0.0;
  for (auto i = static_cast<Eigen::Index>(2.0 * rate_hz); i < static_cast<Eigen::Index>(6.0 * rate_hz); ++i) {
    const double t = static_cast<double>(i) / rate_hz;
    double restored = low_passed(i), sign = -1.0;
    for (const double kink_s : kinks_s) restored += 2.0 * sign * kernel(t - kink_s), sign = -sign;
    worst = std::max(worst, std::abs(restored - signal(i)));
    rounded = std::max(rounded, std::abs(low_passed(i) - signal(i)));
  }
  CHECK(rounded > 5e-3);
  // What is left is the samples' own: a kink between two of them is a twelfth of a cell off, 2e-5.
  CHECK(worst <= 5e-5);
}

TEST_CASE("the slope of the kernel is its derivative, half a jump at either side of zero", "[dsp][kink_kernel]") {
  const dsp::KinkKernel kernel({30.0, 50.0});
  CHECK(kernel.slope(0.0) == 0.0);
  CHECK(kernel.slope(1e-9) == Approx(0.5).epsilon(1e-5));
  CHECK(kernel.slope(-1e-9) == Approx(-0.5).epsilon(1e-5));
  for (const double tau_s : {1e-3, 3.3e-3, 0.0171, 0.05, -0.02})
    CHECK(kernel.slope(tau_s) == Approx((kernel(tau_s + 1e-6) - kernel(tau_s - 1e-6)) / 2e-6).margin(1e-4));
  CHECK(std::abs(kernel(0.99 * kernel.reach_s())) <= 1e-3 * std::abs(kernel(0.0)));
  CHECK(kernel(2.0 * kernel.reach_s()) == 0.0);
  CHECK_THROWS_AS(dsp::KinkKernel({20.0, 20.0}), std::invalid_argument);
}
