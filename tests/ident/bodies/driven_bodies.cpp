#include "ident/bodies/driven_bodies.hpp"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>

#include "dsp/values/fault.hpp"
#include "ident/bodies/true_model.hpp"
#include "ident/equation/response_draws.hpp"
#include "sim/ode/steady_response.hpp"
#include "sim/simulate.hpp"

namespace test_bodies_driven {
namespace {

constexpr double two_pi = 6.283185307179586;

/// amplitude cos(w t).
sim::Drive sine(double amplitude, double w) {
  return {.value = [=](double t) { return amplitude * std::cos(w * t); },
          .rate = [=](double t) { return -amplitude * w * std::sin(w * t); },
          .acceleration = [=](double t) { return -amplitude * w * w * std::cos(w * t); }};
}

/// Half of what a signal spans in the last of so many periods that a simulation went through.
double last_amplitude(const Eigen::VectorXd& x, int num_periods) {
  const Eigen::VectorXd last = x.tail(x.size() / num_periods);
  return 0.5 * (last.maxCoeff() - last.minCoeff());
}

}  // namespace

TEST_CASE("the frequency response of linear bodies is that of their matrices", "[ident][bodies][driven_bodies]") {
  const auto frame = GENERATE(ident::Frame::ground, ident::Frame::absolute, ident::Frame::base);
  const int body = GENERATE(1, 2);
  const double k1 = 90.0, c1 = 0.6, k2 = 60.0, c2 = 0.4, ratio = 1.5;  // per mass 1; mass 1 over mass 2
  const bool is_base = frame != ident::Frame::ground, absolute = frame == ident::Frame::absolute;
  ident::BodiesModel model;
  model.layout = {.num_bodies = 2,
                  .frame = frame,
                  .inputs = absolute  ? std::vector<std::string>{"r", "dr"}
                            : is_base ? std::vector<std::string>{"ddr"}
                                      : std::vector<std::string>{"f", "f2"}};
  model.terms = {{1, absolute ? "(x1 - r)" : "x1"},
                 {1, absolute ? "(v1 - dr)" : "v1"},
                 {1, "(x2 - x1)"},
                 {1, "(v2 - v1)"},
                 {2, "(x2 - x1)"},
                 {2, "(v2 - v1)"}};
  std::vector<double> mean{-k1, -c1, k2, c2, -ratio * k2, -ratio * c2};
  if (frame == ident::Frame::base)
    model.terms.insert(model.terms.end(), {{1, "ddr"}, {2, "ddr"}}), mean.insert(mean.end(), {-1.0, -1.0});
  if (frame == ident::Frame::ground) model.terms.push_back({2, "f2"}), mean.push_back(0.8);
  model.mean = Eigen::VectorXd::Map(mean.data(), std::ssize(mean));
  const double amplitude = 0.004;
  const auto found = sim::steady_response(driven_bodies(model, is_base ? "r" : "f2", body),
                                          {.from_hz = 0.7, .to_hz = 3.1, .step_hz = 0.3, .amplitude_m = amplitude});
  CHECK(found.num_unsettled == 0);
  REQUIRE(found.response.up.size() == 9);
  for (const sim::ResponsePoint& point : found.response.up) {
    const std::complex<double> s(0.0, two_pi * point.frequency_hz);
    const auto below = k1 + c1 * s, between = k2 + c2 * s;
    Eigen::Matrix2cd dynamic;
    dynamic << s * s + below + between, -between, -ratio * between, s * s + ratio * between;
    // Absolute displacements for a unit of the drive.
    const Eigen::Vector2cd x =
        dynamic.inverse() * (is_base ? Eigen::Vector2cd(below, 0.0) : Eigen::Vector2cd(0.0, 0.8));
    const std::complex<double> y = amplitude * x(body - 1), relative = is_base ? y - amplitude : y;
    CAPTURE(point.frequency_hz);
    CHECK(point.x_m == Approx(std::abs(relative)).epsilon(3e-6));  // the peak is that of cubics over 9 degrees
    CHECK(point.y_m == Approx(std::abs(y)).epsilon(3e-6));
    CHECK(std::abs(std::remainder(point.phase_rad - std::arg(relative), two_pi)) < 1e-6);
    CHECK(point.stuck_fraction == 0.0);
  }
}

TEST_CASE("bodies with friction and a cubic spring settle where the chain does", "[ident][bodies][driven_bodies]") {
  const bool base_driven = GENERATE(false, true);
  const sim::Chain chain{.links = {{.friction = 0.3}, {.cubic = 1e4, .friction = 0.35}}, .base_driven = base_driven};
  const double amplitude = base_driven ? 0.01 : 1.2;
  for (const double hz : {0.8, 1.6}) {
    const sim::Drive drive = sine(amplitude, two_pi * hz);
    const sim::Experiment experiment = sim::make_experiment(chain, drive);
    constexpr int num_periods = 80;
    const sim::Simulation run = sim::simulate(experiment.system, experiment.initial,
                                              {.duration_s = num_periods / hz, .sample_rate_hz = 400.0 * hz});
    REQUIRE(run.status == sim::SimulationStatus::finished);
    const Eigen::Index last = 400;
    for (const int body : {1, 2}) {
      const auto response =
          sim::steady_response(driven_bodies(support::true_model(experiment, chain), base_driven ? "r" : "f", body),
                               {.from_hz = hz, .to_hz = hz + 1e-3, .step_hz = 1e-3, .amplitude_m = amplitude});
      REQUIRE(response.num_unsettled == 0);
      const sim::ResponsePoint& point = response.response.up.front();
      CAPTURE(base_driven, hz, body, point.stuck_fraction);
      const Eigen::VectorXd y = run.states.col(body - 1), r = run.time_s.unaryExpr(drive.value);
      // 400 samples a period miss a peak by at most (pi / 400)^2 / 2; what is left after 80 periods is far less.
      CHECK(point.y_m == Approx(last_amplitude(y.tail(80 * last), num_periods)).epsilon(1e-4));
      if (base_driven) CHECK(point.x_m == Approx(last_amplitude((y - r).tail(80 * last), num_periods)).epsilon(1e-4));
      CHECK((point.stuck_fraction > 0.0) == (hz < 1.0 || !base_driven));
      CHECK(!point.locked);
    }
  }
}

TEST_CASE("one body as bodies answers as it does alone: locked, loose, and over its jumps",
          "[ident][bodies][driven_bodies]") {
  ident::IdentifiedEquation alone{
      .target = "a", .terms = {"x", "x^3", "v", "sgn(v)", "ddr"}, .base_measured = true, .largest_x = 0.01};
  alone.mean = (Eigen::VectorXd(5) << -50.0, -9.5e4, -1.33, -0.05, -1.0).finished();
  ident::BodiesModel model;
  model.layout = {.num_bodies = 1, .frame = ident::Frame::base, .inputs = {"ddr"}};
  for (const std::string& term : alone.terms) model.terms.push_back({1, term});
  model.mean = alone.mean;
  const sim::FrequencyResponseOptions sweep{.from_hz = 0.4, .to_hz = 2.6, .step_hz = 0.1, .amplitude_m = 4.5e-3};
  const auto a = sim::steady_response(ident::equation_oscillator(alone, alone.mean).oscillator, sweep);
  const auto b = sim::steady_response(driven_bodies(model, "r", 1), sweep);
  REQUIRE(std::isfinite(a.located.unlock_rising_hz));
  // Less than a millionth of what a free body would do counts as none.
  CHECK(b.located.unlock_rising_hz == Approx(a.located.unlock_rising_hz).margin(1e-3));
  REQUIRE(std::isfinite(a.located.jump_down_rising_hz));
  CHECK(b.located.jump_down_rising_hz == Approx(a.located.jump_down_rising_hz).margin(2e-4));
  for (const auto& [of_a, of_b] : {std::pair{&a.response.up, &b.response.up}, {&a.response.down, &b.response.down}})
    for (std::size_t k = 0; k < of_a->size(); ++k) {
      CAPTURE((*of_a)[k].frequency_hz);
      CHECK((*of_b)[k].locked == (*of_a)[k].locked);
      CHECK((*of_b)[k].x_m == Approx((*of_a)[k].x_m).epsilon(1e-5).margin(1e-12));
      CHECK((*of_b)[k].y_m == Approx((*of_a)[k].y_m).epsilon(1e-5));
      CHECK((*of_b)[k].stuck_fraction == Approx((*of_a)[k].stuck_fraction).margin(1e-4));
    }
}

TEST_CASE("a hardly damped body settles by Newton's method, not by waiting", "[ident][bodies][driven_bodies]") {
  constexpr double square = 80.0, damping = 0.002;  // of 1e-4 of critical: 3,000 periods bring it down by a tenth
  ident::BodiesModel model;
  model.layout = {.num_bodies = 1, .inputs = {"f"}};
  model.terms = {{1, "x"}, {1, "v"}, {1, "f"}};
  model.mean = Eigen::Vector3d(-square, -damping, 1.0);
  const auto found = sim::steady_response(driven_bodies(model, "f", 1),
                                          {.from_hz = 1.2, .to_hz = 1.8, .step_hz = 0.05, .amplitude_m = 2.0});
  CHECK(found.num_unsettled == 0);
  for (const auto* points : {&found.response.up, &found.response.down})
    for (const sim::ResponsePoint& point : *points) {
      const double w = two_pi * point.frequency_hz;
      CHECK(point.x_m == Approx(2.0 / std::abs(std::complex<double>(square - w * w, damping * w))).epsilon(1e-5));
    }
}

TEST_CASE("bodies that friction holds to each other and to the ground stay where they are",
          "[ident][bodies][driven_bodies][friction]") {
  const bool base_driven = GENERATE(false, true);
  const sim::Chain chain{.links = {{.friction = 0.2}, {.friction = 0.2}}, .base_driven = base_driven};
  const double amplitude = base_driven ? 1e-4 : 0.19, hz = 1.0;
  const sim::Experiment experiment = sim::make_experiment(chain, sine(amplitude, two_pi * hz));
  const sim::Simulation run =
      sim::simulate(experiment.system, experiment.initial, {.duration_s = 2.0, .sample_rate_hz = 50.0});
  REQUIRE(run.status == sim::SimulationStatus::finished);
  const Eigen::VectorXd base = base_driven ? run.time_s.unaryExpr(sine(amplitude, two_pi * hz).value).eval()
                                           : Eigen::VectorXd::Zero(run.time_s.size()).eval();
  for (const Eigen::Index body : {0, 1}) CHECK((run.states.col(body) - base).cwiseAbs().maxCoeff() < 1e-9);
  const auto response =
      sim::steady_response(driven_bodies(support::true_model(experiment, chain), base_driven ? "r" : "f", 2),
                           {.from_hz = hz, .to_hz = 1.1 * hz, .step_hz = 0.1 * hz, .amplitude_m = amplitude});
  CHECK(response.num_unsettled == 0);
  for (const sim::ResponsePoint& point : response.response.up) {
    CHECK(point.locked);
    CHECK(point.stuck_fraction == Approx(1.0));
  }
}

TEST_CASE("a force with a memory answers a sine as its simulation does", "[ident][bodies][driven_bodies]") {
  const sim::Valanis1 valanis;
  ident::BodiesModel model;
  model.layout = {.num_bodies = 1, .inputs = {"f"}, .inner = ident::Inner::hysteresis};
  model.terms = {{1, "x"}, {1, "f"}, ident::inner_force(), {2, "v"}, {2, "x*abs(v)"}, {2, "z*abs(v)"}};
  model.mean = (Eigen::VectorXd(6) << -valanis.k, 1.0, -1.0, valanis.e1, valanis.alpha, -valanis.e2).finished();
  constexpr double hz = 1.3, amplitude = 2.0;
  constexpr int num_periods = 300;
  sim::Valanis1 driven = valanis;
  driven.drive = sine(amplitude, two_pi * hz).value;
  const sim::Experiment experiment = sim::make_experiment(driven);
  const sim::Simulation run = sim::simulate(experiment.system, experiment.initial,
                                            {.duration_s = num_periods / hz, .sample_rate_hz = 400.0 * hz});
  const auto response = sim::steady_response(
      driven_bodies(model, "f", 1), {.from_hz = hz, .to_hz = hz + 1e-3, .step_hz = 1e-3, .amplitude_m = amplitude});
  REQUIRE(response.num_unsettled == 0);
  CHECK(response.response.up.front().x_m == Approx(last_amplitude(run.states.col(0), num_periods)).epsilon(1e-4));
}

TEST_CASE("draws of bodies spread amplitudes as their coefficients do", "[ident][bodies][driven_bodies]") {
  ident::BodiesModel model;
  model.layout = {.num_bodies = 1, .inputs = {"f"}};
  model.terms = {{1, "x"}, {1, "v"}, {1, "f"}};
  model.mean = Eigen::Vector3d(-80.0, -1.0, 1.0);
  model.covariance = Eigen::Vector3d(0.0, 0.0, 0.01 * 0.01).asDiagonal();
  constexpr int num_draws = 60;
  const auto draws = ident::response_draws({.from_hz = 1.0, .to_hz = 2.0, .step_hz = 0.5, .amplitude_m = 3.0},
                                           {.num_draws = num_draws, .num_threads = 2}, [&](std::size_t k) {
                                             ident::BodiesModel drawn = model;
                                             drawn.mean = ident::drawn_coefficients(model.mean, model.covariance, 1, k);
                                             return ident::DrawnSystem{.driven = driven_bodies(drawn, "f", 1)};
                                           });
  const double x = 3.0 / std::abs(std::complex<double>(80.0 - two_pi * two_pi, two_pi));
  // One standard deviation of a standard deviation of so many draws is a share of 1 / sqrt(2 num_draws).
  CHECK(draws.up.x_std_m.front() == Approx(0.01 * x).epsilon(3.0 / std::sqrt(2.0 * num_draws)));
}

TEST_CASE("what has no steady response to a sine is refused", "[ident][bodies][driven_bodies]") {
  ident::BodiesModel model;
  model.layout = {.num_bodies = 1, .inputs = {"f", "f2"}};
  model.terms = {{1, "x"}, {1, "f"}};
  model.mean = Eigen::Vector2d(-80.0, 1.0);
  CHECK(ident::drives_of(model.layout) == std::vector<std::string>{"f", "f2"});
  CHECK_THROWS_AS(driven_bodies(model, "f2", 1), dsp::Fault);  // nothing looks at it
  model.terms.push_back({1, "x*cos(3*t)"});
  model.mean = Eigen::Vector3d(-80.0, 1.0, 1.0);
  CHECK_THROWS_AS(driven_bodies(model, "f", 1), dsp::Fault);
  model.layout.imposed = true;
  CHECK_THROWS_AS(driven_bodies(model, "f", 1), dsp::Fault);
  model.layout = {.num_bodies = 2, .frame = ident::Frame::absolute, .inputs = {"f", "r", "dr"}};
  CHECK(ident::drives_of(model.layout) == std::vector<std::string>{"f", "r"});
}

}  // namespace test_bodies_driven
