#include "ident/columns/sensor_columns.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "ident/columns/columns.hpp"
#include "ident/ranges/range_sensors.hpp"
#include "ident/records/record.hpp"
#include "support/signals.hpp"

namespace test_sensors_sensor_columns {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double rate_hz = 256.0;

/// Two lasers on base and payload; the base's reads (1 - relative_gain_error) times too little.
dsp::Recording two_lasers(double relative_gain_error) {
  const Index n = static_cast<Index>(60 * rate_hz);
  const support::SweptHarmonics base{.start_hz = 1.6, .amplitudes = {4.5e-3, 0.0, 0.0, 0.0}},
      relative{.start_hz = 1.6, .amplitudes = {9e-3, 0.0, 3e-4, 0.0}};
  dsp::Recording recording{.name = "two lasers", .sample_rate_hz = rate_hz};
  recording.channels = {{.name = "base", .role = dsp::Role::r, .unit = "m"},
                        {.name = "payload", .role = dsp::Role::y, .unit = "m"}};
  recording.samples.resize(n, 2);
  for (Index i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) / rate_hz, r = base.at(t + 0.11).x;
    recording.samples(i, 0) = r / (1.0 + relative_gain_error);
    recording.samples(i, 1) = relative.at(t).x + r;
  }
  return recording;
}

dsp::Prepared prepared(double relative_gain_error) {
  return dsp::prepare(two_lasers(relative_gain_error), {.rate_hz = 25.6, .cutoff_hz = 10.24, .rolloff_hz = 8.0});
}

const ident::WeightedTerms equation{{ident::Expression("x"), -50.0},
                                    {ident::Expression("v"), -0.8},
                                    {ident::Expression("x^3"), -9.5e4},
                                    {ident::Expression("sgn(v)"), -0.08},
                                    {ident::Expression("abs(x)*x"), -300.0}};

/// Equation less target, as its columns have it.
VectorXd error(const dsp::Prepared& record) {
  ident::LibraryOptions options{.order = 0};
  for (const auto& term : equation) options.terms.push_back(term.first.text());
  const auto library = ident::make_library(options, "a", record.signals);
  const ident::Columns columns = ident::form_columns(library, "a", record);
  VectorXd sum = -columns.target;
  for (std::size_t j = 0; j < equation.size(); ++j) sum += equation[j].second * columns.phi.col(static_cast<Index>(j));
  return sum;
}

std::vector<std::shared_ptr<const ident::SensorShape>> shapes(const std::vector<ident::SensorParameter>& parameters) {
  std::vector<std::shared_ptr<const ident::SensorShape>> result;
  for (const auto& parameter : parameters) result.push_back(parameter.shape);
  return result;
}

}  // namespace

TEST_CASE("a sensor's column is what the equation's own columns change by when the sensor does",
          "[ident][sensor_columns]") {
  ident::Record record{.prepared = prepared(0.0)};
  const auto parameters = ident::sensor_parameters(record);
  REQUIRE(parameters.size() == 2);  // a minute is too short for a drift
  CHECK(parameters[0].name == "relative gain of the base's displacement");
  CHECK(parameters[0].std == Approx(0.01 * std::sqrt(2.0)));
  const MatrixXd columns = ident::sensor_columns(record.prepared, ident::regression_accelerations(record.prepared),
                                                 shapes(parameters), equation, "a")
                               .values;
  const double step = 1e-3;
  const VectorXd expected = (error(prepared(-step)) - error(prepared(step))) / (2.0 * step);
  const Index edge = 100, inner = expected.size() - 2 * edge;
  // Recorded too small by the step is to be raised by it: the column has the other sign than the recordings' error.
  // Switches move by whole samples of the recording here and by fractions there: the hundredth of it.
  CHECK((columns.col(0) - expected).segment(edge, inner).norm() < 0.02 * expected.segment(edge, inner).norm());
}

TEST_CASE("the columns of a mount are what the equation's own columns change by when another mount is undone",
          "[ident][sensor_columns][mount]") {
  const dsp::Mount mount{10.7, 0.10, 0.08, 0.005};
  const auto undone_by = [](const dsp::Mount& other) {
    ident::Record record{.prepared = prepared(0.0)};
    record.mount = other;
    for (dsp::Motion* motion : {&record.prepared.intermediate, &record.prepared.signals})
      dsp::undo_mount(*motion, other, ident::mount_band(record.prepared));
    return record;
  };
  const ident::Record record = undone_by(mount);
  const auto parameters = ident::sensor_parameters(record);
  REQUIRE(parameters.size() == 4);
  CHECK(parameters[2].name == "frequency of the mount");
  CHECK(parameters[2].std == 0.08);
  CHECK(parameters[3].name == "damping of the mount");
  CHECK(parameters[3].std == 0.005);
  const MatrixXd columns = ident::sensor_columns(record.prepared, ident::regression_accelerations(record.prepared),
                                                 shapes(parameters), equation, "a")
                               .values;
  const double step_hz = 0.1, step = 0.01;  // switches move by some fractions of a sample
  const MatrixXd expected =
      (MatrixXd(columns.rows(), 2) << (error(undone_by({10.7 + step_hz, 0.10}).prepared) -
                                       error(undone_by({10.7 - step_hz, 0.10}).prepared)) /
                                          (2.0 * step_hz),
       (error(undone_by({10.7, 0.10 + step}).prepared) - error(undone_by({10.7, 0.10 - step}).prepared)) / (2.0 * step))
          .finished();
  const Index edge = 100, inner = columns.rows() - 2 * edge;
  for (Index k = 0; k < 2; ++k)
    CHECK((columns.col(2 + k) - expected.col(k)).segment(edge, inner).norm() <
          0.02 * expected.col(k).segment(edge, inner).norm());
}

