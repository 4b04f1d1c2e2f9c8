#include "ident/switches/exact_switches.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include "ident/identify.hpp"
#include "support/rig.hpp"

namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// x and its derivatives: three sines, all below 12 Hz.
struct Course {
  double x = 0.0, v = 0.0, a = 0.0;
};
Course course(double t) {
  Course c;
  const double amplitudes[] = {1.0, 0.4, 0.2}, frequencies_hz[] = {1.3, 4.1, 11.7}, phases[] = {0.2, 1.1, 2.5};
  for (int k = 0; k < 3; ++k) {
    const double w = 2.0 * std::numbers::pi * frequencies_hz[k], phase = w * t + phases[k];
    c.x += amplitudes[k] * std::sin(phase);
    c.v += amplitudes[k] * w * std::cos(phase);
    c.a -= amplitudes[k] * w * w * std::sin(phase);
  }
  return c;
}

dsp::Recording recording(double rate_hz, double duration_s) {
  dsp::Recording result{.name = "sines", .sample_rate_hz = rate_hz};
  result.channels = {{.name = "x", .role = dsp::Role::x, .unit = "m"}};
  result.samples.resize(static_cast<Index>(duration_s * rate_hz), 1);
  for (Index i = 0; i < result.samples.rows(); ++i) result.samples(i, 0) = course(static_cast<double>(i) / rate_hz).x;
  return result;
}

/// A function of time at `rate_hz`, each sample the mean of 32 within its cell, so that jumps keep their places.
VectorXd finely_sampled(const std::function<double(const Course&)>& value, Index count, double rate_hz) {
  constexpr int parts = 32;
  VectorXd fine = VectorXd::Zero(count);
  for (Index i = 0; i < count; ++i)
    for (int k = 0; k < parts; ++k)
      fine(i) += value(course((static_cast<double>(i) + (k + 0.5) / parts - 0.5) / rate_hz)) / parts;
  return fine;
}

/// What is left of it behind a raised-cosine low-pass, by forming it 64 times as fast.
VectorXd by_fine_sampling(const std::function<double(const Course&)>& value, const dsp::Prepared& prepared) {
  constexpr Index factor = 64;
  const double rate_hz = factor * prepared.intermediate.sample_rate_hz;
  const VectorXd fine = finely_sampled(value, prepared.intermediate.num_samples() * factor, rate_hz);
  const auto& o = prepared.options;
  const VectorXd filtered = dsp::ColumnFilter::taper(rate_hz, {o.rolloff_hz, o.cutoff_hz}).apply(fine);
  return filtered(Eigen::seq(0, filtered.size() - 1, factor));
}

double worst_inside(const VectorXd& column, const VectorXd& truth) {
  const Index edge = column.size() / 8;
  const Index inside = column.size() - 2 * edge;
  return (column - truth).segment(edge, inside).cwiseAbs().maxCoeff() / truth.cwiseAbs().maxCoeff();
}

struct Formed {
  const char* term;
  std::function<double(const Course&)> value;
};
const std::vector<Formed> formed_terms{
    {"sgn(v)", [](const Course& c) { return c.v > 0.0 ? 1.0 : -1.0; }},
    {"sgn(x)", [](const Course& c) { return c.x > 0.0 ? 1.0 : -1.0; }},
    {"abs(x)", [](const Course& c) { return std::abs(c.x); }},
    {"abs(v)*v", [](const Course& c) { return std::abs(c.v) * c.v; }},
    {"sgn(v)*x^2", [](const Course& c) { return (c.v > 0.0 ? 1.0 : -1.0) * c.x * c.x; }},
    {"sgn(v-10*x)*x", [](const Course& c) { return (c.v > 10.0 * c.x ? 1.0 : -1.0) * c.x; }},
    {"(v>0)*x", [](const Course& c) { return c.v > 0.0 ? c.x : 0.0; }},
    {"sgn(v)*abs(v*x)", [](const Course& c) { return (c.v > 0.0 ? 1.0 : -1.0) * std::abs(c.v * c.x); }},
    {"sgn(x)+sgn(x-0.1)+sgn(x-0.2)+sgn(x-0.3)+sgn(x-0.4)+sgn(x+0.1)+sgn(x+0.2)+sgn(x+0.3)+sgn(x+0.4)",
     [](const Course& c) {
       double sum = 0.0;
       for (int k = -4; k <= 4; ++k) sum += c.x > 0.1 * k ? 1.0 : -1.0;
       return sum;
     }},
    {"x^3", [](const Course& c) { return c.x * c.x * c.x; }},
    {"x^2*v", [](const Course& c) { return c.x * c.x * c.v; }},
};

}  // namespace

