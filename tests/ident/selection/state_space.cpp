#include "ident/selection/state_space.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "dsp/prepare.hpp"
#include "ident/identify.hpp"

TEST_CASE("a state of x and v alone has no inputs, one with a recorded force or the time has", "[ident][state_space]") {
  constexpr double rate_hz = 50.0;
  constexpr Eigen::Index count = 3000;
  dsp::Recording recording{.name = "r", .sample_rate_hz = rate_hz};
  recording.channels = {{"x", dsp::Role::x, "m"}, {"force", dsp::Role::f, "N"}};
  recording.samples.resize(count, 2);
  std::mt19937 random(7);
  std::normal_distribution<double> white(0.0, 1e-4);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) / rate_hz;
    recording.samples.row(i) << std::sin(7.0 * t) + 0.3 * std::sin(11.0 * t) + white(random), std::cos(7.0 * t);
  }
  const ident::Record record{.prepared = dsp::prepare(recording, {.cutoff_hz = 10.0})};
  for (const auto& [terms, has_inputs] : {std::pair(std::vector<std::string>{"x", "v", "sgn(v)"}, false),
                                          std::pair(std::vector<std::string>{"x", "v", "f"}, true),
                                          std::pair(std::vector<std::string>{"x", "v", "sin(7*t)"}, true)}) {
    const auto ranges = ident::identify(record, {.order = 0, .terms = terms},
                                        {.methods = {ident::FastRvmOptions{}}, .free_run = false});
    CHECK(ranges.at(0).fits.at(0).size.has_inputs == has_inputs);
  }
}
