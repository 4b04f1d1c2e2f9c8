#include "ident/records/record.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "ident/records/left_out.hpp"

namespace {

using Strings = std::vector<std::string>;

/// Signals of one value or moving, by name, and nothing else.
ident::Record record_with(const std::string& name, const std::vector<std::pair<std::string, std::string>>& moving,
                          const Strings& still = {}) {
  ident::Record record;
  record.prepared.name = name;
  auto& signals = record.prepared.signals.signals;
  for (const auto& [signal, unit] : moving) signals.push_back({signal, unit, Eigen::Vector3d(0.0, 1.0, -1.0)});
  for (const auto& signal : still) signals.push_back({signal, "N", Eigen::Vector3d(2.0, 2.0, 2.0)});
  return record;
}

/// A payload on its base at 2 Hz that, where `rests`, stands on the ground for the second half.
dsp::Recording on_a_moving_base(bool rests) {
  constexpr double rate_hz = 200.0, noise_m = 1e-7;
  constexpr Eigen::Index n = 24'000;
  dsp::Recording recording{.name = "bench", .sample_rate_hz = rate_hz};
  recording.channels = {{.name = "top", .role = dsp::Role::y, .unit = "m"},
                        {.name = "base", .role = dsp::Role::r, .unit = "m"}};
  recording.samples.resize(n, 2);
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, noise_m);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double phase = 2.0 * std::numbers::pi * 2.0 * static_cast<double>(i) / rate_hz;
    const bool stands = rests && i > n / 2;
    recording.samples(i, 0) = (stands ? 0.0 : 3e-3 * std::sin(phase)) + noise(random);
    recording.samples(i, 1) = 4e-3 * std::sin(phase - 0.3) + noise(random);
  }
  return recording;
}

bool is_said(const ident::Record& record, const std::string& check) {
  const auto& checks = record.prepared.checks;
  return std::any_of(checks.begin(), checks.end(), [&](const dsp::Check& one) { return one.name == check; });
}

}  // namespace

TEST_CASE("friction and what acts from outside are candidates by default", "[ident][record]") {
  const auto record = record_with(
      "a", {{"x", "m"}, {"v", "m/s"}, {"ddr", "m/s^2"}, {"f", "N"}, {"coil", "A"}, {"strain", "m/m"}, {"t", "s"}});
  CHECK(ident::default_terms({&record}) == Strings{"sgn(v)", "ddr", "f", "coil"});
  const auto idle = record_with("b", {{"x", "m"}, {"v", "m/s"}}, {"f"});
  CHECK(ident::default_terms({&idle}) == Strings{"sgn(v)"});
  // A force that acts in one record and is there in the other, if at rest, is a candidate of both.
  CHECK(ident::default_terms({&idle, &record}) == Strings{"sgn(v)", "f"});
}

TEST_CASE("an input that another record lacks is said, with the record", "[ident][record]") {
  const auto forced = record_with("forced.csv", {{"x", "m"}, {"f", "N"}, {"ddr", "m/s^2"}}),
             free = record_with("free.csv", {{"x", "m"}, {"ddr", "m/s^2"}});
  CHECK(ident::default_terms({&forced, &free}) == Strings{"sgn(v)", "ddr"});
  const auto checks = ident::inputs_of_some({&forced, &free});
  REQUIRE(checks.size() == 1);
  CHECK(checks.front().name == "input.not_everywhere");
  CHECK(checks.front().status == dsp::CheckStatus::warning);
  CHECK_THAT(checks.front().message, Catch::Contains("f was not recorded in free.csv"));
  CHECK(ident::inputs_of_some({&forced, &forced}).empty());
}