TEST_CASE("a column is its term in continuous time behind the column filter, at the record's own rate",
          "[ident][exact_switches]") {
  // 11.7 Hz of 51.2: cubes go to 35 Hz, beyond half the rate, and switches far beyond.
  const dsp::Prepared prepared = dsp::prepare(recording(51.2, 20.0), {});
  for (const Formed& formed : formed_terms) {
    const ident::CandidateLibrary library =
        ident::make_library({.order = 0, .terms = {formed.term}}, "a", prepared.signals);
    const ident::Columns columns = ident::form_columns(library, "a", prepared);
    INFO(formed.term);
    // Jumps of curvature, as of abs(v)*v, are as the samples have them.
    CHECK(worst_inside(columns.phi.col(0), by_fine_sampling(formed.value, prepared)) <= 3e-3);
  }
}

TEST_CASE("a column beside others is what it would be among them", "[ident][exact_switches]") {
  for (const dsp::Recipe recipe : {dsp::Recipe::matched, dsp::Recipe::paper}) {
    const dsp::Prepared prepared = dsp::prepare(recording(51.2, 20.0), {.recipe = recipe});
    const auto among = ident::make_library({.order = 0, .terms = {"x", "abs(v)", "sgn(v)"}}, "a", prepared.signals),
               without = ident::make_library({.order = 0, .terms = {"x"}}, "a", prepared.signals);
    const ident::Columns all = ident::form_columns(among, "a", prepared),
                         one = ident::form_columns(without, "a", prepared);
    CHECK(ident::column_beside(one, "abs(v)", "a") == all.phi.col(1));
    CHECK(ident::column_beside(one, "sgn(v)", "a") == all.phi.col(2));
  }
}

TEST_CASE("it is so where columns are formed at an intermediate rate", "[ident][exact_switches]") {
  const dsp::Prepared prepared = dsp::prepare(recording(512.0, 20.0), {.rate_hz = 51.2});
  REQUIRE(prepared.intermediate.sample_rate_hz == Approx(512.0));
  for (const Formed& formed : formed_terms) {
    const ident::CandidateLibrary library =
        ident::make_library({.order = 0, .terms = {formed.term}}, "a", prepared.signals);
    const ident::Columns columns = ident::form_columns(library, "a", prepared);
    constexpr Index factor = 16;
    const VectorXd fine = finely_sampled(formed.value, prepared.intermediate.num_samples() * factor, factor * 512.0);
    const VectorXd bus = dsp::decimate(fine, factor * 512.0, {.output_rate_hz = 512.0, .passband_end_hz = 100.0});
    INFO(formed.term);
    CHECK(worst_inside(columns.phi.col(0), prepared.filter.apply(bus)) <= 5e-4);
  }
}

namespace {

/// Reversals of the payload at which it does not stop, s.
std::vector<double> reversal_times(const sim::QzsParameters& parameters, const sim::Programme& programme) {
  sim::QzsTrajectory trajectory(std::make_shared<const sim::QzsRig>(parameters, programme), programme.duration_s);
  (void)trajectory.at(programme.duration_s);
  std::vector<double> times;
  for (const sim::Event& event : trajectory.events())
    if (event.mode_before * event.mode_after < 0) times.push_back(event.t_s);
  return times;
}

sim::Programme shaken() {
  return sim::sine_steps({.frequencies_hz = {1.84, 1.78, 1.72, 1.66, 1.6}, .dwell_s = 24.0});
}

}  // namespace

