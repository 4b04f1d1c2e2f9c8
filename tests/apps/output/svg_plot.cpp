#include "apps/output/svg_plot.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

using Eigen::VectorXd;
using Pixels = std::vector<std::pair<double, double>>;

TEST_CASE("ticks are round, inside the limits and not too many", "[apps][svg_plot]") {
  CHECK(apps::nice_ticks(0.0, 10.0, 5) == std::vector<double>{0, 2, 4, 6, 8, 10});
  CHECK(apps::nice_ticks(-0.13, 0.12, 6).size() == 5);  // -0.1, -0.05 ... 0.1
  for (const double scale : {1e-12, 3e-5, 0.7, 42.0, 8e9})
    for (const double shift : {-2.0, -0.3, 0.0, 5.0}) {
      const double low = scale * shift, high = scale * (shift + 1.0);
      const auto ticks = apps::nice_ticks(low, high, 6);
      CHECK(ticks.size() >= 2);
      CHECK(ticks.size() <= 7);
      CHECK(ticks.front() >= low - 1e-9 * scale);
      CHECK(ticks.back() <= high + 1e-9 * scale);
    }
  CHECK(apps::nice_ticks(1.0, 1.0, 5).empty());
}

TEST_CASE("thinning keeps the extremes of every pixel column", "[apps][svg_plot]") {
  Pixels dense;
  for (int i = 0; i < 100000; ++i) dense.emplace_back(i * 0.003, 50.0 + 40.0 * std::sin(i * 0.9));
  dense[54321].second = 99.0;  // one spike
  const auto few = apps::thinned(dense);
  CHECK(few.size() <= 4 * 301);
  double highest = 0.0;
  for (const auto& [x, y] : few) highest = std::max(highest, y);
  CHECK(highest == 99.0);
  CHECK(few.front() == dense.front());
  CHECK(few.back() == dense.back());
}

TEST_CASE("thinning a loop drops only what is closer than a third of a pixel", "[apps][svg_plot]") {
  Pixels loop;
  for (int i = 0; i <= 20000; ++i) loop.emplace_back(100.0 * std::cos(i * 1e-3), 100.0 * std::sin(i * 1e-3));
  const auto few = apps::thinned(loop);
  CHECK(few.size() < 7000);  // twenty radians of 100 pixels are 2000 pixels
  CHECK(few.size() > 4000);
  CHECK(few.back() == loop.back());
}

TEST_CASE("a figure is a whole document with its labels, escaped", "[apps][svg_plot]") {
  apps::PlotFigure figure;
  figure.title = "x < y & \"z\"";
  figure.caption = {"free-run NMSE 1.2e-5"};
  apps::PlotPanel panel{"panel", "time (s)", "x (m)", {}, {}, {}};
  panel.series.push_back({"true", VectorXd::LinSpaced(50, 0, 1), VectorXd::LinSpaced(50, -1, 1)});
  VectorXd broken = VectorXd::LinSpaced(50, 0, 1);
  broken(20) = std::numeric_limits<double>::quiet_NaN();
  panel.series.push_back({"identified", broken, broken, apps::PlotStyle::dashed, apps::PlotColour::vermilion});
  panel.series.push_back(
      {"points", VectorXd::Ones(1), VectorXd::Ones(1), apps::PlotStyle::points, apps::PlotColour::blue});
  figure.panels = {panel, panel, {"empty", "", "", {}, {}, {}}};
  const std::string svg = apps::to_svg(figure);
  CHECK(svg.starts_with("<svg xmlns="));
  CHECK(svg.ends_with("</svg>\n"));
  CHECK_THAT(svg, Catch::Contains("x &lt; y &amp; &quot;z&quot;"));
  CHECK_THAT(svg, Catch::Contains("free-run NMSE 1.2e-5") && Catch::Contains("stroke-dasharray"));
  CHECK(svg.find("nan") == std::string::npos);
  CHECK(svg == apps::to_svg(figure));
}

TEST_CASE("a legend is where it hides least", "[apps][svg_plot]") {
  const auto legend_at = [](const VectorXd& y) {
    apps::PlotFigure figure;
    figure.panels = {{"", "", "", {{"a curve", VectorXd::LinSpaced(50, 0, 1), y}}, {}, {}}};
    const std::string svg = apps::to_svg(figure);
    const auto at = svg.rfind("<rect x=\"");
    return std::stod(svg.substr(at + 9));
  };
  const VectorXd rising = VectorXd::LinSpaced(50, 0, 1);
  CHECK(legend_at(rising) < 150.0);
  CHECK(legend_at(rising.reverse()) > 250.0);
}

TEST_CASE("shading spans its interval and captions keep to the width", "[apps][svg_plot]") {
  apps::PlotPanel panel{"panel", "time (s)", "x (m)"};
  panel.series = {{"x", VectorXd::LinSpaced(11, 0.0, 10.0), VectorXd::LinSpaced(11, 0.0, 1.0)}};
  panel.x_limits = {0.0, 10.0};
  panel.spans = {{2.0, 7.0, "test"}, {9.9, 30.0, "too narrow for its name"}};
  apps::PlotFigure figure{.panels = {panel}, .columns = 1, .panel_width_px = 486.0, .id = "figure-"};
  std::string caption;
  for (int i = 0; i < 60; ++i) caption += "word ";
  figure.caption = {caption};
  const std::string svg = apps::to_svg(figure);
  CHECK_THAT(svg, Catch::Contains("<rect x=\"162.00\" y=\"40.00\" width=\"200.00\""));  // 82 px, then 40 px a second
  CHECK_THAT(svg, Catch::Contains(">test</text>") && !Catch::Contains("too narrow"));
  CHECK_THAT(svg, Catch::Contains("url(#figure-0)"));
  for (std::size_t at = svg.find(">word"); at != std::string::npos; at = svg.find(">word", at + 1))
    CHECK(svg.find('<', at) - at < 80);
}

TEST_CASE("what lies outside the limits is not in the file", "[apps][svg_plot]") {
  apps::PlotPanel panel{"", "t", "x"};
  panel.series = {{"", VectorXd::LinSpaced(100'001, 0.0, 1000.0), VectorXd::Random(100'001)}};
  panel.x_limits = {500.0, 501.0};
  CHECK(apps::to_svg({.panels = {panel}}).size() < 10'000);
}

TEST_CASE("the range of y is that of the points that the limits of x show", "[apps][svg_plot]") {
  apps::PlotPanel panel{"", "t", "x"};
  VectorXd spike = VectorXd::LinSpaced(1001, 0.0, 1.0);
  spike(900) = 1e6;
  panel.series = {{"", VectorXd::LinSpaced(1001, 0.0, 1000.0), spike}};
  CHECK_THAT(apps::to_svg({.panels = {panel}}), Catch::Contains(">1e+06</text>"));
  panel.x_limits = {0.0, 500.0};
  CHECK_THAT(apps::to_svg({.panels = {panel}}), !Catch::Contains("e+0") && Catch::Contains(">0.4</text>"));
}
