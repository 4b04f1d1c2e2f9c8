#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "dsp/prepare.hpp"
#include "ident/identify.hpp"
#include "ident/sensors/sensor_parameters.hpp"
#include "support/rig.hpp"

namespace {

struct Score {
  int held = 0, count = 0, found = 0, false_terms = 0;
  double squares = 0.0;
};

/// The main job's ranges of the rig's record with random sensors, by a library of third order.
std::vector<ident::RangeResult> identified(std::uint64_t seed) {
  const dsp::Recording recording = support::rig_record(sim::qzs_twin("T0"), sim::stepped_sine_down(),
                                                       {.level = sim::SensorLevel::random, .seed = seed})
                                       .recording;
  ident::Record record =
      ident::find_regimes(dsp::prepare(recording, {.rate_hz = 25.6, .cutoff_hz = 10.24, .rolloff_hz = 8.0}));
  const std::vector<ident::Range> ranges{{{"low", 2.9, 830.0, 500.0}, 1, dsp::Regime::low},
                                         {{"high", 1440.0, 1720.0, 1560.0}, 1, dsp::Regime::high},
                                         {{"mixed", 0.0, 1720.0, 1000.0}, 1, dsp::RegimeSet::mixed()}};
  dsp::set_displacement_zero(record.prepared, ident::mean_of_first_range(record, ranges, 1));
  const auto library = ident::make_library({.order = 3, .terms = {"sgn(v)", "ddr"}}, "a", record.prepared.signals);
  std::vector<ident::Columns> columns;
  columns.push_back(ident::form_columns(library, "a", record.prepared));
  columns.front().regimes = record.regimes;
  columns.front().sensors = ident::sensor_parameters(record);
  std::vector<ident::RangeResult> results;
  for (const ident::Range& range : ranges)
    results.push_back(ident::identify(
        range, columns, library, {.target_unit = "m/s^2", .methods = {ident::FastRvmOptions{}}, .free_run = false}));
  return results;
}

}  // namespace

TEST_CASE("printed intervals hold the truth of the rig, whatever its sensors", "[.][study][rig_coverage]") {
  constexpr std::uint64_t first_seed = 3001, num_seeds = 20;
  std::map<std::string, Score> scores;
  for (std::uint64_t seed = first_seed; seed < first_seed + num_seeds; ++seed) {
    const auto sensors = sim::rig_sensors(sim::SensorLevel::random, sim::qzs_twin("T0"), seed);
    const auto truth = sim::true_terms_as_recorded(sim::qzs_twin("T0"), sensors[1].gain);
    for (const ident::RangeResult& range : identified(seed)) {
      Score& score = scores[range.spec.name];
      const ident::Model& model = range.fits.front().model;
      score.false_terms += static_cast<int>(model.terms.size());
      for (const sim::TrueTerm& term : truth) {
        ++score.count;
        for (const ident::ModelTerm& found : model.terms) {
          if (found.name != term.name) continue;
          const double z = (found.mean - term.value) / found.std;
          score.held += std::abs(z) <= 1.96;
          score.squares += z * z;
          ++score.found;
          --score.false_terms;
        }
      }
    }
  }
  int false_terms = 0;
  for (const auto& [name, score] : scores) {
    WARN(fmt::format("{}: {} of {} true coefficients inside their 95 % intervals, rms z {:.2f}, {} false terms", name,
                     score.held, score.count, std::sqrt(score.squares / score.found), score.false_terms));
    CHECK(score.held >= 0.89 * score.count);
    CHECK(std::sqrt(score.squares / score.found) <= 1.2);
    false_terms += score.false_terms;
  }
  CHECK(false_terms <= 5);
}