TEST_CASE("reversals are found where the payload turned, not where the state band shows it",
          "[ident][exact_switches]") {
  const sim::QzsParameters parameters;  // T0
  const support::RigRecord rig = support::rig_record(parameters, shaken(), {.level = sim::SensorLevel::ideal});
  const dsp::Prepared prepared = dsp::prepare(rig.recording, {.rate_hz = 25.6, .cutoff_hz = 10.24, .rolloff_hz = 8.0});
  const ident::CandidateLibrary library = ident::make_library({.order = 0, .terms = {"sgn(v)"}}, "a", prepared.signals);
  ident::ExactSwitches switches(prepared, library);
  const auto errors_s = [&] {
    std::vector<double> errors;
    for (const double t_s : reversal_times(parameters, shaken())) {
      if (t_s < 10.0 || t_s > 110.0) continue;
      double nearest = INFINITY;
      for (const ident::Crossing& crossing : switches.crossings().of(0))
        if (std::abs(crossing.t_s - t_s) < std::abs(nearest)) nearest = crossing.t_s - t_s;
      errors.push_back(std::abs(nearest));
    }
    std::sort(errors.begin(), errors.end());
    return errors;
  };
  const std::vector<double> rounded = errors_s();
  REQUIRE(rounded.size() > 300);
  CHECK(rounded[rounded.size() / 2] > 2e-4);
  switches.settle({{library.terms.front().expression, -parameters.mu_kinetic}});
  const std::vector<double> exact = errors_s();
  CHECK(exact[exact.size() / 2] <= 2e-6);  // the laser's 24 bits and the decimation leave as much
  CHECK(exact.back() <= 2e-5);
}

TEST_CASE("where friction falls with the speed the speed is the payload's within milliseconds of a reversal",
          "[ident][exact_switches]") {
  sim::QzsParameters parameters;
  parameters.mu_kinetic = 0.065, parameters.stribeck_m_per_s = 0.01;
  const support::RigRecord rig = support::rig_record(parameters, shaken(), {.level = sim::SensorLevel::ideal});
  const dsp::Prepared prepared = dsp::prepare(rig.recording, {.rate_hz = 25.6, .cutoff_hz = 10.24, .rolloff_hz = 8.0});
  const ident::CandidateLibrary library =
      ident::make_library({.order = 0, .terms = {"sgn(v)", "sgn(v)*exp(-abs(v)/0.01)"}}, "a", prepared.signals);
  ident::ExactSwitches switches(prepared, library);
  const auto error = [&](const ident::WeightedTerms& equation) {
    switches.settle({});
    switches.settle(equation);
    const Index first = 10 * 256, count = 100 * 256;
    return (switches.crossings().samples("v", 1, first, count) - rig.v.segment(first, count)).norm() / std::sqrt(count);
  };
  const double fall = parameters.mu_static - parameters.mu_kinetic;
  const double rounded = error({}), kinks_alone = error({{library.terms[0].expression, -parameters.mu_static}}),
               whole =
                   error({{library.terms[0].expression, -parameters.mu_kinetic}, {library.terms[1].expression, -fall}});
  CAPTURE(rounded, kinks_alone, whole);
  // The friction falls within three samples, so that what is between two of them is seen to a tenth.
  CHECK(whole < 0.05 * rounded);
  CHECK(whole < 0.2 * kinks_alone);
}

TEST_CASE("switches placed in a copy of columns leave the columns as they are", "[ident][exact_switches]") {
  const support::RigRecord rig = support::rig_record({}, shaken(), {.level = sim::SensorLevel::ideal});
  const dsp::Prepared prepared = dsp::prepare(rig.recording, {.rate_hz = 25.6, .cutoff_hz = 10.24});
  const auto library = ident::make_library({.order = 0, .terms = {"x", "v", "sgn(v)"}}, "a", prepared.signals);
  ident::Columns columns = ident::form_columns(library, "a", prepared);
  const Eigen::MatrixXd formed = columns.phi;
  const ident::WeightedTerms equation{{library.terms.back().expression, -0.08}};
  std::optional<ident::Columns> copy = ident::with_own_switches(columns);
  ident::place_switches(*copy, library, equation);
  CHECK(columns.phi == formed);
  CHECK_FALSE(columns.switches->must_form({}));
  CHECK(copy->phi != formed);
  ident::Columns again = ident::with_own_switches(*copy);  // and outlives what it was copied from
  copy.reset();
  ident::place_switches(again, library, {});
  CHECK(again.phi == formed);
}

