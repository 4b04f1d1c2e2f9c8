#include "ident/validate/free_run.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "support/labelled_oscillator.hpp"
#include "support/oscillator.hpp"

namespace {

ident::Model model_of(const std::string& target, const std::vector<std::pair<std::string, double>>& terms) {
  ident::Model model;
  model.target = target;
  for (const auto& [name, mean] : terms) {
    ident::ModelTerm term;
    term.name = name;
    term.mean = mean;
    model.terms.push_back(term);
  }
  return model;
}

ident::Course whole(const dsp::Motion& motion, Eigen::Index first = 0) {
  return {&motion,
          {{first, motion.num_samples()}},
          std::vector<unsigned char>(static_cast<std::size_t>(motion.num_samples()), 1)};
}

ident::Model true_model(const sim::Experiment& experiment) {
  std::vector<std::pair<std::string, double>> terms;
  for (const sim::TrueTerm& term : experiment.truth)
    if (term.row == 2) terms.emplace_back(term.name, term.value);
  return model_of("a", terms);
}

}  // namespace

TEST_CASE("the true equation of a Duffing oscillator runs along its record", "[ident][free_run]") {
  const auto experiment = sim::make_experiment(sim::Duffing{});
  const dsp::Motion motion = support::motion_of(experiment, 30.0, 100.0);
  const ident::FreeRun run = ident::free_run(true_model(experiment), {whole(motion, 200)});
  // The force is interpolated; its cubic Hermite pieces on the eightfold grid are off by about 1e-8 of its size.
  CHECK(run.reason.empty());
  CHECK(run.nmse < 1e-10);
  CHECK(run.num_ranges == 1);
}

TEST_CASE("a Coulomb oscillator sticks in its free run where it sticks in truth", "[ident][free_run]") {
  const auto experiment = sim::make_experiment(sim::Coulomb{.c_f = 60.0, .ratio = 0.3});
  const dsp::Motion motion = support::motion_of(experiment, 8.0, 400.0);
  REQUIRE((motion.at("v").array() == 0.0).count() > 100);
  const ident::FreeRun run = ident::free_run(true_model(experiment), {whole(motion, 100)});
  CHECK(run.reason.empty());
  CHECK(run.sticks);
  CHECK(run.nmse < 1e-8);
}

TEST_CASE("friction against the ground holds the payload, not the relative motion", "[ident][free_run]") {
  const sim::Coulomb p{.c = 1.0, .k = 400.0, .c_f = 60.0, .force_n = 100.0, .ratio = 0.31};
  const dsp::Motion motion = support::friction_on_the_ground(p, 20.0, 250.0);
  REQUIRE((motion.at("dy").array() == 0.0).count() > 500);
  const auto absolute = model_of("ddy", {{"x", -p.k}, {"dy", -p.c}, {"sgn(dy)", -p.c_f}});
  const auto relative = model_of("a", {{"x", -p.k}, {"dy", -p.c}, {"sgn(dy)", -p.c_f}, {"ddr", -1.0}});
  for (const ident::Model& model : {absolute, relative}) {
    const ident::FreeRun run = ident::free_run(model, {whole(motion, 50)});
    CAPTURE(model.target, run.reason);
    CHECK(run.sticks);
    CHECK(run.nmse < 1e-7);
  }
}

TEST_CASE("a subtracted zero of x is taken back where y is rebuilt", "[ident][free_run]") {
  const sim::Coulomb p{.c = 1.0, .k = 400.0, .c_f = 5.0, .force_n = 100.0, .ratio = 0.31};
  dsp::Motion motion = support::friction_on_the_ground(p, 20.0, 250.0);
  for (dsp::Signal& signal : motion.signals)
    if (signal.name == "x") signal.values.array() -= 0.01;
  const auto model = model_of("ddy", {{"y", -p.k}, {"r", p.k}, {"dy", -p.c}, {"sgn(dy)", -p.c_f}});
  CHECK(ident::free_run(model, {whole(motion)}).nmse < 1e-7);
}

TEST_CASE("a free run that diverges says when, and gives no figure", "[ident][free_run]") {
  const auto experiment = sim::make_experiment(sim::Duffing{});
  const dsp::Motion motion = support::motion_of(experiment, 30.0, 100.0);
  const ident::FreeRun run = ident::free_run(model_of("a", {{"x", 4.0}, {"f", 1.0}}), {whole(motion)});
  CHECK(std::isnan(run.nmse));
  CHECK(run.diverged_after_s > 0.0);
  CHECK_THAT(run.reason, Catch::Contains("diverged"));
}

