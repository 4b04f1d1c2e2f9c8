#include "dsp/sensors/sensor_problems.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "dsp/filter/spectral.hpp"
#include "support/signals.hpp"

namespace test_sensors_sensor_problems {

using dsp::SensorProblemKind;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double rate_hz = 64.0;

/// A laser and an accelerometer on one body for 200 s, noise of 2 um and 2 mm/s^2 a sample.
struct Body {
  VectorXd displacement, acceleration;
};

Body body(unsigned seed) {
  const Index n = static_cast<Index>(200 * rate_hz);
  support::SweptHarmonics motion;
  Body result{VectorXd(n), VectorXd(n)};
  for (Index i = 0; i < n; ++i) {
    const auto point = motion.at(static_cast<double>(i) / rate_hz);
    result.displacement(i) = point.x;
    result.acceleration(i) = point.a;
  }
  result.displacement += support::gaussian(n, seed, 2e-6);
  result.acceleration += support::gaussian(n, seed + 1000, 2e-3);
  return result;
}

std::vector<dsp::SensorProblem> problems_of(const Body& sensors, std::vector<double> declared_hz = {},
                                            dsp::ScaleReference scale = dsp::ScaleReference::displacement) {
  dsp::SensorRelation relation = dsp::relate_sensors(sensors.displacement, sensors.acceleration, rate_hz, {});
  REQUIRE(relation.reason.empty());
  relation.displacement = "laser";
  relation.acceleration = "accelerometer";
  relation.declared_hz = std::move(declared_hz);
  return dsp::sensor_problems(relation, scale);
}

VectorXd passed(const VectorXd& x, const std::function<std::complex<double>(double)>& response) {
  return dsp::ExtendedSpectrum(x, rate_hz).filtered(response);
}

VectorXd delayed(const VectorXd& x, double lag_s) {
  return passed(x, [&](double f) { return std::polar(1.0, -2.0 * std::numbers::pi * f * lag_s); });
}

}  // namespace

TEST_CASE("twenty clean pairs raise nothing", "[dsp][sensor_problems]") {
  for (unsigned seed = 1; seed <= 20; ++seed) CHECK(problems_of(body(seed)).empty());
}

TEST_CASE("each problem of a sensor is named alone, with its size and its channel", "[dsp][sensor_problems]") {
  const auto alone = [](const std::vector<dsp::SensorProblem>& problems, SensorProblemKind kind) {
    REQUIRE(problems.size() == 1);
    CHECK(problems[0].kind == kind);
    CHECK(problems[0].sentence.find('\n') == std::string::npos);
    return problems[0];
  };
  const Body clean = body(31);
  SECTION("2 % of gain") {
    Body sensors = clean;
    sensors.acceleration *= 1.02;
    const auto problem = alone(problems_of(sensors), SensorProblemKind::gain);
    CHECK(problem.channel == "accelerometer");
    CHECK(problem.sensitivity_factor == Approx(1.02).margin(4.0 * problem.std));
    CHECK(problem.std < 1e-3);
    CHECK_THAT(problem.sentence, Catch::Contains("% more than laser"));
    const auto other = alone(problems_of(sensors, {}, dsp::ScaleReference::accelerometer), SensorProblemKind::gain);
    CHECK(other.channel == "laser");
    CHECK(other.sensitivity_factor == Approx(1.0 / 1.02).margin(4.0 * problem.std));
  }
  SECTION("1.7 samples of lag, of either") {
    const double lag_s = 1.7 / rate_hz;
    Body sensors = clean;
    sensors.displacement = delayed(clean.displacement, lag_s);
    auto problem = alone(problems_of(sensors), SensorProblemKind::lag);
    CHECK(problem.channel == "laser");
    CHECK(problem.delay_s == Approx(lag_s).margin(4.0 * problem.std));
    sensors = clean;
    sensors.acceleration = delayed(clean.acceleration, lag_s);
    problem = alone(problems_of(sensors), SensorProblemKind::lag);
    CHECK(problem.channel == "accelerometer");
    CHECK(problem.delay_s == Approx(lag_s).margin(4.0 * problem.std));
  }
  SECTION("polarity") {
    Body sensors = clean;
    sensors.acceleration *= -1.0;
    CHECK_THAT(alone(problems_of(sensors), SensorProblemKind::polarity).sentence, Catch::Contains("opposite signs"));
  }
  SECTION("millimetres read as metres") {
    Body sensors = clean;
    sensors.displacement *= 1000.0;
    const auto problem = alone(problems_of(sensors), SensorProblemKind::unit);
    CHECK(problem.channel == "laser");
    CHECK(problem.sensitivity_factor == Approx(1000.0).epsilon(1e-3));
    CHECK_THAT(problem.sentence, Catch::Contains("millimetres read as metres"));
  }
  SECTION("micrometres read as metres, and metres read as micrometres") {
    Body sensors = clean;
    sensors.displacement *= 1e6;
    auto problem = alone(problems_of(sensors), SensorProblemKind::unit);
    CHECK(problem.channel == "laser");
    CHECK(problem.unit == "um");
    CHECK(problem.sensitivity_factor == Approx(1e6).epsilon(1e-3));
    sensors.displacement = 1e-6 * clean.displacement;
    problem = alone(problems_of(sensors), SensorProblemKind::unit);
    CHECK(problem.unit == "m");
    CHECK_THAT(problem.sentence, Catch::Contains("metres read as micrometres"));
  }
  SECTION("g read as m/s^2") {
    Body sensors = clean;
    sensors.acceleration /= 9.80665;
    const auto problem = alone(problems_of(sensors), SensorProblemKind::unit);
    CHECK(problem.channel == "accelerometer");
    CHECK(problem.sensitivity_factor == Approx(1.0 / 9.80665).epsilon(1e-3));
    CHECK_THAT(problem.sentence, Catch::Contains("g read as m/s^2"));
  }
  SECTION("another AC-coupling cut-off than the description's") {
    Body sensors = clean;
    sensors.acceleration = passed(clean.acceleration, [](double f) { return dsp::highpass_response({0.4}, f); });
    CHECK(problems_of(sensors, {0.4}).empty());
    const auto problem = alone(problems_of(sensors, {0.5}), SensorProblemKind::cutoff);
    REQUIRE(problem.highpass_hz.size() == 1);
    CHECK(problem.highpass_hz[0] == Approx(0.4).margin(0.005));
    CHECK(alone(problems_of(clean, {0.4}), SensorProblemKind::cutoff).highpass_hz.empty());
  }
}

}  // namespace test_sensors_sensor_problems