TEST_CASE("columns that were wanted in one stretch are formed again where another is wanted",
          "[ident][exact_switches]") {
  const support::RigRecord rig = support::rig_record({}, shaken(), {.level = sim::SensorLevel::ideal});
  const dsp::Prepared prepared = dsp::prepare(rig.recording, {.rate_hz = 25.6, .cutoff_hz = 10.24});
  const auto library = ident::make_library({.order = 0, .terms = {"x", "v", "sgn(v)"}}, "a", prepared.signals);
  ident::Columns columns = ident::form_columns(library, "a", prepared);
  const Eigen::MatrixXd formed = columns.phi;
  const Index n = formed.rows(), quarter = n / 4;
  const double rate_hz = prepared.signals.sample_rate_hz;
  const auto stretch = [&](Index first, Index end) {
    return dsp::Stretch{static_cast<double>(first) / rate_hz, static_cast<double>(end) / rate_hz};
  };
  columns.switches->limit_to(stretch(quarter, 2 * quarter));  // at the ends a high-pass has not settled
  ident::place_switches(columns, library, {{library.terms.back().expression, -0.08}});
  ident::place_switches(columns, library, {});
  const auto difference = [&](Index first) {  // over each column's largest value
    const auto both = (columns.phi - formed).middleRows(first, quarter).cwiseAbs().colwise().maxCoeff();
    return (both.array() / formed.cwiseAbs().colwise().maxCoeff().array()).maxCoeff();
  };
  CHECK(difference(quarter) < 1e-6);  // as filtered_within promises behind a high-pass
  columns.switches->limit_to(stretch(2 * quarter, 3 * quarter));
  CHECK(columns.switches->must_form({}));
  ident::place_switches(columns, library, {});
  CHECK(difference(2 * quarter) < 1e-6);
  CHECK_FALSE(columns.switches->must_form({}));
}

TEST_CASE("a constant is left out where accelerometers pass none", "[ident][exact_switches]") {
  const support::RigRecord rig = support::rig_record({}, shaken(), {.level = sim::SensorLevel::full});
  const auto prepared = dsp::prepare(rig.recording, {.rate_hz = 25.6, .cutoff_hz = 10.24});
  const auto library = ident::make_library({.order = 0, .terms = {"x", "3"}}, "a", prepared.signals);
  const ident::Columns columns = ident::form_columns(library, "a", prepared);
  REQUIRE(columns.dropped.size() == 1);
  CHECK(columns.dropped[0].name == "3");
  CHECK(columns.dropped[0].reason == "constant, and accelerometers pass no constant");
}

TEST_CASE("regimes of a record are those of its motion, and its power balance is checked", "[ident][exact_switches]") {
  const support::RigRecord rig = support::rig_record({}, shaken(), {.level = sim::SensorLevel::noise});
  const auto prepared = dsp::prepare(rig.recording, {.rate_hz = 25.6, .cutoff_hz = 10.24});
  const ident::Record record = ident::find_regimes(prepared);
  const auto segmentation = dsp::segment_regimes(prepared.intermediate, {});
  CHECK(record.segmentation.segments.size() == segmentation.segments.size());
  CHECK(record.regimes.size() == static_cast<std::size_t>(prepared.signals.num_samples()));
  CHECK(record.power.has_value());
  CHECK(record.prepared.checks.back().name == "power.balance");
}

TEST_CASE("the equation of a rig with ideal sensors is the true one", "[ident][exact_switches]") {
  const support::RigRecord rig = support::rig_record({}, shaken(), {.level = sim::SensorLevel::ideal});
  for (const double rate_hz : {25.6, 32.0}) {
    ident::Record record{.prepared = dsp::prepare(rig.recording, {.rate_hz = rate_hz, .cutoff_hz = 0.4 * rate_hz})};
    dsp::RangeSpec low;
    low.name = "low", low.from_s = 10.0, low.to_s = 120.0, low.train_to_s = 100.0;
    record.ranges = {low};
    const auto results = ident::identify(std::move(record), {.order = 0, .terms = {"x", "v", "x^3", "sgn(v)", "ddr"}},
                                         {.target = "a", .methods = {ident::FastRvmOptions{}}, .free_run = false});
    const std::vector<double> truth{-50.0, -0.8, -9.5e4, -0.08, -1.0};
    const auto& terms = results.front().fits.front().model.terms;
    REQUIRE(terms.size() == truth.size());
    for (std::size_t i = 0; i < truth.size(); ++i) {
      INFO(rate_hz << " Hz: " << terms[i].name);
      CHECK(terms[i].mean == Approx(truth[i]).epsilon(1e-3));
    }
  }
}
