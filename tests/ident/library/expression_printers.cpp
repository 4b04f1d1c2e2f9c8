#include "ident/library/expression_printers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include "ident/library/expression.hpp"
#include "ident/library/expression_parser.hpp"
#include "support/random_tree.hpp"
#include "support/scratch.hpp"

using ident::Expression;
using ident::Notation;

namespace {

ident::Tree read(const std::string& text) {
  return ident::parse_expression(
      text, [](std::string_view) { return true; }, "");
}

std::string printed(const std::string& text, Notation notation) {
  return Expression(text).print(notation);
}

constexpr int num_random = 300;
constexpr const char* at = "0.7, -1.3, 0.5";  // x, v, ddr

/// At the point above.
double value(const Expression& expression) {
  std::vector<double> values, signs;
  for (const std::string& name : expression.signals()) values.push_back(name == "x" ? 0.7 : name == "v" ? -1.3 : 0.5);
  for (const std::string& text : expression.switches()) signs.push_back(ident::sign(value(Expression(text))));
  return expression.evaluate(values.data(), signs.data());
}

/// Values of the random expressions as another language computes them beside ours; NaN: it refuses to, as Python
/// does to divide by zero.
void check_against(const std::vector<double>& found) {
  support::RandomTree random(11, support::RandomTree::Kind::any);
  REQUIRE(found.size() == num_random);
  int index = 0;
  for (const double theirs : found) {
    const Expression expression(ident::print_tree(*random(index++ % 5), Notation::text));
    CAPTURE(expression.text());
    const double ours = value(expression);  // not a number, where Python goes on with a complex one
    if (std::isfinite(theirs) && !std::isnan(ours)) CHECK(theirs == Approx(ours).epsilon(1e-12));
  }
  CHECK(std::count_if(found.begin(), found.end(), [](double theirs) { return std::isfinite(theirs); }) >
        num_random / 2);
}

std::vector<double> numbers_in(const std::filesystem::path& file) {
  std::vector<double> numbers;
  std::istringstream lines(support::bytes_of(file));
  for (std::string line; std::getline(lines, line);) numbers.push_back(std::strtod(line.c_str(), nullptr));
  return numbers;
}

}  // namespace

TEST_CASE("text reads back as the tree it was printed from", "[ident][expression][property]") {
  support::RandomTree random(3, support::RandomTree::Kind::any);
  for (int k = 0; k < 2000; ++k) {
    const auto tree = random(k % 6);
    const std::string text = ident::print_tree(*tree, Notation::text);
    CAPTURE(text);
    REQUIRE(ident::identical(*read(text), *tree));
  }
  support::RandomTree smooth(4, support::RandomTree::Kind::smooth);
  for (int k = 0; k < 500; ++k) {
    const Expression slope = Expression(ident::print_tree(*smooth(k % 5), Notation::text)).derivative("x");
    CAPTURE(slope.text());
    if (slope.text().find("inf") == std::string::npos && slope.text().find("nan") == std::string::npos)
      CHECK(Expression(slope.text()).print(Notation::text) == slope.text());
  }
}

TEST_CASE("each notation writes what its readers expect", "[ident][expression]") {
  CHECK(printed("-x^2*(v - 0.1)", Notation::text) == "-x^2*(v-0.1)");
  CHECK(printed("x - (v - a)", Notation::text) == "x-(v-a)");
  CHECK(printed("((x))*(v^2)", Notation::text) == "x*v^2");

  CHECK(printed("x^2*v", Notation::latex) == "x^{2} \\dot{x}");
  CHECK(printed("sgn(v)*ddr", Notation::latex) == "\\operatorname{sgn}(\\dot{x}) \\ddot{r}");
  CHECK(printed("abs(x)^-1.5", Notation::latex) == "\\left|x\\right|^{-1.5}");
  CHECK(printed("x/v^2", Notation::latex) == "\\frac{x}{\\dot{x}^{2}}");
  CHECK(printed("(x/v)^2", Notation::latex) == "\\left(\\frac{x}{\\dot{x}}\\right)^{2}");
  CHECK(printed("x^(1/3)", Notation::latex) == "x^{\\frac{1}{3}}");
  CHECK(printed("2*3*1e-05*sqrt(top_x)", Notation::latex) ==
        "2 \\cdot 3 \\cdot 1 \\cdot 10^{-5} \\sqrt{\\mathrm{top\\_x}}");
  CHECK(printed("v>=0", Notation::latex) == "\\dot{x} \\ge 0");

  CHECK(printed("x^2*v", Notation::mathml) ==
        "<mrow><msup><mi>x</mi><mn>2</mn></msup><mo>&#x2062;</mo><mover><mi>x</mi><mo>&#x2D9;</mo></mover></mrow>");

  CHECK(printed("2*x^2*sgn(v)", Notation::c) == "2.0*pow(x, 2.0)*(double)((v > 0.0) - (v < 0.0))");
  CHECK(printed("(v>0)*abs(x)", Notation::c) == "(double)(v > 0.0)*fabs(x)");
  CHECK(printed("x^2*sgn(v)/3", Notation::matlab) == "x.^2.*sign(v)./3");
  CHECK(printed("v!=0 && x<1", Notation::matlab) == "v ~= 0 & x < 1");
  CHECK(printed("x^2*tanh(v) - 1", Notation::python) == "x**2.0*np.tanh(v) - 1.0");
  CHECK(printed("(v>0 && x<1)*x", Notation::python) == "(1.0*(np.logical_and(v > 0.0, x < 1.0)))*x");
}

