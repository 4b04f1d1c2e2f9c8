#include "ident/validate/modulation.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace test_modulation {

namespace {

constexpr double rate_hz = 20.0;
constexpr Eigen::Index num_samples = 1200;

Eigen::VectorXd white(std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  return Eigen::VectorXd::NullaryExpr(num_samples, [&] { return normal(random); });
}

/// With this x, the first 200 samples and a gap in the middle left out.
std::optional<double> found(const Eigen::VectorXd& x, const Eigen::VectorXd& residual, std::size_t recordings = 1) {
  dsp::Motion motion{.sample_rate_hz = rate_hz};
  motion.signals.push_back({.name = "x", .unit = "m", .values = x});
  const std::vector<ident::Columns> columns(recordings, {.name = "one", .signals = &motion});
  std::vector<ident::Row> rows;
  std::vector<double> values;
  for (Eigen::Index i = 200; i < num_samples; ++i) {
    if (i >= 600 && i < 650) continue;
    rows.push_back({recordings > 1 && i >= 650 ? 1u : 0u, i});
    values.push_back(residual(i));
  }
  return ident::modulation_rad_s(Eigen::VectorXd::Map(values.data(), std::ssize(values)), rows, columns);
}

}  // namespace

TEST_CASE("a stiffness that follows a clock shows its frequency under noise of its own size", "[modulation]") {
  constexpr double rad_s = 7.3, eighth_of_a_line = 2.0 * M_PI / 50.0 / 8.0;
  const Eigen::ArrayXd t = Eigen::ArrayXd::LinSpaced(num_samples, 0.0, num_samples - 1.0) / rate_hz;
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    const Eigen::VectorXd x = white(seed);
    const Eigen::VectorXd residual = x.array() * (rad_s * t + 0.1 * seed).cos() + white(100 + seed).array();
    const std::optional<double> here = found(x, residual);
    REQUIRE(here.has_value());
    CHECK(std::abs(*here - rad_s) < 2.0 * eighth_of_a_line);  // an eighth of its place on the grid, and noise
    CHECK_FALSE(found(x, residual, 2).has_value());           // of two recordings each has its own clock
  }
}

TEST_CASE("white noise shows none", "[modulation]") {
  int shown = 0;
  for (std::uint32_t seed = 1; seed <= 200; ++seed) shown += found(white(seed), white(1000 + seed)).has_value();
  CHECK(shown <= 2);  // once in a thousand; three of two hundred once in a thousand
}

}  // namespace test_modulation
