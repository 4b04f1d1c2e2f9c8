#include "apps/page/first_screen.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "apps/output/wrapped_text.hpp"
#include "apps/page/equation_display.hpp"
#include "support/program.hpp"

using support::bytes_of;
using support::Scratch;

namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::string many_words(int count) {
  std::string text;
  for (int i = 0; i < count; ++i) text += "word" + std::to_string(i) + " ";
  return text;
}

/// 60 s of x'' = -50 x - 0.8 v + f at 100 Hz, f the sum of two sines, to the last digit.
std::string driven_record() {
  std::string table = "t,y,f\n";
  const auto force = [](double t) { return 2.0 * std::sin(5.3 * t) + 1.3 * std::sin(9.1 * t + 1.0); };
  const auto rate = [&](double t, double x, double v) { return -50.0 * x - 0.8 * v + force(t); };
  constexpr double h = 0.001;
  double x = 0.01, v = 0.0;
  for (int i = 0; i < 60'000; ++i) {
    const double t = h * i;
    char row[96];
    if (i % 10 == 0) {
      std::snprintf(row, sizeof row, "%.2f,%.12g,%.12g\n", t, x, force(t));
      table += row;
    }
    const double a1 = rate(t, x, v), v2 = v + 0.5 * h * a1, a2 = rate(t + 0.5 * h, x + 0.5 * h * v, v2);
    const double v3 = v + 0.5 * h * a2, a3 = rate(t + 0.5 * h, x + 0.5 * h * v2, v3), v4 = v + h * a3;
    const double a4 = rate(t + h, x + h * v3, v4);
    x += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
    v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
  }
  return table;
}

}  // namespace

TEST_CASE("wrapping loses nothing but spaces, and no line is longer", "[apps][page]") {
  for (const std::string& text : {many_words(40), std::string(250, 'x'), std::string("a"), std::string()})
    for (const std::size_t most : {8u, 20u, 87u}) {
      std::string joined;
      for (const std::string& line : apps::wrapped(text, most)) {
        CHECK(line.size() <= most);
        joined += line;
      }
      std::string bare = text;
      for (std::string* one : {&joined, &bare}) one->erase(std::remove(one->begin(), one->end(), ' '), one->end());
      CHECK(joined == bare);
    }
  for (const std::string& line : apps::wrapped("\xC3\xA4\xC3\xA4\xC3\xA4\xC3\xA4", 3)) CHECK(line == "\xC3\xA4");
}

TEST_CASE("however much there is to say, it is one screen", "[apps][page]") {
  apps::FirstScreen screen;
  for (const char* label : {"equation", "which means", "trust", "mend", "data", "inputs"})
    screen.entries.push_back({label, {{many_words(200)}, {"key = \"value\"", true}}, 4});
  const auto lines = lines_of(apps::to_text(screen));
  CHECK(lines.size() <= 24);
  for (const std::string& line : lines) CHECK(line.size() <= 100);
  for (const auto& entry : screen.entries)
    CHECK(std::count_if(lines.begin(), lines.end(),
                        [&](const auto& line) { return line.starts_with(entry.label + " "); }) == 1);
}

TEST_CASE("what has little to say leaves its lines to the others", "[apps][page]") {
  apps::FirstScreen screen{{{"equation", {{"a = -x"}}, 6}, {"mend", {}, 2}}};
  for (int i = 0; i < 12; ++i) screen.entries[1].lines.push_back({"line " + std::to_string(i), true});
  const std::string text = apps::to_text(screen);
  CHECK_THAT(text, Catch::Contains("line 11") && !Catch::Contains("..."));
}

TEST_CASE("an equation is written with the digits it earns, in any notation", "[apps][page]") {
  ident::Model model;
  model.target = "a";
  model.terms = {{.name = "x", .mean = -50.0, .std = 0.1, .std_si = 0.42},
                 {.name = "x^3", .mean = -97431.0, .std = 1100.0},
                 {.name = "1", .mean = 0.5, .std = 0.04}};
  CHECK(apps::displayed_equation(model, ident::Notation::text) == "a = -50.0(4) x - 9.74(11)e+04 x^3 + 0.50(4)");
  CHECK(apps::displayed_equation(model, ident::Notation::latex) ==
        "\\ddot{x} = -50.0(4)\\,x - 9.74(11) \\cdot 10^{4}\\,x^{3} + 0.50(4)");
  const std::string mathml = apps::displayed_equation(model, ident::Notation::mathml);
  int open = 0;
  for (std::size_t at = 0; (at = mathml.find('<', at)) != std::string::npos; ++at) {
    if (mathml[mathml.find('>', at) - 1] != '/' && mathml.compare(at, 7, "<mspace") != 0)
      open += mathml[at + 1] == '/' ? -1 : 1;
    CHECK(open >= 0);
  }
  CHECK(open == 0);
  CHECK(apps::displayed_equation({.target = "a"}, ident::Notation::text) == "a = 0");
}

