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

TEST_CASE("a kernel added to samples is its value at each of them", "[dsp][kink_kernel]") {
  const dsp::KinkKernel kernel({12.8, 20.0});
  constexpr double spacing_s = 1.0 / 256.0;
  for (const Eigen::Index count : {1, 3, 4, 5, 240}) {
    const double tau_s = count == 240 ? -0.47 : -1.7 * spacing_s;
    Eigen::VectorXd values = Eigen::VectorXd::Constant(count + 2, 3.0);
    kernel.add(0.2, tau_s, spacing_s, values.segment(1, count));
    CHECK(values(0) == 3.0);
    CHECK(values(count + 1) == 3.0);
    for (Eigen::Index i = 0; i < count; ++i)  // to the rounding of 3
      CHECK(values(i + 1) == Approx(3.0 + 0.2 * kernel(tau_s + static_cast<double>(i) * spacing_s)).epsilon(1e-15));
  }
  Eigen::VectorXd ends = Eigen::VectorXd::Zero(2);
  kernel.add(1.0, -kernel.reach_s(), 2.0 * kernel.reach_s(), ends);
  CHECK(ends.cwiseAbs().maxCoeff() <= 1e-3 * std::abs(kernel(0.0)));
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
