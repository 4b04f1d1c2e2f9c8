#include "dsp/prepare.hpp"

#include <catch2/catch.hpp>

#include "support/signals.hpp"

namespace {
dsp::Recording recording(double rate_hz, Eigen::Index n) {
  dsp::Recording result{.name = "made up", .sample_rate_hz = rate_hz};
  result.channels = {{.name = "top", .role = dsp::Role::y, .unit = "m"},
                     {.name = "base", .role = dsp::Role::r, .unit = "m"}};
  result.samples.resize(n, 2);
  const support::SweptHarmonics payload, base{.start_hz = 1.2, .sweep_hz_per_s = 1e-3, .amplitudes = {4e-3, 1e-4}};
  for (Eigen::Index i = 0; i < n; ++i) {
    result.samples(i, 0) = payload.at(static_cast<double>(i) / rate_hz).x;
    result.samples(i, 1) = base.at(static_cast<double>(i) / rate_hz).x;
  }
  return result;
}
}  // namespace

TEST_CASE("left-out options are filled in from the rates", "[dsp][prepare]") {
  const auto own = dsp::resolved({}, 250.0);
  CHECK(own.rate_hz == 250.0);
  CHECK(own.cutoff_hz == 100.0);
  CHECK(own.rolloff_hz == Approx(78.125));
  CHECK(own.state_cutoff_hz == Approx(122.5));  // as far as the rate allows
  const auto narrow = dsp::resolved({.cutoff_hz = 30.0}, 250.0);
  CHECK(narrow.state_cutoff_hz == Approx(30.0 * 20.0 / 10.24));
  CHECK(narrow.state_rolloff_hz == Approx(0.64 * narrow.state_cutoff_hz));
}

TEST_CASE("frequencies that do not fit each other are refused by name", "[dsp][prepare]") {
  const auto name_of = [](const dsp::PrepareOptions& options) {
    try {
      (void)dsp::resolved(options, 250.0);
    } catch (const dsp::Fault& fault) {
      CHECK(fault.kind() == dsp::FaultKind::usage);
      return fault.name();
    }
    return std::string();
  };
  CHECK(name_of({.rate_hz = 300.0}) == "prepare.rate");
  CHECK(name_of({.rate_hz = -1.0}) == "prepare.rate");
  CHECK(name_of({.cutoff_hz = 125.0}) == "prepare.cutoff");
  CHECK(name_of({.cutoff_hz = 20.0, .rolloff_hz = 20.0}) == "prepare.rolloff");
  CHECK(name_of({.cutoff_hz = 20.0, .state_cutoff_hz = 19.0}) == "prepare.state_cutoff");
  CHECK(name_of({.cutoff_hz = 20.0, .state_cutoff_hz = 30.0, .state_rolloff_hz = 30.0}) == "prepare.state_rolloff");
}

TEST_CASE("signals are the bus through the column filter, or filtered before they are formed", "[dsp][prepare]") {
  const auto record = recording(64.0, 3000);
  const auto matched = dsp::prepare(record, {.cutoff_hz = 12.0});
  for (const auto& signal : matched.signals.signals)
    if (signal.name != "t") CHECK(signal.values == matched.filter.apply(matched.bus.at(signal.name)));
  CHECK(matched.signals.at("t") == matched.bus.at("t"));

  // All content lies below the roll-off: both recipes see the same motion.
  const auto paper = dsp::prepare(record, {.recipe = dsp::Recipe::paper, .cutoff_hz = 12.0});
  for (const char* name : {"x", "v", "a", "ddr"})
    CHECK((paper.signals.at(name) - matched.signals.at(name)).cwiseAbs().maxCoeff() <=
          1e-3 * matched.signals.at(name).cwiseAbs().maxCoeff());
}

TEST_CASE("bad stretches are excluded with the reach of the filters, edges are counted", "[dsp][prepare]") {
  auto record = recording(64.0, 3000);
  record.bad = {{20.0, 21.0, "held by hand"}};
  const auto prepared = dsp::prepare(record, {.cutoff_hz = 12.0, .rolloff_hz = 10.0});
  REQUIRE(prepared.excluded.size() == 1);
  const double margin_s = 1.0 / 2.0 + 1.0 / (0.36 * prepared.options.state_cutoff_hz);
  CHECK(prepared.excluded[0].from_s == Approx(20.0 - margin_s));
  CHECK(prepared.excluded[0].to_s == Approx(21.0 + margin_s));
  CHECK(prepared.excluded[0].why == "held by hand");
  CHECK(prepared.signals.excluded[static_cast<std::size_t>(64 * 20)] == 1);
  CHECK(prepared.signals.excluded[static_cast<std::size_t>(64 * 19)] == 0);
  CHECK(prepared.bus.excluded == prepared.signals.excluded);
  CHECK(prepared.signals.edge_samples == 32);
  REQUIRE(prepared.checks.size() == 1);
  CHECK(prepared.checks[0].name == "prepare.edges");
  CHECK(prepared.checks[0].value == Approx(0.5));
}

TEST_CASE("the zero of the displacement moves on the bus and after the filter alike", "[dsp][prepare]") {
  for (const auto recipe : {dsp::Recipe::matched, dsp::Recipe::paper}) {
    auto prepared = dsp::prepare(recording(64.0, 2000), {.recipe = recipe, .cutoff_hz = 12.0});
    const auto before = prepared;
    dsp::set_displacement_zero(prepared, 1e-3);
    CHECK((prepared.bus.at("x") - before.bus.at("x")).array().mean() == Approx(-1e-3));
    CHECK((prepared.signals.at("x") - before.signals.at("x")).minCoeff() == Approx(-1e-3));
    CHECK(prepared.signals.at("y") == before.signals.at("y"));
  }
}

TEST_CASE("a handful of samples is refused", "[dsp][prepare]") {
  CHECK_THROWS_WITH(dsp::prepare(recording(64.0, 5), {}), Catch::Contains("5 samples"));
}
