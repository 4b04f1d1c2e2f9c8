#include "sim/rig/qzs_regimes.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "sim/rig/qzs_rig.hpp"

namespace {

constexpr double rate = 256.0, dwell_s = 20.0;

/// Motion made up: in each dwell x = amplitude / A r, so of that amplitude, and on the upper branch if it is positive.
struct Made {
  sim::Programme programme;
  Eigen::VectorXd x;
  std::vector<int> modes;

  explicit Made(const std::vector<double>& amplitudes_m) {
    sim::SineSteps steps{.frequencies_hz = {}, .amplitude_m = 5e-3, .dwell_s = dwell_s, .transition_s = 2.0};
    for (std::size_t k = 0; k < amplitudes_m.size(); ++k)
      steps.frequencies_hz.push_back(1.7 - 0.05 * static_cast<double>(k));
    programme = sim::sine_steps(steps);
    const sim::BaseMotion base(programme);
    x.resize(std::lround(programme.duration_s * rate));
    for (Eigen::Index n = 0; n < x.size(); ++n) {
      const double t = static_cast<double>(n) / rate;
      x[n] = amplitudes_m[static_cast<std::size_t>(t / dwell_s)] / steps.amplitude_m * base.at(t).r_m;
    }
    modes.assign(static_cast<std::size_t>(x.size()), sim::qzs_slip_up);
  }
  void stick_at(double t_s) { modes[static_cast<std::size_t>(t_s * rate)] = sim::qzs_stick; }
  void check(double enter_m, double leave_m) const {
    const auto levels = sim::true_levels(x, modes, rate, programme);
    // A sine of 1.7 Hz at 256 Hz misses its crest by (pi f / rate)^2 / 2 = 2e-4 at most.
    CHECK(levels.high_enter_m == Approx(enter_m).epsilon(2.5e-4));
    CHECK(levels.high_leave_m == Approx(leave_m).epsilon(2.5e-4));
  }
};

}  // namespace

TEST_CASE("levels lie between the branches at the jump, and below the smallest of the upper one",
          "[sim][qzs_regimes]") {
  const double none = std::numeric_limits<double>::infinity();
  Made({-10e-3, -12e-3, 27e-3, 20e-3}).check(16.875e-3, 16e-3);
  Made({-10e-3, -12e-3, 27e-3, 25e-3}).check(16.875e-3, 16.875e-3);  // never leaves above where it enters
  Made({-8e-3, 32e-3, -12e-3, 27e-3, 10e-3}).check(0.625 * std::sqrt(32e-3 * 27e-3), 8e-3);  // the mean of two jumps
  Made({-10e-3, -18e-3, 24e-3}).check(1.1 * 18e-3, 0.8 * 24e-3);  // clear of the lower branch
  Made({30e-3, 25e-3, -12e-3}).check(20e-3, 20e-3);               // only down
  Made({-10e-3, -12e-3}).check(none, none);                       // none
}

TEST_CASE("a dwell does not count if the payload sticks or a hand is at it to the end, or the motion ends before",
          "[sim][qzs_regimes]") {
  const Made made({-10e-3, -12e-3, 27e-3, 20e-3});
  Made stuck = made;
  stuck.stick_at(72.0);  // before the last third of the last dwell
  stuck.check(16.875e-3, 16e-3);
  stuck.stick_at(75.0);
  stuck.check(16.875e-3, 16.875e-3);
  stuck.stick_at(35.0);  // no lower dwell right before the upper one
  stuck.check(0.8 * 27e-3, 0.8 * 27e-3);

  Made between = made;  // a dwell that ends between two samples is seen to its end
  between.programme.duration_s += 0.5 / rate;
  between.check(16.875e-3, 16e-3);
  Made cut = made;
  cut.x.conservativeResize(cut.x.size() - 1);
  cut.modes.pop_back();
  cut.check(16.875e-3, 16.875e-3);

  Made pushed = made;
  pushed.programme.manual = {{.from_s = 55.0, .to_s = 59.0, .by_base = -0.8, .why = "pushed"}};
  pushed.x.segment(40 * 256, 19 * 256) *= -0.5;
  pushed.check(16.875e-3, 16e-3);
  pushed.programme.manual[0].to_s = 59.5;  // no cycle of 1.6 Hz left
  pushed.check(16e-3, 16e-3);
}

TEST_CASE("a base at rest makes no dwell, and iterations of a step are one", "[sim][qzs_regimes]") {
  Made rest({-12e-3, 27e-3, 20e-3});
  rest.programme.nodes[1].harmonics_m = {};
  rest.check(16e-3, 16e-3);
  Made whole({-12e-3, 27e-3, 20e-3});
  whole.programme.nodes.insert(whole.programme.nodes.begin() + 2, whole.programme.nodes[1]);
  whole.programme.nodes[2].t_s = 30.0;
  whole.stick_at(29.0);  // the end of an iteration is not that of the step
  whole.check(16.875e-3, 16e-3);
}

TEST_CASE("levels need one mode for each x", "[sim][qzs_regimes]") {
  Made made({-12e-3});
  made.modes.pop_back();
  CHECK_THROWS_AS(sim::true_levels(made.x, made.modes, rate, made.programme), std::invalid_argument);
}
