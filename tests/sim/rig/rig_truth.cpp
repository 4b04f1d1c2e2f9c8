#include "sim/rig/rig_truth.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

TEST_CASE("what is true of a test counts its times from the recording's beginning on", "[sim][rig_truth]") {
  const std::vector<std::pair<std::string, double>> settings{
      {"amplitude_mm", 24.0}, {"dwell_s", 9.0}, {"releases", 2.0}};
  const auto from = [&](double from_s) {
    return sim::rig_test({.programme = "decay", .settings = settings, .from_s = from_s, .duration_s = 18.0 - from_s});
  };
  std::vector<double> times_s;
  const auto take = [&](const sim::QzsState& state) { times_s.push_back(state.t_s); };
  const sim::RigTruth whole = sim::rig_truth(from(0.0)), late = sim::rig_truth(from(9.0), {.take = take});
  REQUIRE(whole.hands.size() == 2);
  REQUIRE(late.hands.size() == 1);
  CHECK(late.hands[0].from_s == whole.hands[1].from_s - 9.0);
  CHECK(late.hands[0].released_at_m == whole.hands[1].released_at_m);
  CHECK(late.num_events < whole.num_events);
  CHECK(late.regimes.front().from_s == 0.0);
  CHECK(late.regimes.back().to_s == Approx(9.0));
  REQUIRE(times_s.size() == 9 * sim::truth_rate_hz + 1);
  CHECK(times_s.front() == 9.0);
}

TEST_CASE("a caller may stop the truth of a test", "[sim][rig_truth]") {
  struct Stopped {};
  const auto stop = [](double) { throw Stopped(); };
  CHECK_THROWS_AS(sim::rig_truth(sim::rig_test({}), {.progress = stop}), Stopped);
}

TEST_CASE("a test that cannot be is refused", "[sim][rig_truth]") {
  for (const sim::RigTestOptions& options :
       {sim::RigTestOptions{.twin = "T9"}, sim::RigTestOptions{.programme = "sideways"},
        sim::RigTestOptions{.settings = {{"mass", 2.0}}}, sim::RigTestOptions{.from_s = -1.0},
        sim::RigTestOptions{.duration_s = 0.0}, sim::RigTestOptions{.rate_hz = 25.6},
        sim::RigTestOptions{.duration_s = 5.0, .raw = {.faults = {{.from_s = 6.0, .to_s = 7.0}}}}})
    CHECK_THROWS_AS(sim::rig_test(options), std::invalid_argument);
}
