#include "apps/text/rounded.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <string>

namespace {

struct Read {
  double value = 0.0, std = 0.0, unit = 0.0;  // unit: of the last digit
  int std_digits = 0;
};

/// What a reader takes from "-9.74(11)e+04".
Read read(const std::string& text) {
  const std::size_t open = text.find('('), close = text.find(')'), point = text.find('.');
  const int power = close + 1 < text.size() ? std::stoi(text.substr(close + 2)) : 0;
  const int decimals = point < open ? static_cast<int>(open - point) - 1 : 0;
  Read result;
  result.unit = std::pow(10.0, power - decimals);
  result.value = std::stod(text.substr(0, open)) * std::pow(10.0, power);
  result.std = std::stod(text.substr(open + 1, close - open - 1)) * result.unit;
  result.std_digits = static_cast<int>(close - open) - 1;
  return result;
}

}  // namespace

TEST_CASE("a value has the digits that its standard deviation earns", "[apps][page]") {
  CHECK(apps::with_uncertainty(-50.0, 0.42) == "-50.0(4)");
  CHECK(apps::with_uncertainty(-50.0, 0.2) == "-50.00(20)");
  CHECK(apps::with_uncertainty(0.07971, 0.0012) == "0.0797(12)");
  CHECK(apps::with_uncertainty(-97431.0, 1100.0) == "-9.74(11)e+04");
  CHECK(apps::with_uncertainty(1.0, 9.96) == "1(10)");
  CHECK(apps::with_uncertainty(0.001, 3.0) == "0.0(30)");
  CHECK(apps::with_uncertainty(-0.0001, 0.5) == "0.0(5)");
  CHECK(apps::with_uncertainty(1.234e-7, 5e-10) == "1.234(5)e-07");
  CHECK(apps::with_uncertainty(2.0 / 3.0, std::nan("")) == "0.667");
  CHECK(apps::with_uncertainty(2.0 / 3.0, 0.0) == "0.666667");
  CHECK(apps::with_uncertainty(std::nan(""), 1.0) == "not known");
}

TEST_CASE("what is printed is within half a unit of its last digit of what was found", "[apps][page]") {
  std::mt19937_64 draw(7);
  std::uniform_real_distribution<double> exponent(-9.0, 9.0), relative(-6.0, 1.0), sign(-1.0, 1.0);
  for (int i = 0; i < 20'000; ++i) {
    const double value = std::copysign(std::pow(10.0, exponent(draw)), sign(draw));
    const double std = std::abs(value) * std::pow(10.0, relative(draw));
    const std::string text = apps::with_uncertainty(value, std);
    const Read shown = read(text);
    CAPTURE(value, std, text);
    REQUIRE(std::abs(shown.value - value) <= 0.5 * shown.unit * (1.0 + 1e-6));
    REQUIRE(std::abs(shown.std - std) <= 0.5 * shown.unit * (1.0 + 1e-6));
    REQUIRE(std::abs(shown.std / std - 1.0) < 0.15);  // a seventh at most
    REQUIRE(shown.std_digits <= 2);
    REQUIRE((shown.std_digits == 2) == (shown.std / shown.unit > 9.5));
  }
}