TEST_CASE("a record prepared as the paper does has no sensor parameters", "[ident][sensor_columns]") {
  ident::Record record{
      .prepared = dsp::prepare(two_lasers(0.0), {.recipe = dsp::Recipe::paper, .rate_hz = 25.6, .cutoff_hz = 10.24})};
  CHECK(ident::sensor_parameters(record).empty());
}

TEST_CASE("what a sidecar says of a sensor is its prior", "[ident][sensor_columns]") {
  dsp::Recording recording = two_lasers(0.0);
  for (dsp::Channel& channel : recording.channels) channel.sensitivity_uncertainty = 0.002, channel.range = 0.1;
  ident::Record record{.prepared = dsp::prepare(recording, {.rate_hz = 25.6, .cutoff_hz = 10.24, .rolloff_hz = 8.0})};
  const auto parameters = ident::sensor_parameters(record);
  CHECK(parameters.at(0).std == Approx(0.002 * std::sqrt(2.0)));
  CHECK(parameters.at(1).std == Approx(1e-3 * std::sqrt(2.0)));
}

TEST_CASE("a joint range has the sensors of each recording, under its name", "[ident][sensor_columns]") {
  const ident::Record record{.prepared = prepared(0.0)};
  const auto library = ident::make_library({.order = 1}, "a", record.prepared.signals);
  std::vector<ident::Columns> columns(2, ident::form_columns(library, "a", record.prepared));
  columns[0].name = "first", columns[1].name = "second";
  for (ident::Columns& one : columns) one.sensors = ident::sensor_parameters(record);
  const auto names = [&](int recording) {
    const ident::Range range{{.name = "all"}, recording, {}};
    std::vector<std::string> found;
    const ident::RangeSensors sensors(range, ident::stretches_of(ident::range_rows(range, columns), columns), columns);
    for (const auto& parameter : sensors.parameters()) found.push_back(parameter.name);
    return found;
  };
  std::vector<std::string> both;
  for (const char* name : {"first: ", "second: "})
    for (const std::string& own : names(1)) both.push_back(name + own);
  CHECK_FALSE(both.empty());
  CHECK(names(0) == both);
}

TEST_CASE("a lone displacement has a zero and a drift, a force a lag, and neither a gain", "[ident][sensor_columns]") {
  const auto n = static_cast<Index>(400 * rate_hz);
  const support::SweptHarmonics motion;
  dsp::Recording recording{.name = "bench", .sample_rate_hz = rate_hz};
  recording.channels = {{.name = "laser", .role = dsp::Role::x, .unit = "m", .range = 0.1, .drift = 4e-5},
                        {.name = "cell", .role = dsp::Role::f, .unit = "N"}};
  recording.samples.resize(n, 2);
  for (Index i = 0; i < n; ++i) {
    const auto p = motion.at(static_cast<double>(i) / rate_hz);
    recording.samples.row(i) << p.x, 50.0 * p.x + 3.0 * p.v;
  }
  const ident::Record record{.prepared =
                                 dsp::prepare(recording, {.rate_hz = 25.6, .cutoff_hz = 10.24, .rolloff_hz = 8.0})};
  const auto parameters = ident::sensor_parameters(record);
  std::vector<std::string> names;
  for (const auto& parameter : parameters) names.push_back(parameter.name);
  REQUIRE(names == std::vector<std::string>{"zero of x", "drift of x at 0 s", "drift of x at 300 s",
                                            "drift of x at 600 s", "lag of f"});
  CHECK(parameters[0].std == Approx(1e-3));
  CHECK(parameters[1].std == 4e-5);
  auto stated = record;
  stated.zero_is_known = true;
  CHECK(ident::sensor_parameters(stated).at(0).name == "drift of x at 0 s");
  auto own = record;  // a sensor that states neither range nor drift keeps its zero, unless it is to be fitted
  own.prepared.channels[0].range = own.prepared.channels[0].drift = 0.0;
  CHECK(ident::sensor_parameters(own).at(0).name == "lag of f");
  own.zero_is_fitted = true;
  CHECK(ident::sensor_parameters(own).at(0).name == "zero of x");
  CHECK(parameters[4].std == Approx(1.0 / rate_hz / std::sqrt(12.0)));
  // x, and y, which is x without a base, move together; f by its slope.
  const auto zero = parameters[0].shape->change(record.prepared.signals)(0, 10);
  REQUIRE(zero.size() == 2);
  CHECK((zero[0].name == "x" && zero[1].name == "y" && zero[1].values == zero[0].values));
  const auto& signals = record.prepared.signals;
  const auto slope = parameters[4].shape->change(signals)(0, signals.num_samples());
  const Index edge = 100, inner = signals.num_samples() - 2 * edge;
  VectorXd slope_of_f(inner);
  for (Index i = 0; i < inner; ++i) {
    const auto p = motion.at(static_cast<double>(edge + i) / signals.sample_rate_hz);
    slope_of_f(i) = 50.0 * p.v + 3.0 * p.a;
  }
  // Four seconds from the ends what prediction beyond them is wrong by is below a thousandth.
  CHECK((slope.at(0).values.segment(edge, inner) - slope_of_f).norm() < 1e-3 * slope_of_f.norm());
}

}  // namespace test_sensors_sensor_columns
