// Derivatives, comparison of expressions, switches and units: what is read off the tree.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "ident/library/expression.hpp"
#include "ident/library/library.hpp"
#include "support/motion.hpp"
#include "support/random_tree.hpp"

namespace test_library_expression_derivative {

using ident::Expression;
using ident::Notation;

namespace {

const std::vector<std::string> names{"t", "x", "v", "a", "ddr"};

std::string slope(const std::string& text, const std::string& signal) {
  return Expression(text, names).derivative(signal).print(Notation::text);
}

/// With the signs of its own switches; `point` in the order x, v, ddr.
double value(const Expression& expression, const std::array<double, 3>& point) {
  std::vector<double> values, signs;
  for (const std::string& name : expression.signals()) values.push_back(point[name == "x" ? 0 : name == "v" ? 1 : 2]);
  for (const std::string& text : expression.switches()) signs.push_back(ident::sign(value(Expression(text), point)));
  return expression.evaluate(values.data(), signs.data());
}

}  // namespace

TEST_CASE("derivatives read as a person would write them", "[ident][expression]") {
  CHECK(slope("x^3", "x") == "3*x^2");
  CHECK(slope("x^2*v", "x") == "2*x*v");
  CHECK(slope("x^2*v", "v") == "x^2");
  CHECK(slope("x", "x") == "1");
  CHECK(slope("x", "v") == "0");
  CHECK(slope("-2500*x - 3*v + 7", "x") == "-2500");
  CHECK(slope("abs(x)*v", "x") == "sgn(x)*v");
  CHECK(slope("sgn(v)*v^2", "v") == "2*sgn(v)*v");
  CHECK(slope("sin(2*x)", "x") == "2*cos(2*x)");
  CHECK(slope("exp(-x^2)", "x") == "-2*exp(-x^2)*x");
  CHECK(slope("log(x)", "x") == "1/x");
  CHECK(slope("sqrt(x)", "x") == "0.5/sqrt(x)");
  CHECK(slope("tanh(v)", "v") == "1-tanh(v)^2");
  CHECK(slope("x/v^2", "v") == "-2*x/v^3");
  CHECK(slope("(x^2+x)*v", "x") == "(2*x+1)*v");
  CHECK(slope("x^v", "v") == "x^v*log(x)");  // exists where the base is positive
  CHECK(slope("x^x", "x") == "x^x*(log(x)+1)");
  CHECK(slope("v > 0 && x < 1", "x") == "0");
}

TEST_CASE("derivatives are those of central differences", "[ident][expression][property]") {
  support::RandomTree random(7, support::RandomTree::Kind::smooth);
  constexpr double step = 1e-4;
  int compared = 0, nonzero = 0, infinite = 0;
  for (int k = 0; k < 3000; ++k) {
    const Expression expression(ident::print_tree(*random(1 + k % 5), Notation::text));
    const std::array<double, 3> at{random.uniform(0.2, 2.0), random.uniform(-2.0, 2.0), random.uniform(-2.0, 2.0)};
    for (int i = 0; i < 3; ++i) {
      const auto shifted = [&](double by) {
        auto point = at;
        point[static_cast<std::size_t>(i)] += by;
        return value(expression, point);
      };
      const double narrow = (shifted(step) - shifted(-step)) / (2 * step),
                   wide = (shifted(2 * step) - shifted(-2 * step)) / (4 * step);
      const ident::Expression derivative = expression.derivative(i == 0 ? "x" : i == 1 ? "v" : "ddr");
      const double found = value(derivative, at);
      const double size = std::abs(shifted(0.0)) + std::abs(shifted(2 * step)) + std::abs(shifted(-2 * step));
      // The error of the narrow difference is a third of how far the wide one is off, and its rounding; where the two
      // are far apart (a pole, a kink) they say nothing.
      const double tolerance = std::abs(narrow - wide) + 1e-14 * size / step + 1e-9;
      if (!std::isfinite(narrow) || !std::isfinite(wide) || tolerance > 1e-2 * (1.0 + std::abs(narrow))) continue;
      ++compared;
      nonzero += narrow != 0.0;
      INFO(expression.text() << " by "
                             << "xvd"[i] << " at " << at[0] << " " << at[1] << " " << at[2] << ": "
                             << derivative.text());
      if (std::isnan(found))
        ++infinite;
      else if (!(std::abs(found - narrow) <= tolerance))
        CHECK(found == narrow);
    }
  }
  CHECK(compared > 2000);
  CHECK(infinite < compared / 200);  // within finite ones there are parts such as 1/(1/(x-x))
  CHECK(nonzero > 1000);
}

TEST_CASE("expressions are compared by what they are, not by how they are written", "[ident][expression]") {
  const auto ratio = [](const char* a, const char* b) { return Expression(a).ratio_to(Expression(b)); };
  for (const auto& [a, b] : std::vector<std::pair<const char*, const char*>>{{"x*v", "v*x"},
                                                                             {"x+v", "v+x"},
                                                                             {"a", "a+0"},
                                                                             {"a", "1*a"},
                                                                             {"a", "a^1"},
                                                                             {"a", "-(-a)"},
                                                                             {"x*x", "x^2"},
                                                                             {"x^2*v/x", "x*v"},
                                                                             {"2*(x+v)", "2*v+2*x"},
                                                                             {"(2*x+1)*v", "2*v*(x+0.5)"},
                                                                             {"x^(1+1)", "x^2"},
                                                                             {"sqrt(x)", "x^0.5"},
                                                                             {"abs(-x)", "abs(x)"},
                                                                             {"abs(2*x)", "2*abs(x)"},
                                                                             {"sgn(-v)", "-sgn(v)"},
                                                                             {"cos(v-x)", "cos(x-v)"},
                                                                             {"x > v", "v < x"},
                                                                             {"1/3*x", "x/3"},
                                                                             {"0*x", "0"}}) {
    CAPTURE(a, b);
    REQUIRE(ratio(a, b));
    CHECK(*ratio(a, b) == Approx(1.0).epsilon(1e-15));
  }
  CHECK(*ratio("2*a", "a") == 2.0);
  CHECK(*ratio("-a/4", "a") == -0.25);
  CHECK(*ratio("3*x+6*v", "x+2*v") == 3.0);
  for (const auto& [a, b] : std::vector<std::pair<const char*, const char*>>{{"x", "v"},
                                                                             {"x", "x^2"},
                                                                             {"x+v", "x-v"},
                                                                             {"abs(x)", "x"},
                                                                             {"sin(2*x)", "2*sin(x)"},
                                                                             {"x < v", "x <= v"},
                                                                             {"x", "0*x"},
                                                                             {"sqrt(-x)", "sqrt(x)"},
                                                                             {"sqrt(x^2)", "x"},
                                                                             {"cos(0*x)", "1"},
                                                                             {"x^v", "v^x"}}) {
    CAPTURE(a, b);
    CHECK_FALSE(ratio(a, b));
  }
}

TEST_CASE("random expressions are themselves, however they are turned", "[ident][expression][property]") {
  support::RandomTree random(9, support::RandomTree::Kind::any);
  for (int k = 0; k < 500; ++k) {
    const auto one = random(k % 4), other = random(k % 3);
    const std::string a = ident::print_tree(*one, Notation::text), b = ident::print_tree(*other, Notation::text);
    const Expression forth(fmt::format("({})*2+({})/4", a, b)), back(fmt::format("0.25*({})-(-({}))*2", b, a));
    CAPTURE(forth.text(), back.text());
    const auto ratio = forth.ratio_to(back);
    REQUIRE(ratio);
    CHECK(*ratio == Approx(1.0).epsilon(1e-14));
  }
}

TEST_CASE("everything that switches is listed once with what passes zero there", "[ident][expression]") {
  const auto found = Expression("abs(x)*v + sgn(x-0.1)*abs(x) + (v > x)", names).all_switches();
  REQUIRE(found.size() == 3);
  CHECK(found[0].kind == ident::SwitchKind::magnitude);
  CHECK(found[0].argument.text() == "x");
  CHECK(found[1].kind == ident::SwitchKind::sign);
  CHECK(found[1].argument.text() == "x-0.1");
  CHECK(found[2].kind == ident::SwitchKind::comparison);
  CHECK(found[2].argument.text() == "v-x");
  CHECK(Expression("x^3", names).all_switches().empty());
}

TEST_CASE("units follow through the tree, or nothing is claimed", "[ident][expression]") {
  const Eigen::VectorXd some = Eigen::VectorXd::Ones(3);
  auto motion = support::motion_of(1.0, {{"t", some}, {"x", some}, {"v", some}, {"a", some}, {"f", some}});
  const auto unit = [&](const char* text) { return Expression(text).unit(motion); };
  CHECK(unit("x^2*v") == "m^3/s");
  CHECK(unit("a*x/v^2") == "1");
  CHECK(unit("-2*(x+3*x)") == "m");
  CHECK(unit("sqrt(x^2)*abs(v)") == "m^2/s");
  CHECK(unit("abs(x)^0.5*abs(x)^(1/2)").empty());  // each half by itself is no unit
  CHECK(unit("sgn(x-0.1)*v") == "m/s");
  CHECK(unit("sin(x/(v*t))*f") == "N");
  CHECK(unit("(v > 0)*x") == "m");
  CHECK(unit("x^-2") == "1/m^2");
  CHECK(unit("2^(x/x)") == "1");
  for (const char* text : {"x+v", "x-0.1", "sin(x)", "2^x", "x^v", "exp(v)", "w*x"}) CHECK(unit(text).empty());
  CHECK(unit("x^600/x^599") == "m");
  for (const char* text : {"x^1001", "x^600*x^600", "x/(abs(x)^600*abs(x)^600)", "1/(x^600*v^600)"}) {
    CAPTURE(text);
    CHECK(unit(text).empty());  // no power that is worth printing
  }
  CHECK(ident::coefficient_unit("m/s^2", "m^600") == "1/(m^599*s^2)");
  for (const char* far : {"m^-1000", "m^1002", "m^-2147483648", "m^2147483647*m^2147483647", "1/m^-2147483648"}) {
    CAPTURE(far);
    CHECK(ident::coefficient_unit("m/s^2", far).empty());
  }
  motion.signals[1].unit = "";
  CHECK(unit("x").empty());
}

}  // namespace test_library_expression_derivative