TEST_CASE("the lines to paste mend the run", "[apps][page]") {
  const Scratch folder;
  (void)folder.file("driven.csv", driven_record());
  (void)folder.file("driven.csv.toml",
                    "schema = 1\n[[channel]]\nname = \"clock\"\ncolumn = \"t\"\nrole = \"t\"\nunit = \"s\"\n"
                    "[[channel]]\nname = \"laser\"\ncolumn = \"y\"\nrole = \"y\"\nunit = \"m\"\n"
                    "[[channel]]\nname = \"force\"\ncolumn = \"f\"\nrole = \"f\"\nunit = \"N\"\n");
  const std::string config = "schema = 1\n[[recording]]\nfile = \"driven.csv\"\n";
  (void)folder.file("poor.toml", config + "[library]\norder = 0\nterms = [\"x\", \"v\"]\n");
  const auto poor = support::run(folder, "$ARDENT -q run poor.toml -o poor");
  CAPTURE(poor.out, poor.err);
  REQUIRE(poor.code == 0);
  CHECK_THAT(poor.out, Catch::Contains("recorded and not in it: f"));
  std::string lines;
  for (const std::string& line : lines_of(bytes_of(folder / "poor/equation.txt")))
    if (line.find("    [library]") != std::string::npos || line.find("    terms = ") != std::string::npos)
      lines += line.substr(line.find_first_not_of(' ')) + "\n";
  CHECK(lines == "[library]\nterms = [\"x\", \"v\", \"f\"]\n");
  (void)folder.file("rich.toml", config + "[library]\norder = 0\n" + lines.substr(lines.find('\n') + 1));
  const auto rich = support::run(folder, "$ARDENT -q run rich.toml -o rich");
  CAPTURE(rich.out);
  CHECK_THAT(rich.out, Catch::Contains("This equation describes the record") && Catch::Contains("in the equation: f"));
  CHECK_THAT(rich.out, Catch::Contains("natural frequency 1.125"));  // sqrt(50) / 2 pi
}

TEST_CASE("sine and cosine are proposed for an angle, and give the equation of a pendulum", "[apps][page]") {
  // 60 s of x'' = -40 sin(x) - 0.05 v from 1.6 rad down, 100 rows a second to 0.1 mrad, by fourth-order Runge-Kutta
  // steps.
  const Scratch folder;
  std::string table = "t_s,theta_rad\n";
  const auto rate = [](double x, double v) { return -40.0 * std::sin(x) - 0.05 * v; };
  constexpr double h = 0.001;
  double x = 1.6, v = 0.0;
  for (int i = 0; i < 60'000; ++i) {
    char row[64];
    std::snprintf(row, sizeof row, "%.2f,%.4f\n", h * i, x);  // an encoder's steps
    if (i % 10 == 0) table += row;
    const double a1 = rate(x, v), v2 = v + 0.5 * h * a1, a2 = rate(x + 0.5 * h * v, v2), v3 = v + 0.5 * h * a2,
                 a3 = rate(x + 0.5 * h * v2, v3), v4 = v + h * a3, a4 = rate(x + h * v3, v4);
    x += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
    v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
  }
  (void)folder.file("swing.csv", table);
  REQUIRE(support::run(folder, "$ARDENT -q run swing.csv -o first").code == 0);
  const std::string first = bytes_of(folder / "first/equation.txt");
  const std::string line = R"toml(terms = ["sgn(v)", "sin(x)", "cos(x)"])toml";
  CHECK_THAT(first, Catch::Contains("[library]") && Catch::Contains(line));
  (void)folder.file("second.toml", "schema = 1\n[[recording]]\nfile = \"swing.csv\"\n[library]\n" + line + "\n");
  REQUIRE(support::run(folder, "$ARDENT -q run second.toml -o second").code == 0);
  const std::string second = bytes_of(folder / "second/equation.txt");
  CHECK_THAT(second, Catch::Contains("sin(x)") && !Catch::Contains("x^3") && !Catch::Contains("cos(x)"));
}
