#include "ident/ranges/mean_rows.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "dsp/prepare.hpp"
#include "ident/identify.hpp"
#include "support/random.hpp"
#include "support/rig.hpp"

using Eigen::Index;
using Eigen::MatrixXd;

TEST_CASE("means over blocks are those of the samples, however they come", "[ident][mean_rows]") {
  const MatrixXd samples = support::gaussian(1030, 2, 1);
  ident::BlockMeans means(samples.rows(), 3, 99.7);
  REQUIRE(means.size == 100);
  REQUIRE(means.values.rows() == 10);  // the last 30 samples fill none
  for (Index first = 0, count = 7; first < samples.rows(); first += count, count = (3 * count) % 251)
    means.add(first, 1, samples.middleRows(first, std::min(count, samples.rows() - first)));
  CHECK(means.values.col(0).isZero(0.0));
  for (Index block = 0; block < 10; ++block)
    // Sums of 100 numbers of about 1: rounding of 100 eps.
    CHECK((means.values.row(block).tail(2) - samples.middleRows(100 * block, 100).colwise().mean()).norm() < 1e-14);
}

TEST_CASE("where x is zero is known though accelerometers pass no constant", "[ident][mean_rows]") {
  // A bent spring: x is 0.1 mm on average, which a zero off by as much hides, with 30 of x^2.
  sim::QzsParameters bent = sim::qzs_twin("T0");
  bent.k2 = -200.0;
  const sim::Programme programme = sim::stepped_sine({.frequencies_hz = {1.84, 1.8, 1.76, 1.72, 1.68, 1.64}});
  const dsp::Recording recording = support::rig_record(bent, programme).recording;
  ident::Record record =
      ident::find_regimes(dsp::prepare(recording, {.rate_hz = 25.6, .cutoff_hz = 10.24, .rolloff_hz = 8.0}));
  REQUIRE_FALSE(record.prepared.highpass_hz.empty());
  CHECK(ident::loses_known_means(record.prepared));
  const ident::Range low{{"low", 10.0, 240.0, 240.0}, 1, dsp::RegimeSet::mixed()};
  dsp::set_displacement_zero(record.prepared, ident::mean_of_first_range(record, {low}, 1));
  const auto library = ident::make_library({.order = 0, .terms = {"x", "v", "x^2", "x^3", "sgn(v)", "ddr"}}, "a",
                                           record.prepared.signals);
  std::vector<ident::Columns> columns;
  columns.push_back(ident::record_columns(library, "a", record));
  const ident::RangeResult result = ident::identify(
      low, columns, library, {.target_unit = "m/s^2", .methods = {ident::FastRvmOptions{}}, .free_run = false});
  bool found = false;
  for (const ident::ModelTerm& term : result.fits.front().model.terms) {
    if (term.name != "x^2") continue;
    found = true;
    const double gain = sim::rig_sensors(sim::SensorLevel::full, bent)[1].gain;  // in whose units x is
    CHECK(std::abs(term.mean - 200.0 / gain) < 3.0 * term.std);
    CHECK(term.std < 20.0);  // the prior of the zero alone, 0.7 mm, leaves 3 * 9.5e4 * 7e-4 = 200
  }
  CHECK(found);
}