TEST_CASE("a factor behind a coefficient is in brackets where it would run into it", "[ident][expression]") {
  const auto factor = [](const char* text) { return Expression(text).print_as_factor(Notation::text); };
  CHECK(factor("x^3") == "x^3");
  CHECK(factor("x/v") == "x/v");
  CHECK(factor("(x+1)*v") == "(x+1)*v");
  CHECK(factor("x+x^3") == "(x+x^3)");
  CHECK(factor("-2^2*x^3") == "(-2^2*x^3)");
  CHECK(factor("2*x") == "(2*x)");
  CHECK(factor("v>0") == "(v>0)");
}

TEST_CASE("C code compiles and computes the same", "[ident][expression][property]") {
  if (std::system("command -v cc > /dev/null 2>&1") != 0) {
    WARN("skipped: no C compiler");
    return;
  }
  support::RandomTree random(11, support::RandomTree::Kind::any);
  std::string code = "#include <math.h>\n#include <stdio.h>\n";
  for (int k = 0; k < num_random; ++k)
    code += fmt::format("static double f{}(double x, double v, double ddr) {{ return {}; }}\n", k,
                        ident::print_tree(*random(k % 5), Notation::c));
  code += "int main(void) {\n";
  for (int k = 0; k < num_random; ++k) code += fmt::format("  printf(\"%.17g\\n\", f{}({}));\n", k, at);
  const support::Scratch folder;
  folder.file("f.c", code + "  return 0;\n}\n");
  const std::string in = "cd " + (folder / "").string();
  REQUIRE(std::system((in + " && cc -w -std=c99 f.c -o f -lm && ./f > out").c_str()) == 0);
  check_against(numbers_in(folder / "out"));
}

TEST_CASE("Python code computes the same", "[ident][expression][property]") {
  if (std::system("command -v python3 > /dev/null 2>&1") != 0) {
    WARN("skipped: no Python");
    return;
  }
  // numpy's names on single numbers, so that the test does not want numpy.
  std::string code =
      "import math\n"
      "def quiet(f):\n"
      "  def g(*a):\n"
      "    try: return f(*a)\n"
      "    except (ValueError, OverflowError, ZeroDivisionError, TypeError): return math.nan\n"
      "  return g\n"
      "class np:\n"
      "  abs = abs\n"
      "  sign = lambda g: (g > 0) - (g < 0)\n"
      "  sin, cos, exp = quiet(math.sin), quiet(math.cos), quiet(math.exp)\n"
      "  log, sqrt, tanh = quiet(math.log), quiet(math.sqrt), quiet(math.tanh)\n"
      "  logical_and = lambda g, h: bool(g) and bool(h)\n"
      "  logical_or = lambda g, h: bool(g) or bool(h)\n"
      "def show(f):\n"
      "  value = quiet(f)(" +
      std::string(at) +
      ")\n"
      "  print(repr(math.nan if isinstance(value, complex) else float(value)))\n";
  support::RandomTree random(11, support::RandomTree::Kind::any);
  for (int k = 0; k < num_random; ++k)
    code += fmt::format("show(lambda x, v, ddr: {})\n", ident::print_tree(*random(k % 5), Notation::python));
  const support::Scratch folder;
  folder.file("f.py", code);
  REQUIRE(std::system(("cd " + (folder / "").string() + " && python3 f.py > out").c_str()) == 0);
  check_against(numbers_in(folder / "out"));
}
