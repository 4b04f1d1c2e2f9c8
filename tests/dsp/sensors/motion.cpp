#include "dsp/sensors/motion.hpp"

#include <catch2/catch.hpp>

#include "support/signals.hpp"

namespace test_motion {

namespace {
constexpr double rate_hz = 64.0;
constexpr Eigen::Index num_samples = 3000;
const dsp::MotionOptions options{.band = {.rolloff_hz = 16.0, .cutoff_hz = 24.0}};
const support::SweptHarmonics payload, base{.start_hz = 1.2, .sweep_hz_per_s = 1e-3, .amplitudes = {4e-3, 1e-4}};

// The base or payload motion, or one of its derivatives, lag_s late.
Eigen::VectorXd samples(const support::SweptHarmonics& signal, int derivative, double lag_s = 0.0) {
  return Eigen::VectorXd::NullaryExpr(num_samples, [&](Eigen::Index i) {
    const auto p = signal.at(static_cast<double>(i) / rate_hz - lag_s);
    return derivative == 0 ? p.x : derivative == 1 ? p.v : p.a;
  });
}

dsp::Recording recording(const std::vector<std::pair<dsp::Channel, Eigen::VectorXd>>& channels) {
  dsp::Recording result{.name = "made up", .sample_rate_hz = rate_hz};
  result.samples.resize(num_samples, static_cast<Eigen::Index>(channels.size()));
  for (const auto& [channel, values] : channels) {
    result.samples.col(static_cast<Eigen::Index>(result.channels.size())) = values;
    result.channels.push_back(channel);
  }
  return result;
}

// The continuation beyond the ends is exact to about 1e-4 of the signal; inside it is rounding.
void check_close(const Eigen::VectorXd& actual, const Eigen::VectorXd& expected) {
  CHECK((actual - expected).cwiseAbs().maxCoeff() <= 5e-4 * expected.cwiseAbs().maxCoeff());
}
}  // namespace

TEST_CASE("relative motion is payload minus base, with all derivatives", "[dsp][motion]") {
  const auto motion =
      dsp::relative_motion(recording({{{.name = "top", .role = dsp::Role::y, .unit = "m"}, samples(payload, 0)},
                                      {{.name = "base", .role = dsp::Role::r, .unit = "m"}, samples(base, 0)}}),
                           options);
  CHECK(motion.signals.front().name == "t");
  CHECK(motion.at("t")(num_samples - 1) == Approx((num_samples - 1) / rate_hz));
  CHECK(motion.at("x") == samples(payload, 0) - samples(base, 0));
  check_close(motion.at("v"), samples(payload, 1) - samples(base, 1));
  check_close(motion.at("a"), samples(payload, 2) - samples(base, 2));
  check_close(motion.at("dr"), samples(base, 1));
  check_close(motion.at("ddy"), samples(payload, 2));
  CHECK(motion.edge_samples == 8);
  CHECK(motion.dropped_power_fraction <= 1e-6);
  CHECK_THROWS_WITH(motion.at("force"), Catch::Contains("t, x, v, a, r, dr, ddr, y, dy, ddy"));
}

TEST_CASE("without a base the payload's motion is the relative motion", "[dsp][motion]") {
  for (const dsp::Role role : {dsp::Role::x, dsp::Role::y}) {
    const auto motion = dsp::relative_motion(recording({{{.name = "d", .role = role}, samples(payload, 0)}}), options);
    CHECK(motion.find("r") == nullptr);
    CHECK(motion.at("x") == motion.at("y"));
    CHECK(motion.at("v") == motion.at("dy"));
    check_close(motion.at("a"), samples(payload, 2));
  }
}

TEST_CASE("measured accelerations are preferred, and differenced for the relative one", "[dsp][motion]") {
  const Eigen::VectorXd ddy = samples(payload, 2).array() + 0.02, ddr = samples(base, 2).array() - 0.01;
  const auto record = recording({{{.name = "y", .role = dsp::Role::y}, samples(payload, 0)},
                                 {{.name = "r", .role = dsp::Role::r}, samples(base, 0)},
                                 {{.name = "ay", .role = dsp::Role::ddy}, ddy},
                                 {{.name = "ar", .role = dsp::Role::ddr}, ddr}});
  const dsp::Motion motion = dsp::relative_motion(record, options);
  CHECK(motion.at("a") == ddy - ddr);
  CHECK(motion.at("ddr") == ddr);
  auto from_displacement = options;
  from_displacement.acceleration = dsp::AccelerationSource::displacement;
  const dsp::Motion computed = dsp::relative_motion(record, from_displacement);
  check_close(computed.at("a"), samples(payload, 2) - samples(base, 2));

  auto from_accelerometer = options;
  from_accelerometer.acceleration = dsp::AccelerationSource::accelerometer;
  CHECK_THROWS_AS(dsp::relative_motion(recording({{{.name = "y", .role = dsp::Role::y}, ddy}}), from_accelerometer),
                  dsp::Fault);
}

TEST_CASE("a known delay is taken out of its channel", "[dsp][motion]") {
  const double lag_s = 0.0041;
  const auto motion = dsp::relative_motion(
      recording({{{.name = "y", .role = dsp::Role::y, .delay_s = lag_s}, samples(payload, 0, lag_s)}}), options);
  check_close(motion.at("x"), samples(payload, 0));
  check_close(motion.at("v"), samples(payload, 1));
}

TEST_CASE("a measured velocity is integrated into nothing and differentiated once", "[dsp][motion]") {
  const auto motion =
      dsp::relative_motion(recording({{{.name = "x", .role = dsp::Role::x}, samples(payload, 0)},
                                      {{.name = "v", .role = dsp::Role::v}, samples(payload, 1).array() + 1.0}}),
                           options);
  CHECK(motion.at("v") == Eigen::VectorXd(samples(payload, 1).array() + 1.0));
  check_close(motion.at("a"), samples(payload, 2));
}

TEST_CASE("forces and channels without a role keep their samples under usable names", "[dsp][motion]") {
  const Eigen::VectorXd values = samples(base, 0);
  const auto motion =
      dsp::relative_motion(recording({{{.name = "d", .role = dsp::Role::x, .unit = "m"}, samples(payload, 0)},
                                      {{.name = "2nd coil [A]", .unit = "A"}, values},
                                      {{.name = "x", .unit = "V"}, values},
                                      {{.name = "shaker", .role = dsp::Role::f, .unit = "N"}, values}}),
                           options);
  CHECK(motion.at("f") == values);
  CHECK(motion.find("f")->unit == "N");
  CHECK(motion.at("_2nd_coil__A_") == values);
  CHECK(motion.at("x_2") == values);
}

TEST_CASE("bad intervals are marked, with a margin where asked", "[dsp][motion]") {
  auto record = recording({{{.name = "d", .role = dsp::Role::x}, samples(payload, 0)}});
  record.bad = {{1.0, 2.0, "dropout"}};
  auto motion = dsp::relative_motion(record, options);
  CHECK(std::count(motion.excluded.begin(), motion.excluded.end(), 1) == 65);
  CHECK(motion.excluded[64] == 1);
  CHECK(motion.excluded[63] == 0);
  dsp::mark(motion, {1.0, 2.0, "dropout"}, 0.5);
  CHECK(std::count(motion.excluded.begin(), motion.excluded.end(), 1) == 129);
  dsp::mark(motion, {-5.0, 1e9, "all"}, 0.5);
  CHECK(std::count(motion.excluded.begin(), motion.excluded.end(), 1) == num_samples);
}

TEST_CASE("a record without a motion of the payload is refused with what was found", "[dsp][motion]") {
  const auto record = recording({{{.name = "acc", .role = dsp::Role::ddr}, samples(payload, 2)}});
  CHECK_THROWS_WITH(dsp::relative_motion(record, options), Catch::Contains("acc (ddr)"));
  CHECK_THROWS_AS(dsp::relative_motion(record, dsp::MotionOptions{}), std::invalid_argument);
  // An acceleration of the payload can be integrated, from a frequency that is said.
  const auto alone = recording({{{.name = "acc", .role = dsp::Role::ddy}, samples(payload, 2)}});
  CHECK_THROWS_AS(dsp::relative_motion(alone, options), std::invalid_argument);
}

TEST_CASE("what is not measured in metres keeps its unit through the derivatives", "[dsp][motion]") {
  const auto units = [](const dsp::Motion& motion) {
    return std::vector{motion.find("x")->unit, motion.find("v")->unit, motion.find("a")->unit};
  };
  const auto angle = dsp::relative_motion(
      recording({{{.name = "pendulum", .role = dsp::Role::y, .unit = "rad"}, samples(payload, 0)}}), options);
  CHECK(units(angle) == std::vector<std::string>{"rad", "rad/s", "rad/s^2"});
  const auto mixed =
      dsp::relative_motion(recording({{{.name = "laser", .role = dsp::Role::y, .unit = "V"}, samples(payload, 0)},
                                      {{.name = "acc", .role = dsp::Role::ddy, .unit = "m/s^2"}, samples(payload, 2)}}),
                           options);
  CHECK(units(mixed) == std::vector<std::string>{"V", "V/s", "m/s^2"});
}

TEST_CASE("a sine whose values are held is the sine again, but for images above its own rate's half", "[dsp][motion]") {
  constexpr int hold = 8;
  constexpr double sine_hz = 0.3 * rate_hz / hold;
  const Eigen::VectorXd angle =
      Eigen::VectorXd::LinSpaced(num_samples, 0.0, num_samples - 1.0) * (2.0 * M_PI * sine_hz / rate_hz);
  dsp::Recording held = recording({{{.name = "slow", .role = dsp::Role::x, .unit = "m"}, angle.array().cos()}});
  for (Eigen::Index i = 0; i < num_samples; ++i) held.samples(i, 0) = held.samples(i / hold * hold, 0);
  held.channels[0].hold_samples = hold;
  held.channels[0].hold_s = hold / rate_hz;
  held.channels[0].delay_s = 0.5 * (hold - 1) / rate_hz;
  dsp::remove_delays(held);
  // About whole periods of its images and of itself, away from the ends.
  const Eigen::Index first = 400, size = 2000;
  const auto part = [&](const auto& other) {
    return 2.0 / static_cast<double>(size) * held.samples.col(0).segment(first, size).dot(other.segment(first, size));
  };
  CHECK(part(angle.array().cos().matrix().eval()) == Approx(1.0).margin(1e-3));
  CHECK(part(angle.array().sin().matrix().eval()) == Approx(0.0).margin(1e-3));
}

}  // namespace test_motion
