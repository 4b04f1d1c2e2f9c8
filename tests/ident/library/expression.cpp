#include "ident/library/expression.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <string>

#include "support/fault.hpp"
#include "support/motion.hpp"

using Eigen::Index;
using Eigen::VectorXd;
using support::motion_of;

namespace {

const std::vector<std::string> names{"t", "x", "v", "a", "ddr"};

dsp::Motion sine_motion(double rate_hz, Index num_samples, double frequency_hz, double phase) {
  const double w = 2.0 * std::numbers::pi * frequency_hz;
  const VectorXd t = VectorXd::LinSpaced(num_samples, 0.0, static_cast<double>(num_samples - 1) / rate_hz);
  const auto angle = (w * t.array() + phase).eval();
  return motion_of(
      rate_hz,
      {{"t", t}, {"x", angle.sin()}, {"v", w * angle.cos()}, {"a", -w * w * angle.sin()}, {"ddr", angle.cos()}});
}

}  // namespace

TEST_CASE("an expression is the function a reader sees", "[ident][expression]") {
  const auto motion = sine_motion(100.0, 50, 1.3, 0.2);
  const VectorXd x = motion.at("x"), v = motion.at("v");
  const auto value = [&](const char* text) { return ident::Expression(text, names).evaluate(motion); };
  CHECK(value("x^2*v").isApprox((x.array().square() * v.array()).matrix(), 1e-15));
  CHECK(value("-x^2").isApprox(-x.array().square().matrix(), 1e-15));
  CHECK(value("abs(x)*v").isApprox((x.array().abs() * v.array()).matrix(), 1e-15));
  CHECK(value("exp(x)*tanh(v)").isApprox((x.array().exp() * v.array().tanh()).matrix(), 1e-15));
  CHECK(value("1") == VectorXd::Ones(50));
  const ident::Expression sum("v*x + ddr", names);
  CHECK(sum.signals() == std::vector<std::string>{"v", "x", "ddr"});
}

TEST_CASE("pointwise and column-wise evaluation agree", "[ident][expression]") {
  const auto motion = sine_motion(50.0, 40, 0.7, 1.0);
  const ident::Expression term("sgn(v)*x^2 + sgn(x - 0.1)*v", names);
  REQUIRE(term.switches() == std::vector<std::string>{"v", "x-0.1"});
  REQUIRE(term.signals() == std::vector<std::string>{"v", "x"});
  const VectorXd column = term.evaluate(motion);
  for (Index i = 0; i < 40; ++i) {
    const double values[] = {motion.at("v")(i), motion.at("x")(i)};
    const double signs[] = {values[0] > 0 ? 1.0 : -1.0, values[1] > 0.1 ? 1.0 : -1.0};
    CHECK(term.evaluate(values, signs) == Approx(column(i)).epsilon(1e-15));
  }
}

TEST_CASE("the band of a term is as many times its signals' as it has factors", "[ident][expression]") {
  const auto factor = [](const char* text) { return ident::Expression(text, names).band_factor(); };
  CHECK(factor("x^2*v") == 3.0);
  CHECK(factor("x + v^2") == 2.0);
  CHECK(factor("sgn(v)*x") == 1.0);
  CHECK(factor("x/v") == 4.0);  // 1/v as a function whose third harmonic counts
  CHECK(factor("tanh(x)") == 3.0);
}

TEST_CASE("conditions select rows", "[ident][expression]") {
  const auto motion = sine_motion(100.0, 100, 1.0, 0.0);
  const auto rows = ident::rows_where(ident::Expression("abs(v) > 2 && t < 0.5", names), motion);
  for (Index i = 0; i < 100; ++i)
    CHECK(bool(rows[static_cast<std::size_t>(i)]) == (std::abs(motion.at("v")(i)) > 2 && motion.at("t")(i) < 0.5));
  const auto none = ident::rows_where(ident::Expression("log(x - 10) > 0", names), motion);  // not a number: not a row
  CHECK(std::count(none.begin(), none.end(), 1) == 0);
}

TEST_CASE("texts that are no term are refused with their place", "[ident][expression]") {
  const auto refused = [](const std::string& text, const std::string& name, const std::string& part) {
    INFO(text.substr(0, 50));
    support::check_fault([&] { ident::Expression(text, names); }, dsp::FaultKind::usage, name, {part});
  };
  refused("x*+/v", "term.syntax", "position");
  refused("x**v", "term.syntax", "position 3");
  refused("x*w", "term.unknown_name", "position 3");
  refused("x = 5", "term.assignment", "position 3");
  refused("x, v", "term.syntax", "position 2");
  refused("", "term.syntax", "empty");
  refused("   ", "term.syntax", "empty");
  refused("sgn(v*sgn(x))", "term.syntax", "sgn is inside sgn");
  refused("system(x)", "term.unknown_name", "'system'");
  refused("sin()", "term.syntax", "position");
  refused(std::string(20000, '(') + "x" + std::string(20000, ')'), "term.too_long", "characters");
  refused(std::string(200, '(') + "x" + std::string(200, ')'), "term.too_long", "nested");
  std::string tower = "x";
  for (int i = 0; i < 200; ++i) tower += "^x";
  refused(tower, "term.too_long", "powers of powers");
  refused("x ? v : a", "term.syntax", "position");
  refused(std::string("x\x01"), "term.syntax", "");
}

TEST_CASE("a signal's name at the start of another word is not that signal", "[ident][expression]") {
  const std::vector<std::string> known{"a", "s", "t", "x1", "x10"};
  const auto signals = [&](const char* text) {
    const ident::Expression expression(text, known);
    return expression.signals();
  };
  CHECK(signals("abs(a)*a") == std::vector<std::string>{"a"});
  CHECK(signals("tanh(t)") == std::vector<std::string>{"t"});
  CHECK(signals("x10*x1") == std::vector<std::string>{"x10", "x1"});
  CHECK(signals("abs(a) > 1") == std::vector<std::string>{"a"});
  CHECK(signals("sin(s)") == std::vector<std::string>{"s"});
}