TEST_CASE("what is left out is said, with its reasons, and from a quarter on with what to change", "[ident][record]") {
  // 1000 samples at 10 Hz, 20 at either end spoilt.
  const auto record = [](double excluded_to_s, std::size_t stuck_from) {
    ident::Record result;
    result.prepared.excluded = {{10.0, excluded_to_s, "a knock"}};
    result.prepared.signals.sample_rate_hz = 10.0;
    result.prepared.signals.signals = {{"x", "m", Eigen::VectorXd::Zero(1000)}};
    result.prepared.signals.edge_samples = 20;
    result.regimes.assign(1000, dsp::Regime::low);
    std::fill(result.regimes.begin() + static_cast<std::ptrdiff_t>(stuck_from), result.regimes.end(),
              dsp::Regime::stick);
    result.segmentation.mount = dsp::Mount{};
    result.segmentation.options.stick_speed_m_per_s = 0.01;
    return result;
  };
  const dsp::Check little = ident::left_out(record(14.95, 900));
  CHECK(little.status == dsp::CheckStatus::note);
  CHECK(little.value == Approx(0.05 + 0.04 + 0.08));
  CHECK_THAT(little.message, Catch::Contains("8 % stops") && Catch::Contains("5 % a knock"));
  const ident::Record stuck = record(14.95, 100);
  const dsp::Check much = ident::left_out(stuck);
  CHECK(much.status == dsp::CheckStatus::warning);
  CHECK_THAT(much.message, Catch::Contains("segment.stick_speed_m_per_s") && Catch::Contains("fades into its noise"));
  ident::Record driven = stuck;
  driven.prepared.signals.signals.push_back({"f", "N", Eigen::VectorXd::LinSpaced(1000, -1.0, 1.0)});
  CHECK_THAT(ident::left_out(driven).message, !Catch::Contains("fades"));

  ident::Record ended = record(10.0, 1000);
  ended.prepared.signals.edge_samples = 200;
  ended.prepared.options.integrate_from_hz = 0.1;
  ended.prepared.channels = {{.name = "x", .role = dsp::Role::x}};
  ended.prepared.options.cutoff_hz = 4.0;
  ended.prepared.intermediate.sample_rate_hz = 100.0;
  CHECK_THAT(ident::left_out(ended).message, Catch::Contains("prepare.cutoff_hz = 8"));
  ended.prepared.options.cutoff_hz = 40.0;  // no filter of this record reaches less far
  CHECK_THAT(ident::left_out(ended).message, Catch::Contains("longer record"));
  ended.prepared.channels = {{.name = "a", .role = dsp::Role::a}};
  CHECK_THAT(ident::left_out(ended).message, Catch::Contains("integrated above 0.1 Hz"));

  ident::Range low;
  low.spec.name = "low";
  low.regime = dsp::Regime::low;
  const auto scarce = ident::scarce_ranges({low}, {&stuck});
  REQUIRE(scarce.size() == 1);
  CHECK(scarce.front().recording == 0);
  CHECK_THAT(scarce.front().check.message, Catch::Contains("range low: 8 % of its time"));
  const ident::Record plenty = record(14.95, 900);
  CHECK(ident::scarce_ranges({low}, {&plenty}).empty());

  // A range of the second recording, of which the knock takes most, though its stops are longer.
  ident::Range knocked;
  knocked.spec.name = "knocked";
  knocked.spec.from_s = 9.0;
  knocked.spec.to_s = 50.0;
  knocked.recording = 2;
  const ident::Record knock = record(48.95, 500);
  const auto own = ident::scarce_ranges({knocked}, {&plenty, &knock});
  REQUIRE(own.size() == 1);
  CHECK(own.front().recording == 1);
  CHECK_THAT(own.front().check.message, Catch::Contains("lost to a knock") && Catch::EndsWith("segment.file"));
}

TEST_CASE("rows that the filters mix with a stop are of the stop", "[ident][record]") {
  ident::Record record{.prepared = dsp::prepare(on_a_moving_base(false), {.rate_hz = 50.0, .cutoff_hz = 20.0})};
  const double rate_hz = record.prepared.intermediate.sample_rate_hz;
  const auto at = [&](double t_s) { return static_cast<Eigen::Index>(t_s * rate_hz); };
  dsp::Segmentation given;
  given.segments = {{dsp::Regime::low, 0, at(40.0), {}},
                    {dsp::Regime::stick, at(40.0), at(50.0), {}},
                    {dsp::Regime::low, at(50.0), record.prepared.intermediate.num_samples(), {}}};
  ident::set_regimes(record, given);
  // Three periods of 20 Hz: 0.15 s.
  const auto regime = [&](double t_s) { return record.regimes[static_cast<std::size_t>(std::lround(t_s * 50.0))]; };
  CHECK(regime(39.8) == dsp::Regime::low);
  CHECK(regime(39.9) == dsp::Regime::stick);
  CHECK(regime(50.1) == dsp::Regime::stick);
  CHECK(regime(50.2) == dsp::Regime::low);
}

TEST_CASE("a payload that stands on the ground while its base moves is noticed", "[ident][record]") {
  const auto prepared = [](bool rests) { return dsp::prepare(on_a_moving_base(rests), {.rate_hz = 50.0}); };
  CHECK(is_said(ident::find_regimes(prepared(true)), "regime.ground"));
  CHECK_FALSE(is_said(ident::find_regimes(prepared(false)), "regime.ground"));
}
