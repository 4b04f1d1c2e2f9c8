#include "ident/switches/held_by_ground.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <utility>

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double rate_hz = 256.0, half_cycle_s = 0.5;

/// A base that swings once a second, and a payload of which each half cycle sees `slip_s` of motion, half a sine of the
/// speed, before it stands still on the ground again.
dsp::Prepared stick_and_slip(double slip_s) {
  const auto n = static_cast<Index>(60.0 * rate_hz);
  constexpr double speed_m_per_s = 0.2, base_m = 0.05, pi = 3.141592653589793;
  dsp::Motion motion{.sample_rate_hz = rate_hz};
  VectorXd y(n), dy(n), ddy(n), r(n), dr(n), ddr(n);
  for (Index i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) / rate_hz, omega = pi / half_cycle_s;
    const auto half_cycle = static_cast<int>(t / half_cycle_s);
    const double sign = half_cycle % 2 == 0 ? 1.0 : -1.0, phase = pi * (t - half_cycle * half_cycle_s) / slip_s;
    const bool slips = phase < pi;
    const double way_m = speed_m_per_s * slip_s / pi;
    y(i) = sign * way_m * (slips ? -std::cos(phase) : 1.0);
    dy(i) = slips ? sign * speed_m_per_s * std::sin(phase) : 0.0;
    ddy(i) = slips ? sign * speed_m_per_s * pi / slip_s * std::cos(phase) : 0.0;
    r(i) = base_m * std::sin(omega * t + 1.0);
    dr(i) = base_m * omega * std::cos(omega * t + 1.0);
    ddr(i) = -omega * omega * r(i);
  }
  const auto add = [&](const char* name, VectorXd values) {
    motion.signals.push_back({.name = name, .unit = "m", .values = std::move(values)});
  };
  add("t", VectorXd::LinSpaced(n, 0.0, static_cast<double>(n - 1) / rate_hz));
  add("x", y - r), add("v", dy - dr), add("a", ddy - ddr);
  add("y", y), add("dy", dy), add("ddy", ddy), add("r", r), add("dr", dr), add("ddr", ddr);
  dsp::Prepared prepared;
  prepared.intermediate = std::move(motion);
  prepared.options.state_cutoff_hz = 64.0;
  return prepared;
}

}  // namespace

TEST_CASE("the ground holds the payload between its slips, to a part of a sample", "[ident][held_by_ground]") {
  for (const double slip_s : {0.15, 0.3}) {
    CAPTURE(slip_s);
    const VectorXd slipping = ident::slipping_fraction(stick_and_slip(slip_s));
    REQUIRE(slipping.size() == static_cast<Index>(60.0 * rate_hz));
    CHECK(slipping.minCoeff() >= 0.0);
    CHECK(slipping.maxCoeff() <= 1.0);
    // Ends of the record apart, where what comes before or after is not seen.
    const auto cycle = static_cast<Index>(2.0 * half_cycle_s * rate_hz);
    double largest = 0.0;
    for (Index i = cycle; i < slipping.size() - cycle; ++i) {
      const double within_s = std::fmod(static_cast<double>(i) / rate_hz, half_cycle_s) * rate_hz;
      const double to_end = std::abs(within_s - slip_s * rate_hz);
      if (within_s < 1.0 || within_s > half_cycle_s * rate_hz - 1.0 || to_end < 1.0) continue;
      largest = std::max(largest, std::abs(slipping(i) - (within_s < slip_s * rate_hz ? 1.0 : 0.0)));
    }
    CHECK(largest == 0.0);
    // Half a sine carried on straight from two samples inside is zero within a tenth of a sample of where it is.
    CHECK(slipping.segment(cycle, 58 * cycle).mean() ==
          Approx(slip_s / half_cycle_s).margin(2.0 * 0.1 / (half_cycle_s * rate_hz)));
  }
}

TEST_CASE("a payload that its ground hardly ever holds slips all the time", "[ident][held_by_ground]") {
  CHECK(ident::slipping_fraction(stick_and_slip(half_cycle_s)).size() == 0);
  dsp::Prepared no_base = stick_and_slip(0.3);
  std::erase_if(no_base.intermediate.signals, [](const dsp::Signal& signal) { return signal.name == "r"; });
  CHECK(ident::slipping_fraction(no_base).size() == 0);
}