TEST_CASE("a hysteretic force that was recorded acts on the free run as measured", "[ident][free_run]") {
  const auto experiment = sim::make_experiment(sim::BoucWen{});
  const sim::Simulation run =
      sim::simulate(experiment.system, experiment.initial, {.duration_s = 30.0, .sample_rate_hz = 100.0});
  dsp::Motion motion = support::motion_of(experiment, 30.0, 100.0);
  motion.signals.push_back({"z", "N", run.states.col(2)});
  std::vector<std::pair<std::string, double>> terms;
  for (const sim::TrueTerm& term : experiment.truth)
    if (term.target == "a") terms.emplace_back(term.name, term.value);
  // z has kinks where v turns, between samples.
  CHECK(ident::free_run(model_of("a", terms), {whole(motion)}).nmse_centred < 1e-4);
  for (auto& [name, value] : terms) value *= 1.2;
  CHECK(ident::free_run(model_of("a", terms), {whole(motion)}).nmse_centred > 1e-2);
}

TEST_CASE("an equation without inputs can be set to the measured state again every so many periods",
          "[ident][free_run]") {
  // 1 % of the stiffness is half a per cent of the frequency: a hundred periods on it has turned half round.
  dsp::Motion motion{.sample_rate_hz = 100.0};
  const Eigen::VectorXd t = Eigen::VectorXd::LinSpaced(10'000, 0.0, 99.99);
  const double omega = 2.0 * std::numbers::pi;
  motion.signals = {
      {"t", "s", t}, {"x", "m", 3.0 + (omega * t.array()).cos()}, {"v", "m/s", -omega * (omega * t.array()).sin()}};
  const auto model = model_of("a", {{"x", -1.01 * omega * omega}, {"1", 3.0 * 1.01 * omega * omega}});
  const ident::FreeRun again = ident::free_run(model, {whole(motion)}, {.periods_alone = 10.0});
  const ident::FreeRun whole_run = ident::free_run(model, {whole(motion)});
  CHECK(again.alone);
  CHECK(whole_run.nmse_centred > 1.0);
  // It has turned by 0.3 at the end of each: of an angle that grows, a third of its square on average.
  CHECK(again.nmse_centred == Approx(std::pow(0.005 * 2.0 * std::numbers::pi * 10.0, 2) / 3.0).epsilon(0.05));
  // About the mean: x is never far from 3.
  CHECK(again.mean_square == Approx(0.5).epsilon(0.01));
  CHECK(again.nmse < 0.1 * again.nmse_centred);
}

TEST_CASE("in chaos a run is known for a few periods, and begins again after them", "[ident][free_run]") {
  // Ueda's oscillator, x'' + x' / 20 + x^3 = 7.5 cos t: two courses that are set back to 1e-8 apart once a period, over
  // 20000 periods of another integrator, part as exp(0.104 t), tenfold in 22 s or 3.5 periods; at times and places
  // faster or slower by a factor of three.
  support::Oscillator p{.c = 0.05, .k3 = 1.0, .force_gain = 7.5, .x0 = 2.5, .amplitude = 3.0, .omega = 1.0};
  p.drive.tones = {{1.0, 1.0, 0.5 * std::numbers::pi, 0.0}};
  const dsp::Motion motion = support::motion_of(p, 400.0, 50.0);
  const auto off = model_of("a", {{"v", -0.05}, {"x^3", -1.001}, {"f", 7.5}});
  CHECK(ident::free_run(off, {whole(motion)}).nmse_centred > 0.3);
  const auto [again, courses] = ident::restarted_run(off, {whole(motion)}, {});
  CHECK(again.nmse_centred == ident::free_run(off, courses).nmse_centred);
  const double periods = 400.0 / (2.0 * std::numbers::pi) / (again.num_restarts + 1);
  CHECK(periods > 1.2);
  CHECK(periods < 11.0);
  CHECK(again.nmse_centred < 0.01);
  // Begun again as often, an equation that is wrong is no better for it.
  CHECK(ident::free_run(model_of("a", {{"v", -0.05}, {"x", -4.0}, {"f", 7.5}}), courses).nmse_centred > 0.1);
}

TEST_CASE("errors of a run that dies out, or of one without inputs, never grow tenfold", "[ident][free_run]") {
  const auto experiment = sim::make_experiment(sim::Duffing{});
  const dsp::Motion motion = support::motion_of(experiment, 60.0, 100.0);
  const std::vector<ident::Course> courses{whole(motion, 200)};
  // Two runs of a linear equation differ by its free decay, however wrong it is.
  const ident::Model linear = model_of("a", {{"x", -25.0}, {"v", -0.5}, {"f", 1.0}}),
                     alone = model_of("a", {{"x", -25.0}, {"v", -0.5}});
  for (const ident::Model& model : {linear, alone}) {
    const auto [run, with_restarts] = ident::restarted_run(model, courses, {});
    CHECK(run.nmse_centred > ident::follows);
    CHECK(run.nmse_centred == ident::free_run(model, courses).nmse_centred);
    CHECK(with_restarts.front().restarts.empty());
  }
}

TEST_CASE("what cannot run free says why", "[ident][free_run]") {
  const auto experiment = sim::make_experiment(sim::Duffing{});
  const dsp::Motion motion = support::motion_of(experiment, 30.0, 100.0);
  const auto reason = [&](const ident::Model& model, const ident::Course& course) {
    return ident::free_run(model, {course}).reason;
  };
  CHECK_THAT(reason(model_of("v", {{"x", 1.0}}), whole(motion)), Catch::Contains("not an equation of motion"));
  CHECK_THAT(reason(model_of("a", {}), whole(motion)), Catch::Contains("no term"));
  CHECK_THAT(reason(model_of("a", {{"x", -1.0}, {"a", 0.5}}), whole(motion)), Catch::Contains("its own left side"));
  std::vector<std::pair<std::string, double>> steps{{"x", -1.0}};
  for (int k = 0; k < 13; ++k) steps.emplace_back("sgn(x-" + std::to_string(k) + ")", 0.1);
  CHECK_THAT(reason(model_of("a", steps), whole(motion)), Catch::Contains("13 switches are more than the 12"));
  dsp::Motion still = motion;
  for (dsp::Signal& signal : still.signals)
    if (signal.name == "v") signal.values.setZero();
  CHECK_THAT(reason(true_model(experiment), whole(still)), Catch::Contains("x does not move"));
  ident::Course unscored = whole(motion);
  unscored.scored.assign(unscored.scored.size(), 0);
  CHECK_THAT(reason(true_model(experiment), unscored), Catch::Contains("x is zero over the test rows"));
  ident::Course split = whole(motion);
  split.ranges = {{0, 100}, {300, 400}};  // a period is 126 samples
  CHECK_THAT(reason(true_model(experiment), split), Catch::Contains("1 period long"));
  split.ranges = {{0, 200}, {300, 500}};  // one and a half of them say what they can
  CHECK(ident::free_run(true_model(experiment), {split}).nmse < 1e-10);
}

TEST_CASE("a free run begins again after each gap", "[ident][free_run]") {
  const auto experiment = sim::make_experiment(sim::Duffing{});
  const dsp::Motion motion = support::motion_of(experiment, 60.0, 100.0);
  ident::Course course = whole(motion);
  course.ranges = {{0, 2000}, {2500, 2600}, {3000, 5000}};
  const ident::FreeRun run = ident::free_run(true_model(experiment), {course});
  CHECK(run.num_ranges == 2);
  CHECK(run.nmse < 1e-10);
}

TEST_CASE("on a limit cycle a damped equation dies and the right one goes on", "[ident][free_run]") {
  const support::Oscillator p{
      .k = 36.0, .c = -0.9, .xxv = 3.6e4, .x0 = 0.01, .amplitude = 0.01, .omega = 6.0};  // 10 mm
  const dsp::Motion motion = support::motion_of(p, 63.0, 200.0);
  const auto error = [&](const ident::Model& model) {
    const ident::FreeRun run = ident::free_run(model, {whole(motion)}, {.periods_alone = 10.0});
    CHECK(run.alone);
    return run.nmse_centred;
  };
  CHECK(error(model_of("a", {{"x", -36.0}, {"v", 0.9}, {"x^2*v", -3.6e4}})) < 1e-6);
  // After t seconds exp(-0.15 t) of the amplitude is left, or as much more: over ten periods of 1.05 s each
  // mean((1 - exp(-0.15 t))^2) is 0.30.
  CHECK(error(model_of("a", {{"x", -36.0}, {"v", -0.3}})) > 0.2);
  CHECK(error(model_of("a", {{"x", -36.0}, {"v", 0.3}})) > 0.2);
}
