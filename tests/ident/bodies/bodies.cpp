#include "ident/bodies/bodies.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "ident/bodies/tally.hpp"
#include "sim/chain.hpp"
#include "sim/noise.hpp"
#include "sim/simulate.hpp"

using support::BodiesTally;

namespace test_bodies {

namespace {

constexpr double rate_hz = 200.0;

struct Draw {
  ident::BodiesRecord record;
  std::map<std::string, double> truth;  ///< by "body term"
};

/// A minute of a chain from rest, each displacement with white noise of a fraction of its standard deviation.
Draw draw_of(const sim::Chain& chain, double noise, std::uint64_t seed, double duration_s = 60.0) {
  const sim::Drive drive = sim::random_drive(seed, 0.3, 4.0, chain.base_driven ? 0.03 : 10.0);
  const sim::Experiment experiment = sim::make_experiment(chain, drive);
  const sim::Simulation run =
      sim::simulate(experiment.system, experiment.initial, {.duration_s = duration_s, .sample_rate_hz = rate_hz});
  REQUIRE(run.status == sim::SimulationStatus::finished);
  const auto n = static_cast<Eigen::Index>(chain.masses.size());
  dsp::Recording recording{.name = "chain", .sample_rate_hz = rate_hz};
  recording.samples.resize(run.time_s.size(), n + 1);
  for (Eigen::Index body = 0; body < n; ++body) {
    recording.samples.col(body) =
        support::noisy(run.states.col(body), noise, seed, 1000 + static_cast<std::uint64_t>(body));
    dsp::Channel channel{.name = fmt::format("x{}", body + 1), .role = dsp::Role::x, .unit = "m"};
    channel.body = static_cast<int>(body) + 1, channel.role_is_assumed = true;
    recording.channels.push_back(channel);
  }
  recording.samples.col(n) = run.time_s.unaryExpr(drive.value);
  recording.channels.push_back(chain.base_driven ? dsp::Channel{.name = "r", .role = dsp::Role::r, .unit = "m"}
                                                 : dsp::Channel{.name = "f", .role = dsp::Role::f, .unit = "N"});
  Draw draw{ident::bodies_record(recording), {}};
  for (const sim::TrueTerm& term : experiment.truth)
    if (term.target.front() == 'a') draw.truth[support::key(term.row / 2, term.name)] += term.value;
  return draw;
}

BodiesTally tally(const sim::Chain& chain, double noise, std::uint64_t first_seed, int draws) {
  BodiesTally result;
  for (int i = 0; i < draws; ++i) {
    const Draw draw = draw_of(chain, noise, first_seed + static_cast<std::uint64_t>(i));
    result.add(ident::identify_bodies(draw.record, {.num_threads = 2}), draw.truth);
  }
  return result;
}

const sim::Chain two{};
const sim::Chain three{.masses = {1.0, 0.7, 1.3},
                       .links = {{.stiffness = 150.0}, {.cubic = 1e4}, {.stiffness = 80.0, .cubic = 8e3}},
                       .base_driven = true};

// Not the seeds that anything was tried on.
constexpr std::uint64_t seed = 940000;

}  // namespace

TEST_CASE("two masses with a cubic coupling are found from their displacements", "[ident][bodies]") {
  const auto [noise, allowed] = GENERATE(std::pair{0.01, 0.01}, std::pair{0.05, 0.04});
  const BodiesTally of = tally(two, noise, seed, 3);
  CAPTURE(noise, of.exact, of.covered, of.of);
  CHECK(of.exact >= 2);  // of ten a false term is met once: two of three in 97 of 100 draws
  CHECK(of.median_worst() < allowed);
}

TEST_CASE("three masses driven by their base are found, and that their displacements are absolute", "[ident][bodies]") {
  const Draw draw = draw_of(three, 0.01, seed + 100);
  CHECK_FALSE(draw.record.frame.has_value());
  const ident::BodiesResult result = ident::identify_bodies(draw.record, {.num_threads = 2});
  CHECK(result.frame_was_open);
  CHECK(result.model.layout.frame == ident::Frame::absolute);
  BodiesTally of;
  of.add(result, draw.truth);
  CHECK(of.exact == 1);
  CHECK(result.verdict == ident::Verdict::describes);
  REQUIRE(result.run_nmse.size() == 3);
  // Noise of 1 % is 1e-4 of the power; a free run without an error of its own adds nothing to it.
  CHECK((result.run_nmse - result.run_noise).maxCoeff() < 1e-3);
  REQUIRE(result.couplings.size() == 2);
  CHECK(result.couplings[0].holds());
  CHECK(std::abs(result.couplings[0].mass_ratio - 0.7) < 4.0 * result.couplings[0].mass_ratio_std);
  CHECK(std::abs(result.couplings[1].mass_ratio - 1.3 / 0.7) < 4.0 * result.couplings[1].mass_ratio_std);
}

TEST_CASE("several recordings of a chain have one set of equations, and each a free run of its own",
          "[ident][bodies]") {
  // Each alone is fitted to 9 s; noise of the second is twice that of the first.
  const Draw first = draw_of(two, 0.02, seed + 200, 15.0), second = draw_of(two, 0.04, seed + 201, 15.0);
  const ident::BodiesRecord both = ident::joined({first.record, second.record});
  REQUIRE(both.parts.size() == 2);
  const ident::BodiesResult alone = ident::identify_bodies(first.record, {.num_threads = 2}),
                            together = ident::identify_bodies(both, {.num_threads = 2});
  BodiesTally of;
  of.add(together, first.truth);
  CHECK(of.exact == 1);
  CHECK(of.covered >= of.of - 2);  // of ten or so at 95 %: three outside in one of 60
  REQUIRE(together.runs.size() == 2);
  for (const ident::BodiesRun& run : together.runs) {
    CHECK(run.samples.first == together.train[run.part].last);
    CHECK(run.samples.last == both.parts[run.part].rows.last);
    CHECK(run.errors.nmse.maxCoeff() < 0.01);
  }
  // Information adds up: with the second, a coefficient is never less certain.
  std::size_t shared = 0;
  for (std::size_t i = 0; i < alone.model.terms.size(); ++i)
    for (std::size_t j = 0; j < together.model.terms.size(); ++j)
      if (alone.model.terms[i] == together.model.terms[j] && ++shared > 0)
        CHECK(together.model.std(static_cast<Eigen::Index>(j)) < alone.model.std(static_cast<Eigen::Index>(i)));
  CHECK(shared >= 5);  // of ten or so
}

TEST_CASE("of several recordings the ones that cannot be fitted are named", "[ident][bodies]") {
  const Draw first = draw_of(two, 0.02, seed + 200, 15.0);
  ident::BodiesRecord brief = draw_of(two, 0.02, seed + 201, 15.0).record;
  brief.usable = {{0, 40}};  // of which 24 are to be fitted
  brief.parts.front().name = "brief";
  CHECK_THROWS_WITH(ident::identify_bodies(ident::joined({first.record, brief}), {}), Catch::Contains("brief"));
  ident::BodiesRecord elsewhere = first.record;
  elsewhere.parts.front().zeros(1) = 1.0;
  CHECK_THROWS_WITH(ident::joined({first.record, elsewhere}), Catch::Contains("one zero"));
}

TEST_CASE("base and bodies of several recordings keep their distance", "[ident][bodies]") {
  // A base and bodies that stand 0.2 m from their sensors; in the second recording all are 5 mm higher.
  const ident::BodiesRecord at_rest = draw_of(three, 0.01, seed + 202, 8.0).record;
  const auto raised = [&](double height_m) {
    ident::BodiesRecord record = at_rest;
    record.parts.front().zeros.setConstant(height_m), record.parts.front().zero_of_r = height_m;
    return record;
  };
  const ident::BodiesRecord both = ident::joined({raised(0.2), raised(0.205)});
  const Eigen::Index n = at_rest.samples.rows();
  const Eigen::VectorXd distance = both.samples.col(0) - both.input_samples.col(0),
                        expected = at_rest.samples.col(0) - at_rest.input_samples.col(0);
  const double shift = distance(0) - expected(0);  // of all alike
  CHECK((distance.head(n) - expected).array().isApproxToConstant(shift, 1e-9));
  CHECK((distance.tail(n) - expected).array().isApproxToConstant(shift, 1e-9));
}

TEST_CASE("recordings of other channels are not joined", "[ident][bodies]") {
  const Draw one = draw_of(two, 0.02, seed + 200, 5.0), three_bodies = draw_of(three, 0.02, seed + 201, 5.0);
  CHECK_THROWS_WITH(ident::joined({one.record, three_bodies.record}), Catch::Contains("bodies, which is other"));
  ident::BodiesRecord other_rate = one.record;
  other_rate.sample_rate_hz *= 2.0;
  CHECK_THROWS_WITH(ident::joined({one.record, other_rate}), Catch::Contains("one rate"));
}

TEST_CASE("exact supports, coverage and errors of several bodies", "[.][coverage][bodies]") {
  struct Level {
    const sim::Chain* chain;
    double noise;
    int exact;
    double worst;
  };
  for (const Level& level : {Level{&two, 0.01, 9, 0.01}, Level{&two, 0.05, 8, 0.04}, Level{&three, 0.01, 8, 0.02}}) {
    DYNAMIC_SECTION(level.chain->masses.size() << " masses, noise " << level.noise) {
      const BodiesTally of = tally(*level.chain, level.noise, seed + 1000, 10);
      const double share = static_cast<double>(of.covered) / of.of;
      WARN(fmt::format("exact {} of 10, {} of {} covered ({:.3f}), worst error, median {:.2f} %", of.exact, of.covered,
                       of.of, share, 100.0 * of.median_worst()));
      CHECK(of.exact >= level.exact);
      CHECK(of.median_worst() < level.worst);
      // Coefficients of one record err together: of ten records some thirty values are independent, 4 % their scatter.
      CHECK(share > 0.87);
    }
  }
}

TEST_CASE("modes of a linear chain are those of its matrices", "[ident][bodies]") {
  // x1'' = -300 x1 + 100 (x2 - x1), x2'' = -200 (x2 - x1): by hand K = [400 -100; -200 200].
  const ident::BodiesLayout layout{.num_bodies = 2};
  const std::vector<ident::BodyTerm> terms{{1, "x1"}, {1, "(x2 - x1)"}, {2, "(x2 - x1)"}, {2, "sgn(v2)"}, {1, "x1^3"}};
  const Eigen::VectorXd mean = (Eigen::VectorXd(5) << -300.0, 100.0, -200.0, -0.1, -5e4).finished();
  const Eigen::MatrixXd covariance = (Eigen::VectorXd(5) << 9.0, 1.0, 4.0, 1.0, 1.0).finished().asDiagonal();
  const auto modes = ident::modes_of(layout, terms, mean, covariance);
  REQUIRE(modes.size() == 2);
  const double root = std::sqrt(300.0 * 300.0 - 60'000.0);  // of lambda^2 - 600 lambda + 60000
  const auto hertz = [](double lambda) { return std::sqrt(lambda) / (2.0 * std::acos(-1.0)); };
  CHECK(modes[0].frequency_hz == Approx(hertz(300.0 - root)).epsilon(1e-10));
  CHECK(modes[1].frequency_hz == Approx(hertz(300.0 + root)).epsilon(1e-10));
  CHECK(modes[0].damping == Approx(0.0).margin(1e-10));
  // (400 - lambda) a = 100 b.
  CHECK(modes[0].shape(0) == Approx(100.0 / (400.0 - (300.0 - root))).epsilon(1e-10));
  CHECK(modes[0].shape(1) == 1.0);
  CHECK(modes[1].shape(1) == Approx((400.0 - (300.0 + root)) / 100.0).epsilon(1e-10));
  CHECK(modes[0].shape_std(1) < 1e-12);
  // To first order: the derivative by differences of the closed form, coefficient by coefficient.
  const auto slowest = [&](double k1, double c1, double c2) {
    const double trace = k1 + c1 + c2, det = (k1 + c1) * c2 - c1 * c2;
    return hertz(0.5 * (trace - std::sqrt(trace * trace - 4.0 * det)));
  };
  double square = 0.0;
  square += std::pow(3.0 * (slowest(300.1, 100, 200) - slowest(299.9, 100, 200)) / 0.2, 2);
  square += std::pow(1.0 * (slowest(300, 100.1, 200) - slowest(300, 99.9, 200)) / 0.2, 2);
  square += std::pow(2.0 * (slowest(300, 100, 200.1) - slowest(300, 100, 199.9)) / 0.2, 2);
  CHECK(modes[0].frequency_std == Approx(std::sqrt(square)).epsilon(1e-5));
}

TEST_CASE("action and reaction are tested, not assumed", "[ident][bodies]") {
  const ident::BodiesLayout layout{.num_bodies = 2};
  const std::vector<ident::BodyTerm> terms{{1, "(x2 - x1)"}, {1, "(x2 - x1)^3"}, {1, "(v2 - v1)"},
                                           {2, "(x2 - x1)"}, {2, "(x2 - x1)^3"}, {2, "(v2 - v1)"}};
  const Eigen::VectorXd std = (Eigen::VectorXd(6) << 0.5, 40.0, 0.01, 0.5, 40.0, 0.01).finished();
  const Eigen::MatrixXd covariance = std.cwiseAbs2().asDiagonal();
  Eigen::VectorXd mean = (Eigen::VectorXd(6) << 100.0, 1e4, 0.5, -50.2, -4970.0, -0.252).finished();
  const auto good = ident::couplings_of(layout, terms, mean, covariance);
  REQUIRE(good.size() == 1);
  CHECK(good[0].holds());
  CHECK(good[0].freedom == 2);
  CHECK(std::abs(good[0].mass_ratio - 2.0) < 4.0 * good[0].mass_ratio_std);
  REQUIRE(good[0].mean.size() == 3);
  CHECK(good[0].std(0) < 0.5);  // both equations say it
  mean(4) = -4000.0;            // a cubic that is not felt alike: 1000 of 40
  CHECK_FALSE(ident::couplings_of(layout, terms, mean, covariance)[0].holds());
  const auto lone =
      ident::couplings_of(layout, {terms[0], terms[1], terms[3]}, mean({0, 1, 3}), covariance({0, 1, 3}, {0, 1, 3}));
  CHECK_FALSE(lone[0].holds());
  CHECK(lone[0].on_one_side == std::vector<std::string>{"(x2 - x1)^3"});
}

TEST_CASE("the chi-square of couplings is what normal errors make of it", "[ident][bodies]") {
  const ident::BodiesLayout layout{.num_bodies = 2};
  const std::vector<ident::BodyTerm> terms{{1, "(x2 - x1)"}, {1, "(x2 - x1)^3"}, {1, "(v2 - v1)"},
                                           {2, "(x2 - x1)"}, {2, "(x2 - x1)^3"}, {2, "(v2 - v1)"}};
  const Eigen::VectorXd truth = (Eigen::VectorXd(6) << 100.0, 1e4, 0.5, -50.0, -5000.0, -0.25).finished(),
                        std = (Eigen::VectorXd(6) << 0.5, 40.0, 0.01, 0.4, 30.0, 0.004).finished();
  const sim::Noise draw(seed, 7);
  int below = 0, covered = 0;
  constexpr int draws = 400;
  for (std::uint64_t i = 0; i < draws; ++i) {
    Eigen::VectorXd mean = truth;
    for (std::uint64_t j = 0; j < 6; ++j)
      mean(static_cast<Eigen::Index>(j)) += std(static_cast<Eigen::Index>(j)) * draw.normal(6 * i + j);
    const auto found = ident::couplings_of(layout, terms, mean, std.cwiseAbs2().asDiagonal());
    below += found[0].probability < 0.1 ? 1 : 0;
    covered += std::abs(found[0].mass_ratio - 2.0) < 1.96 * found[0].mass_ratio_std ? 1 : 0;
  }
  CHECK(std::abs(below - 0.1 * draws) < 4.0 * std::sqrt(0.09 * draws));
  CHECK(std::abs(covered - 0.95 * draws) < 4.0 * std::sqrt(0.0475 * draws));
}

TEST_CASE("a record of bodies asks where something is not clear", "[ident][bodies]") {
  dsp::Recording recording{.name = "a.csv", .sample_rate_hz = 100.0};
  const auto channel = [](const char* name, dsp::Role role, int body) {
    dsp::Channel one{.name = name, .role = role, .unit = dsp::info_of(role).order == 1 ? "m/s" : "m"};
    one.body = body;
    return one;
  };
  recording.samples = Eigen::MatrixXd::Random(100, 3);
  recording.channels = {channel("p", dsp::Role::x, 1), channel("q", dsp::Role::v, 2), channel("s", dsp::Role::x, 3)};
  CHECK_THROWS_WITH(ident::bodies_record(recording), Catch::Contains("body 2 has none"));
  recording.channels[1] = channel("q", dsp::Role::x, 0);
  recording.channels[2].body = 2;
  CHECK_THROWS_WITH(ident::bodies_record(recording), Catch::Contains("of which body is channel 'q'"));
  recording.channels[1] = channel("q", dsp::Role::r, 0);
  recording.channels[0].role = dsp::Role::y;
  CHECK_THROWS_WITH(ident::bodies_record(recording), Catch::Contains("some displacements of bodies are absolute"));
  constexpr int hold = 4;
  recording.sample_rate_hz = 200.0;
  recording.samples = Eigen::MatrixXd::Random(100 * hold, 3);
  for (Eigen::Index i = 0; i < recording.samples.rows(); ++i)
    recording.samples(i, 2) = recording.samples(i / hold * hold, 2);
  recording.channels[2].role = dsp::Role::y;
  CHECK_THROWS_WITH(ident::bodies_record(recording),
                    Catch::Contains("channel 's' holds each of its values for 4 samples") && Catch::Contains("50 Hz"));
}

}  // namespace test_bodies
