#include "dsp/samples/isolated_values.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "support/signals.hpp"

namespace test_samples_isolated_values {

namespace {

using Eigen::Index;

constexpr double rate_hz = 100.0;
const std::vector<dsp::Channel> displacement{{.name = "x", .role = dsp::Role::x, .unit = "m"}};
const std::vector<dsp::Channel> acceleration{{.name = "a", .role = dsp::Role::a, .unit = "m/s^2"}};

/// A sine of 1.8 Hz in noise of 1 % of it, rounded to 3 % where `step` says so.
dsp::FrameBlock motion(Index count, double step = 0.0) {
  const auto noise = support::gaussian(count, 5);
  dsp::FrameBlock frames(count, 1);
  for (Index i = 0; i < count; ++i) {
    const double x = std::sin(2 * std::numbers::pi * 1.8 * static_cast<double>(i) / rate_hz) + 0.01 * noise(i);
    frames(i, 0) = step > 0.0 ? step * std::round(x / step) : x;
  }
  return frames;
}

struct Found {
  std::vector<Index> missing;
  std::vector<dsp::Check> checks;
};

Found through(const dsp::FrameBlock& frames, const std::vector<dsp::Channel>& channels, Index block = 1000) {
  dsp::IsolatedValues isolated(channels, rate_hz);
  Found found;
  Index done = 0;
  const auto take = [&](const dsp::FrameBlock& some) {
    for (Index i = 0; i < some.rows(); ++i, ++done)
      if (std::isnan(some(i, 0)))
        found.missing.push_back(done);
      else
        CHECK(some(i, 0) == frames(done, 0));
  };
  for (Index first = 0; first < frames.rows(); first += block)
    take(isolated.push(frames.middleRows(first, std::min(block, frames.rows() - first))));
  take(isolated.finish());
  CHECK(done == frames.rows());
  found.checks = isolated.checks();
  return found;
}

}  // namespace

TEST_CASE("codes of a sensor that failed are missing values, whatever the blocks", "[dsp][isolated_values]") {
  const double step = GENERATE(0.0, 0.03), code = GENERATE(-9999.0, 65535.0, -20.0);
  dsp::FrameBlock frames = motion(10000, step);
  const std::vector<Index> where{0, 700, 701, 702, 720, 4095, 4096, 5000, 9999};
  for (const Index i : where) frames(i, 0) = code;
  for (const Index block : {1, 64, 4096, 10000}) {
    CAPTURE(step, code, block);
    const Found found = through(frames, displacement, block);
    CHECK(found.missing == where);
    REQUIRE(found.checks.size() == 1);
    CHECK(found.checks[0].value == 9.0);
  }
}

TEST_CASE("codes between values that move on are missing, however far the motion goes meanwhile",
          "[dsp][isolated_values]") {
  const double code = GENERATE(-9999.0, 9.9e37);
  dsp::FrameBlock frames(4000, 1);
  for (Index i = 0; i < frames.rows(); ++i)  // five decades of a decay: its first steps are far above the usual ones
    frames(i, 0) = 5.0 * std::exp(-3e-3 * static_cast<double>(i)) * std::cos(0.15 * static_cast<double>(i));
  const std::vector<Index> where{30, 31, 61, 500, 3000};
  for (const Index i : where) frames(i, 0) = code;
  CHECK(through(frames, displacement).missing == where);
}

TEST_CASE("what moves, rings or is struck has no isolated values", "[dsp][isolated_values]") {
  SECTION("motion, also coarse, and short records") {
    for (const double step : {0.0, 0.03, 0.5})
      for (const Index count : {1, 2, 3, 40, 10000}) CHECK(through(motion(count, step), displacement).missing.empty());
  }
  SECTION("a ring-down from rest, sampled three times a period") {
    dsp::FrameBlock frames = 1e-3 * motion(2000);
    for (Index i = 1000; i < 2000; ++i)
      frames(i, 0) +=
          5.0 * std::exp(-0.05 * static_cast<double>(i - 1000)) * std::sin(2.1 * static_cast<double>(i - 999));
    CHECK(through(frames, displacement).missing.empty());
  }
  SECTION("four values in a row that stand out") {
    dsp::FrameBlock frames = motion(2000);
    frames.middleRows(900, 4).setConstant(50.0);
    CHECK(through(frames, displacement).missing.empty());
  }
  SECTION("blows on a force sensor, each of another height; one number again and again is a code") {
    dsp::FrameBlock frames = motion(5000);
    for (const Index i : {500, 1500, 2500}) frames(i, 0) = 40.0 + 1e-3 * static_cast<double>(i);
    CHECK(through(frames, acceleration).missing.empty());
    for (const Index i : {500, 1500, 2500}) frames(i, 0) = -999.0;
    CHECK(through(frames, acceleration).missing.size() == 3);
  }
}

}  // namespace test_samples_isolated_values
