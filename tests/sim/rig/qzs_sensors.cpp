#include "sim/rig/qzs_sensors.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "sim/noise.hpp"

namespace test_rig_qzs_sensors {

namespace {

const auto rig = std::make_shared<const sim::QzsRig>(sim::qzs_twin("T0"), sim::stepped_sine_down());
constexpr double step_v = 5.0 / 8388608.0;
constexpr double laser_v_per_m = 4.0 / 35e-3, accelerometer_v = 0.1 / 9.80665;

Eigen::MatrixXd record(double duration_s, const sim::RawOptions& options = {}, Eigen::Index block = 10000) {
  sim::RawRecorder recorder(rig, duration_s, options);
  Eigen::MatrixXd volts(recorder.num_frames(), 4);
  for (Eigen::Index n = 0; n < volts.rows();) {
    const auto frames = recorder.next(block);
    REQUIRE(frames.rows() > 0);
    volts.middleRows(n, frames.rows()) = 5.0 * frames;
    n += frames.rows();
  }
  CHECK(recorder.next(block).rows() == 0);
  return volts;
}

double rms(const Eigen::ArrayXd& values) {
  return std::sqrt(values.square().mean());
}

/// Amplitude of the component at f over whole periods.
double amplitude(const Eigen::ArrayXd& values, double hz) {
  const Eigen::ArrayXd phase =
      Eigen::ArrayXd::LinSpaced(values.size(), 0.0, static_cast<double>(values.size() - 1)) * (2 * M_PI * hz / 25600.0);
  return 2.0 / static_cast<double>(values.size()) *
         std::hypot((values * phase.cos()).sum(), (values * phase.sin()).sum());
}

}  // namespace

TEST_CASE("the record is the same for any block size and another for another seed", "[sim][qzs_sensors]") {
  const auto expected = record(0.7, {}, 17920);
  CHECK(record(0.7, {}, 1) == expected);
  CHECK(record(0.7, {}, 7) == expected);
  CHECK(record(0.7, {}, 4096) == expected);
  CHECK(record(0.7, {.seed = 2}) != expected);
  // And the first seconds do not depend on the length.
  CHECK(record(1.1).topRows(expected.rows()) == expected);
}

TEST_CASE("ideal sensors show the motion to half a step of the converter", "[sim][qzs_sensors]") {
  const auto volts = record(12.0, {.level = sim::SensorLevel::ideal});
  sim::QzsTrajectory trajectory(rig, 12.0);
  double worst = 0.0;
  for (Eigen::Index n = 0; n < volts.rows(); ++n) {
    const auto& s = trajectory.at(static_cast<double>(n) / 25600.0);
    const Eigen::RowVector4d expected(laser_v_per_m * s.base.r_m, laser_v_per_m * (s.x + s.base.r_m),
                                      accelerometer_v * s.base.ddr_m_per_s2,
                                      accelerometer_v * (s.a + s.base.ddr_m_per_s2));
    worst = std::max(worst, (volts.row(n) - expected).cwiseAbs().maxCoeff());
  }
  CHECK(worst <= 0.5 * step_v * (1 + 1e-9));
  CHECK((volts / step_v - (volts / step_v).array().round().matrix()).norm() < 1e-6);
}

TEST_CASE("a full laser holds 32 frames, shows 10 um steps and the base's motion of 16 frames before",
          "[sim][qzs_sensors]") {
  const auto volts = record(8.0, {.noise = 0.0});
  const auto updates = volts.rows() / 32;
  sim::QzsTrajectory trajectory(rig, 8.0);
  double worst = 0.0;
  for (Eigen::Index i = 0; i < updates; ++i) {
    for (Eigen::Index c = 0; c < 2; ++c) {
      const auto held = volts.col(c).segment(32 * i, 32);
      REQUIRE(held.minCoeff() == held.maxCoeff());
      const double steps = held[0] / laser_v_per_m / 10e-6;
      REQUIRE(std::abs(steps - std::round(steps)) < 1e-3);
    }
    const double t = static_cast<double>(32 * i - 16) / 25600.0;
    const double drift = 30e-6 * std::sin(2 * M_PI * t / 1400 + 0.3) + 20e-6 * t / 1800;
    const double shown = 1.003 * trajectory.at(t).base.r_m + 1.2e-3 + drift;
    worst = std::max(worst, std::abs(volts(32 * i, 0) / laser_v_per_m - shown));
  }
  CHECK(worst < 5.01e-6);  // half a laser's step and half a converter's
}

TEST_CASE("lasers stop at 35 mm and nothing passes the converter's range", "[sim][qzs_sensors]") {
  // A payload driven beyond 35 mm on the upper branch.
  const auto wild = std::make_shared<const sim::QzsRig>(
      sim::QzsParameters{.c = 0.3, .mu_kinetic = 0.0, .mu_static = 0.0},
      sim::sine_steps({.frequencies_hz = {1.3}, .amplitude_m = 12e-3, .transition_s = 1.0}));
  sim::RawRecorder recorder(wild, 20.0, {.noise = 0.0});
  const auto frames = recorder.next(recorder.num_frames());
  CHECK(5.0 * frames.col(1).maxCoeff() == Approx(4.0).margin(step_v));
  CHECK(5.0 * frames.col(1).minCoeff() == Approx(-4.0).margin(step_v));
  CHECK(frames.maxCoeff() < 1.0);
}

TEST_CASE("every noise and interference has its nominal strength", "[sim][qzs_sensors]") {
  const double duration = 50.0;  // whole periods of 50.02 and 148.7 Hz
  const auto quiet = record(duration, {.level = sim::SensorLevel::ideal});
  const Eigen::ArrayXXd noise = (record(duration, {.level = sim::SensorLevel::noise}) - quiet).array();
  for (Eigen::Index c = 0; c < 4; ++c) {
    // Four standard errors of a line in white noise, rms sqrt(2 / n); a laser's is 1.4 mV over 40 000 updates.
    const double margin = c < 2 ? 4e-5 : 1e-5;
    CHECK(amplitude(noise.col(c), 50.02) == Approx(c < 2 ? 0.5e-3 : 1.5e-3).margin(margin));
    CHECK(amplitude(noise.col(c), 100.04) == Approx(c < 2 ? 0.1e-3 : 0.3e-3).margin(margin));
    CHECK(amplitude(noise.col(c), 150.06) == Approx(c < 2 ? 0.25e-3 : 0.6e-3).margin(margin));
  }
  // Lasers: 12 um held, 10 um steps (rms 10 / sqrt 12), mains of 0.4 mV rms, 30 uV.
  const double laser_mains = std::sqrt((0.25 + 0.01 + 0.0625) / 2) * 1e-3;
  const double laser = std::hypot(std::hypot(12e-6, 10e-6 / std::sqrt(12.0)) * laser_v_per_m, laser_mains, 30e-6);
  for (Eigen::Index c = 0; c < 2; ++c) CHECK(rms(noise.col(c)) == Approx(laser).epsilon(0.02));
  // Accelerometers: fan, vibration of 0.05 m/s^2 rms (the filter's shape leaves it within 10 %), 60 uV, mains.
  const double mains = std::sqrt((2.25 + 0.09 + 0.36) / 2) * 1e-3;
  for (Eigen::Index c = 2; c < 4; ++c) {
    CHECK(amplitude(noise.col(c), 148.7) == Approx(0.15 * accelerometer_v).epsilon(0.02));
    const double rest =
        rms(noise.col(c)) * rms(noise.col(c)) - mains * mains - 60e-6 * 60e-6 - std::pow(0.15 * accelerometer_v, 2) / 2;
    CHECK(std::sqrt(rest) == Approx(0.05 * accelerometer_v).epsilon(0.1));
  }
  // Twice the factor is twice the noise, but for the lasers' steps.
  const Eigen::ArrayXXd twice =
      (record(2.0, {.level = sim::SensorLevel::noise, .noise = 2.0}) - quiet.topRows(51200)).array();
  CHECK((twice.rightCols(2) - 2.0 * noise.topRows(51200).rightCols(2)).abs().maxCoeff() < 2.0 * step_v);
}

TEST_CASE("a full accelerometer is scaled, high-passed once settled and offset after that", "[sim][qzs_sensors]") {
  const auto volts = record(30.0, {.noise = 0.0});
  // Late in the record the base moves by sines of 1.84 Hz and harmonics: the offset is the mean over 46 periods.
  const Eigen::Index period_frames = std::lround(46 / 1.84 * 25600);
  CHECK(volts.col(2).tail(period_frames).mean() == Approx(0.20e-3).margin(2e-6));
  const auto quiet = record(30.0, {.level = sim::SensorLevel::ideal});
  for (const auto& [c, gain, cutoff] : {std::tuple{2, 1.020, 0.40}, {3, 0.985, 0.45}}) {
    const double f = 1.84;
    // A window that lets only the line at 1.84 Hz through: the last 11.5 periods of an even tenth.
    const Eigen::Index window = std::lround(11.5 / f * 25600 / 0.5) / 2;
    const double before = amplitude(quiet.col(c).tail(window).array(), f);
    const double after = amplitude(volts.col(c).tail(window).array(), f);
    CHECK(after / before == Approx(gain / std::hypot(1.0, cutoff / f)).epsilon(3e-3));
  }
  CHECK(sim::rig_sensors(sim::SensorLevel::full, sim::qzs_twin("T1"))[2].highpass_hz == std::vector{0.40, 0.30});
  CHECK(sim::rig_sensors(sim::SensorLevel::full, {})[0].lag_s == Approx(31.5 / 25600));
}

TEST_CASE("the mount resonance of T1 is a suspension's transmissibility", "[sim][qzs_sensors]") {
  sim::QzsParameters bouncing;
  bouncing.bounce_hz = 10.7;
  // Locked payload: y = r, a pure sine at 5 Hz.
  bouncing.mu_kinetic = bouncing.mu_static = 100.0;
  const auto shaken =
      std::make_shared<const sim::QzsRig>(bouncing, sim::sine_steps({.frequencies_hz = {5.0}, .amplitude_m = 1e-3}));
  sim::RawRecorder recorder(shaken, 20.0, {.level = sim::SensorLevel::ideal});
  const Eigen::ArrayXXd frames = recorder.next(recorder.num_frames()).bottomRows(51200).array();
  const double q = 5.0 / 10.7, d = 2 * 0.1 * q;
  const double transmitted = std::hypot(1.0, d) / std::hypot(1 - q * q, d);
  for (const int c : {0, 2})
    CHECK(amplitude(frames.col(c + 1), 5.0) / amplitude(frames.col(c), 5.0) == Approx(transmitted).epsilon(1e-5));
}

TEST_CASE("failing sensors rail, hold or clip for as long as asked", "[sim][qzs_sensors]") {
  using Kind = sim::SensorProblem::Kind;
  const auto good = record(6.0);
  const auto bad = record(
      6.0, {.problems = {{Kind::rail, 1, 4.0, 4.3}, {Kind::hold, 0, 5.0, 5.2}, {Kind::clip, 3, 3.0, 5.5, 1e-3}}});
  const auto frame = [](double t) { return static_cast<Eigen::Index>(std::llround(t * 25600)); };
  CHECK(bad(frame(4.0), 1) == Approx(5.0).margin(step_v));
  CHECK(bad.col(1).segment(frame(4.0), frame(0.3)).minCoeff() == bad(frame(4.0), 1));
  CHECK(bad(frame(4.3), 1) == good(frame(4.3), 1));
  CHECK((bad.col(0).segment(frame(5.0), frame(0.2)).array() == good(frame(5.0), 0)).all());
  CHECK(bad.col(3).segment(frame(3.0), frame(2.5)).cwiseAbs().maxCoeff() == Approx(1e-3).margin(step_v));
  CHECK(bad.col(2) == good.col(2));
  CHECK_THROWS_AS(sim::RawRecorder(rig, 1.0, {.problems = {{Kind::rail, 4, 0.0, 1.0}}}), std::invalid_argument);
  CHECK_THROWS_AS(sim::RawRecorder(rig, 1.0, {.noise = -1.0}), std::invalid_argument);
}

TEST_CASE("random sensors spread as their data sheet says and are another set for another seed", "[sim][qzs_sensors]") {
  constexpr int num_seeds = 400;  // a standard deviation is then known to 3.5 %
  Eigen::ArrayXd laser_gain(num_seeds), accelerometer_gain(num_seeds), offset(num_seeds), drift(num_seeds),
      cutoff(num_seeds), period(num_seeds);
  for (int i = 0; i < num_seeds; ++i) {
    const auto sensors =
        sim::rig_sensors(sim::SensorLevel::random, sim::qzs_twin("T0"), static_cast<std::uint64_t>(1000 + i));
    laser_gain(i) = sensors[1].gain - 1.0;
    accelerometer_gain(i) = sensors[2].gain - 1.0;
    offset(i) = sensors[0].offset;
    drift(i) = sensors[1].drift.sine_m;
    period(i) = sensors[1].drift.period_s;
    cutoff(i) = sensors[3].highpass_hz.at(0);
    CHECK(sensors[1].lag_s == sim::rig_sensors(sim::SensorLevel::full, {})[1].lag_s);
  }
  const double four_std = 4.0 * 0.035;
  CHECK(rms(laser_gain) == Approx(0.005).epsilon(four_std));
  CHECK(rms(accelerometer_gain) == Approx(0.015).epsilon(four_std));
  CHECK(rms(offset) == Approx(1e-3).epsilon(four_std));
  CHECK(rms(drift) == Approx(0.04e-3).epsilon(four_std));
  CHECK((cutoff.minCoeff() >= 0.3 && cutoff.maxCoeff() <= 0.6));
  CHECK((period.minCoeff() >= 700.0 && period.maxCoeff() <= 2500.0));
  CHECK(cutoff.mean() == Approx(0.45).margin(4.0 * 0.3 / std::sqrt(12.0 * num_seeds)));
}

TEST_CASE("a random sensor reads what its drawn gain, offset and drift make of the motion", "[sim][qzs_sensors]") {
  const auto sensor = sim::rig_sensors(sim::SensorLevel::random, sim::qzs_twin("T0"), 7)[0];
  const Eigen::ArrayXd expected = record(4.0, {.level = sim::SensorLevel::ideal}).col(0);
  const Eigen::ArrayXd got = record(4.0, {.level = sim::SensorLevel::random, .noise = 0.0, .seed = 7}).col(0);
  const Eigen::Index lag = 31, n = got.rows() - lag;  // 31.5 frames: half a frame of 0.06 m/s is 1.2 um
  const Eigen::ArrayXd wanted = sensor.gain * expected.head(n) + laser_v_per_m * (sensor.offset + sensor.drift.at(2.0));
  // Held for 32 frames, shown in steps of 10 um, and the drift moves on: 1 um.
  CHECK(rms(got.tail(n) - wanted) < laser_v_per_m * 20e-6);
}

TEST_CASE("the equation as recorded has the payload laser's unit of length", "[sim][qzs_sensors]") {
  const double g = 0.99;
  for (const sim::TrueTerm& term : sim::true_terms_as_recorded(sim::qzs_twin("T1"), g)) {
    CAPTURE(term.name);
    if (term.name == "x" || term.name == "v" || term.name == "ddr") CHECK(std::abs(term.value) <= 50.0);
    if (term.name == "x^3") CHECK(term.value == Approx(-9.5e4 / (g * g)));
    if (term.name == "x^2") CHECK(term.value == Approx(200.0 / g));
    if (term.name == "sgn(v)") CHECK(term.value == Approx(-0.065 * g));
  }
}

}  // namespace test_rig_qzs_sensors
