#include "apps/config/inputs.hpp"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "apps/config/recording_name.hpp"
#include "dsp/values/faults.hpp"
#include "support/scratch.hpp"

namespace {

/// A displacement of up to `highest_hz`, 60 s at 400 Hz, beside noise of a ten-thousandth.
std::string motion(double highest_hz) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 1e-7);
  std::string text = "t,disp_m\n";
  for (int i = 0; i < 24'000; ++i) {
    const double t = i / 400.0, f_hz = 0.3 * highest_hz + 0.7 * highest_hz * t / 60.0;
    text += fmt::format("{:.4f},{:.9f}\n", t, 1e-3 * std::sin(2.0 * std::numbers::pi * f_hz * t / 2.0) + noise(random));
  }
  return text;
}

apps::Config config_of(const std::vector<std::filesystem::path>& files) {
  apps::Config config;
  for (const auto& file : files) config.recordings.push_back({.file = file});
  apps::name_recordings(config);
  return config;
}

}  // namespace

TEST_CASE("the band that is chosen holds the fastest motion of all recordings", "[apps][inputs]") {
  const support::Scratch folder;
  apps::Console silent({.verbosity = -1});
  const auto slow = folder.file("slow.csv", motion(5.0)), fast = folder.file("fast.csv", motion(15.0));
  const auto chosen_hz = [&](apps::Config config) {
    apps::choose_band(config, 0, silent);
    return config.prepare.cutoff_hz;
  };
  const double slow_hz = chosen_hz(config_of({slow})), fast_hz = chosen_hz(config_of({fast}));
  CHECK(slow_hz > 5.0);
  CHECK(slow_hz < fast_hz);
  CHECK(fast_hz > 15.0);
  CHECK(fast_hz < 100.0);
  CHECK(chosen_hz(config_of({slow, fast})) == fast_hz);
  apps::Config given = config_of({slow});
  given.prepare.cutoff_hz = 50.0;
  CHECK(chosen_hz(given) == 50.0);
}

TEST_CASE("where no band of a motion was found there is no lower cut-off either", "[apps][inputs]") {
  CHECK_FALSE(apps::cutoff_below(3.0, {{.sample_rate_hz = 100.0, .motion = {}}}));
}

TEST_CASE("what is wrong with each of several recordings is said at once", "[apps][inputs]") {
  const support::Scratch folder;
  apps::Console silent({.verbosity = -1});
  const auto good = folder.file("good.csv", motion(5.0)), bare = folder.file("bare.csv", "disp_m\n1\n2\n"),
             cut = folder.file("cut.csv", "t,disp_m\n0,1\n1,2\n2\n3,1\n");
  std::vector<std::string> names;
  try {
    (void)apps::prepare_inputs(config_of({bare, good, cut}), 0, 1, silent);
  } catch (const dsp::SeveralFaults& faults) {
    for (const dsp::Fault& fault : faults.all()) names.push_back(fault.name());
  }
  CHECK(names == std::vector<std::string>{"rate.missing", "table.ragged"});
}
