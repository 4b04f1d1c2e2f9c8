#include "sim/noise.hpp"

#include <catch2/catch.hpp>
#include <vector>

TEST_CASE("the noise is the same on every machine", "[sim][noise]") {
  const sim::Noise noise(1, 10);
  const double expected[] = {-0.170202749165, 0.501913107047, 0.0361284407, -0.59502246812};
  for (std::uint64_t i = 0; i < 4; ++i) CHECK(noise.at(i) == Approx(expected[i]).margin(1e-12));
  CHECK(sim::splitmix64(0) == 0xE220A8397B1DCDAFu);  // first output of the published generator from state 0
}

TEST_CASE("both kinds of noise are white with mean 0 and standard deviation 1", "[sim][noise]") {
  const int count = 200000;
  for (const bool normal : {false, true}) {
    const sim::Noise noise(7, 3), other(7, 4);
    double mean = 0.0, square = 0.0, fourth = 0.0, neighbour = 0.0, across = 0.0, last = 0.0;
    for (int i = 0; i < count; ++i) {
      const auto n = static_cast<std::uint64_t>(i);
      const double value = normal ? noise.normal(n) : noise.at(n);
      mean += value / count;
      square += value * value / count;
      fourth += value * value * value * value / count;
      neighbour += value * last / count;
      across += value * (normal ? other.normal(n) : other.at(n)) / count;
      last = value;
    }
    const double se = 1.0 / std::sqrt(count);
    CHECK(std::abs(mean) < 4 * se);
    CHECK(std::abs(square - 1.0) < 4 * std::sqrt(2.0) * se);
    // 3 for a normal variable; the sum of four uniform ones has 3 - 1.2 / 4. Its error: sqrt(96 / count).
    CHECK(std::abs(fourth - (normal ? 3.0 : 2.7)) < 4 * std::sqrt(96.0) * se);
    CHECK(std::abs(neighbour) < 4 * se);
    CHECK(std::abs(across) < 4 * se);
  }
}
