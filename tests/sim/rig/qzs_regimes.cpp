#include "sim/rig/qzs_regimes.hpp"

#include <catch2/catch.hpp>
#include <cmath>

namespace {

constexpr double rate = 256.0, dwell_s = 20.0;

/// Motion made up on a rig that would do otherwise: in each dwell x is a factor times r.
struct Made {
  std::shared_ptr<const sim::QzsRig> rig;
  Eigen::VectorXd x;
  std::vector<int> modes;

  explicit Made(const std::vector<double>& factors, double amplitude_m = 5e-3) {
    const sim::SineSteps steps{.frequencies_hz = std::vector<double>(factors.size(), 1.6),
                               .amplitude_m = amplitude_m,
                               .dwell_s = dwell_s,
                               .transition_s = 2.0};
    rig = std::make_shared<const sim::QzsRig>(sim::qzs_twin("T0"), sim::sine_steps(steps));
    x.resize(std::lround(rig->programme().duration_s * rate));
    for (Eigen::Index n = 0; n < x.size(); ++n) {
      const double t = static_cast<double>(n) / rate;
      x[n] = factors[static_cast<std::size_t>(t / dwell_s)] * rig->base().at(t).r_m;
    }
    modes.assign(static_cast<std::size_t>(x.size()), sim::qzs_slip_up);
  }
  void stick(double from_s, double to_s) {
    for (auto n = static_cast<std::size_t>(from_s * rate); n < static_cast<std::size_t>(to_s * rate); ++n)
      modes[n] = sim::qzs_stick;
  }
  [[nodiscard]] std::vector<sim::RegimeInterval> regimes() const { return sim::true_regimes(rig, x, modes, rate); }
};

}  // namespace

TEST_CASE("the branch is the phase against the base, whatever the amplitude", "[sim][qzs_regimes]") {
  for (const double factor : {-3.0, -0.1, 0.1, 3.0}) {
    const auto found = Made({factor, factor}).regimes();
    REQUIRE(found.size() == 1);
    CHECK(found[0].label == (factor > 0.0 ? "high" : "low"));
    CHECK(found[0].to_s == Approx(2 * dwell_s));
  }
}

TEST_CASE("a branch that the motion leaves again while the drive is held is a transient", "[sim][qzs_regimes]") {
  // The rig itself, driven so at 1.6 Hz, settles on the lower branch.
  Made swing({-2.0, -2.0});
  swing.x.segment(static_cast<Eigen::Index>(25 * rate), static_cast<Eigen::Index>(3 * rate)) *= -1.0;
  const auto found = swing.regimes();
  REQUIRE(found.size() == 1);
  CHECK(found[0].label == "low");
}

TEST_CASE("a payload that breaks loose is from then on on the branch on which it settles", "[sim][qzs_regimes]") {
  // In phase for three seconds; the rig itself, driven so at 1.6 Hz, settles on the lower branch.
  Made loose({-2.0, -2.0});
  loose.stick(20.0, 25.0);
  loose.x.segment(static_cast<Eigen::Index>(25 * rate), static_cast<Eigen::Index>(3 * rate)) *= -1.0;
  const auto found = loose.regimes();
  REQUIRE(found.size() == 3);
  CHECK(found[1].label == "stick");
  CHECK(found[2].label == "low");
}

TEST_CASE("stick is the mode, and what slips for less than a cycle between two sticks", "[sim][qzs_regimes]") {
  Made made({-2.0, -2.0});
  made.stick(22.0, 22.1);
  made.stick(22.5, 22.6);  // a cycle lasts 0.625 s
  made.stick(30.0, 30.1);
  const auto found = made.regimes();
  REQUIRE(found.size() == 5);
  CHECK(found[1].label == "stick");
  CHECK(found[1].from_s == 22.0);
  CHECK(found[1].to_s == Approx(22.6).margin(1.0 / rate));
  CHECK(found[3].label == "stick");
  CHECK(found[3].to_s - found[3].from_s == Approx(0.1).margin(1.0 / rate));
}

TEST_CASE("a payload that moves while its base is at rest is on no branch", "[sim][qzs_regimes]") {
  sim::Programme programme = sim::sine_steps(
      {.frequencies_hz = {1.6, 1.6, 1.6}, .amplitude_m = 5e-3, .dwell_s = dwell_s, .transition_s = 2.0});
  REQUIRE(programme.nodes.size() == 3);
  programme.nodes[1].harmonics_m = {};
  Made made({-2.0, -2.0, -2.0});
  made.rig = std::make_shared<const sim::QzsRig>(sim::qzs_twin("T0"), programme);
  made.stick(25.0, 40.5);
  const auto found = made.regimes();
  REQUIRE(found.size() == 4);
  CHECK(found[0].label == "low");
  CHECK(found[0].to_s == Approx(programme.nodes[1].t_s + programme.nodes[1].transition_s).margin(1.0 / rate));
  CHECK(found[1].label == "free");
  CHECK(found[2].label == "stick");
  CHECK(found[3].label == "low");
}

TEST_CASE("an exact motion needs one mode for each x, and a rate", "[sim][qzs_regimes]") {
  Made made({-1.0});
  CHECK_THROWS_AS(sim::true_regimes(made.rig, made.x, made.modes, 0.0), std::invalid_argument);
  made.modes.pop_back();
  CHECK_THROWS_AS(sim::true_regimes(made.rig, made.x, made.modes, rate), std::invalid_argument);
}
