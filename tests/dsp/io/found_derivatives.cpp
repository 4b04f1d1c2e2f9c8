#include "dsp/io/found_derivatives.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "dsp/sensors/motion.hpp"
#include "support/fault.hpp"
#include "support/signals.hpp"

namespace test_sensors_found_derivatives {

namespace {

constexpr double rate_hz = 200.0;

/// Columns acceleration, force, displacement (mm), velocity of a sweep, each with noise of a thousandth.
Eigen::MatrixXd shuffled(Eigen::Index n) {
  const support::SweptHarmonics motion;
  std::mt19937 random(11);
  std::normal_distribution<double> noise(0.0, 1e-3);
  Eigen::MatrixXd samples(n, 4);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto p = motion.at(static_cast<double>(i) / rate_hz);
    samples.row(i) << p.a, p.a + 40.0 * p.x + 2.0 * p.v, 1e3 * p.x, p.v;
  }
  for (Eigen::Index c = 0; c < samples.cols(); ++c) {
    const double size = samples.col(c).cwiseAbs().maxCoeff();
    samples.col(c) = samples.col(c).unaryExpr([&](double value) { return value + size * noise(random); });
  }
  return samples;
}

}  // namespace

TEST_CASE("columns are told to be derivatives of one another, in whatever units of ten", "[dsp][found_derivatives]") {
  const auto found = dsp::find_derivatives(shuffled(12'000), rate_hz);
  REQUIRE(found.size() == 2);
  CHECK((found[0].of == 3 && found[0].is == 0));  // the acceleration, of the velocity
  CHECK(found[0].factor == Approx(1.0).epsilon(0.01));
  CHECK((found[1].of == 2 && found[1].is == 3));  // the velocity, of the displacement in mm
  CHECK(found[1].factor == Approx(1e-3).epsilon(0.01));
}

TEST_CASE("a force in phase with the velocity and noise are no derivatives", "[dsp][found_derivatives]") {
  Eigen::MatrixXd samples(4000, 3);
  std::mt19937 random(5);
  std::normal_distribution<double> white;
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    const double phase = 0.05 * static_cast<double>(i);
    samples.row(i) << std::sin(phase), 23.0 * std::cos(phase), white(random);
  }
  CHECK(dsp::find_derivatives(samples, rate_hz).empty());
  CHECK(dsp::find_derivatives(Eigen::MatrixXd::Constant(100, 2, 3.0), rate_hz).empty());
  CHECK(dsp::find_derivatives(Eigen::MatrixXd::Constant(4099, 2, 0.1), rate_hz).empty());
}

TEST_CASE("a pair is judged by all rises over the span where they agree best", "[dsp][found_derivatives]") {
  std::mt19937 random(3);
  std::normal_distribution<double> white;
  int num_found = 0;
  for (const Eigen::Index n : {3, 4, 5, 8, 100, 1023, 1024, 1025, 2048 + 1024 + 7}) {
    Eigen::MatrixXd samples(n, 2);
    for (Eigen::Index i = 0; i < n; ++i) {
      const double phase = 0.04 * static_cast<double>(i);
      samples.row(i) << std::sin(phase), 0.04 * rate_hz * std::cos(phase);
    }
    samples.bottomRows(1) *= -1.0;  // the last rise tells, too
    samples += 2e-3 * Eigen::MatrixXd::NullaryExpr(n, 2, [&] { return white(random); });
    const Eigen::VectorXd x = samples.col(0), v = samples.col(1);
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(n);
    for (Eigen::Index i = 1; i < n; ++i) sum(i) = sum(i - 1) + 0.5 * (v(i - 1) + v(i) - 2.0 * v.mean()) / rate_hz;
    double correlation = 0.0, factor = 0.0;
    for (Eigen::Index span = 1; span <= std::min<Eigen::Index>(1024, n / 4); span *= 2) {
      Eigen::ArrayXd of_x = (x.tail(n - span) - x.head(n - span)).array(),
                     of_v = (sum.tail(n - span) - sum.head(n - span)).array();
      of_x -= of_x.mean(), of_v -= of_v.mean();
      const double one = (of_x * of_v).sum() / std::sqrt(of_x.square().sum() * of_v.square().sum());
      if (one > correlation) correlation = one, factor = std::sqrt(of_v.square().sum() / of_x.square().sum());
    }
    CAPTURE(n, correlation, factor);
    const auto found = dsp::find_derivatives(samples, rate_hz);
    const auto forward = std::find_if(found.begin(), found.end(), [](const auto& one) { return one.is == 1; });
    const bool expected = correlation > 0.99 && std::abs(factor - 1.0) < 0.02;
    CHECK((forward != found.end()) == expected);
    if (forward == found.end()) continue;
    ++num_found;
    CHECK(forward->factor == Approx(factor).epsilon(1e-12));
  }
  CHECK(num_found >= 3);
}

TEST_CASE("offset and drift hide no derivative, and a gap makes a column nobody's", "[dsp][found_derivatives]") {
  Eigen::MatrixXd samples = shuffled(12'000);
  samples.col(2).array() += Eigen::ArrayXd::LinSpaced(samples.rows(), 1e7, 2e7);
  samples.col(3).array() -= 50.0;
  CHECK(dsp::find_derivatives(samples, rate_hz).size() == 2);
  for (const double gap : {std::nan(""), -HUGE_VAL}) {
    samples(7'000, 3) = gap;
    CHECK(dsp::find_derivatives(samples, rate_hz).empty());
  }
  CHECK(dsp::find_derivatives(Eigen::MatrixXd(0, 1), rate_hz).empty());
}

TEST_CASE("the question for roles proposes those that the numbers give away", "[dsp][found_derivatives]") {
  dsp::Recording recording{.name = "a.csv", .sample_rate_hz = rate_hz};
  for (const char* name : {"ch1", "ch2", "ch3", "ch4"}) recording.channels.push_back({.name = name});
  recording.samples = shuffled(12'000);
  support::check_fault(
      [&] {
        (void)dsp::relative_motion(recording, {.band = {60.0, 80.0}});
      },
      dsp::FaultKind::input, "motion.none", {"found ch1 (other, -1.27"},
      {"name = \"ch3\"\nrole = \"x\"", "name = \"ch4\"\nrole = \"v\"  # derivative of ch3",
       "name = \"ch1\"\nrole = \"a\"  # derivative of ch4", "name = \"ch2\"\nrole = \"other\"\n"});
}

}  // namespace test_sensors_found_derivatives
