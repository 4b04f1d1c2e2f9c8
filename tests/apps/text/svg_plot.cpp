#include "apps/text/svg_plot.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
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

namespace {

/// The corners of the first line of an SVG of one panel, in pixels.
Pixels corners(const std::string& svg) {
  Pixels found;
  std::size_t at = svg.find("<path d=\"M", svg.find("<clipPath")) + 9;
  const std::string path = svg.substr(at, svg.find('"', at) - at);
  for (at = 0; at != std::string::npos; at = path.find_first_of("ML", at + 1)) {
    auto& [x, y] = found.emplace_back();
    REQUIRE(std::sscanf(path.c_str() + at + 1, "%lf %lf", &x, &y) == 2);
  }
  return found;
}

}  // namespace

TEST_CASE("a logarithmic axis has equal room for equal ratios", "[apps][svg_plot]") {
  apps::PlotFigure figure;
  figure.panels = {{"", "f", "p", {{"", Eigen::Vector4d(0.1, 1.0, 10.0, 100.0), Eigen::Vector4d(0.0, 1.0, 2.0, 3.0)}}}};
  figure.panels.front().x_log = true;
  const Pixels line = corners(apps::to_svg(figure));
  REQUIRE(line.size() == 4);
  for (std::size_t i = 1; i < 4; ++i)
    CHECK(line[i].first - line[i - 1].first == Approx((line[3].first - line[0].first) / 3.0).margin(0.02));
  CHECK(apps::log_ticks(0.5, 20.0, 7) == std::vector<double>{0.5, 1, 2, 5, 10, 20});
  CHECK(apps::log_ticks(0.03, 3000.0, 7) == std::vector<double>{0.1, 1, 10, 100, 1000});
  CHECK(apps::log_ticks(1.1, 1.7, 7) == apps::nice_ticks(1.1, 1.7, 7));
  for (const double low : {3e-4, 0.7, 12.0})
    for (const double ratio : {1.01, 3.0, 40.0, 1e5, 1e9}) {
      const auto ticks = apps::log_ticks(low, low * ratio, 7);
      CHECK(ticks.size() >= 2);
      CHECK(ticks.size() <= 8);
      CHECK(std::is_sorted(ticks.begin(), ticks.end()));
      CHECK(ticks.front() >= low * (1.0 - 1e-9));
      CHECK(ticks.back() <= low * ratio * (1.0 + 1e-9));
    }
}

TEST_CASE("thinning keeps the extremes of every pixel column", "[apps][svg_plot]") {
  constexpr Eigen::Index n = 100'000;
  VectorXd dense = VectorXd::LinSpaced(n, 0.0, 0.9 * n).array().sin();
  dense(54'321) = 2.0;  // one spike
  apps::PlotPanel panel{"", "t", "x", {{"", VectorXd::LinSpaced(n, 0.0, 1.0), dense}}};
  panel.x_limits = {0.0, 1.0};
  panel.y_limits = {-1.0, 2.0};
  const Pixels few = corners(apps::to_svg({.panels = {panel}, .columns = 1}));
  const double width = few.back().first - few.front().first;
  CHECK(static_cast<double>(few.size()) <= 2.0 * width + 4.0);
  double highest = 1e9, lowest = 0.0;
  for (const auto& [x, y] : few) highest = std::min(highest, y), lowest = std::max(lowest, y);
  const auto spike = std::find_if(few.begin(), few.end(), [&](const auto& corner) { return corner.second == highest; });
  CHECK(spike->first - few.front().first == Approx(0.54321 * width).margin(1.0));
  for (std::size_t i = 0; i + 1 < few.size(); ++i)  // each column goes from one extreme of the sine to the other
    CHECK(std::abs(few[i + 1].second - few[i].second) <= 1.001 * (lowest - highest));
  const auto third = (lowest - highest) / 3.0;  // of a unit
  std::size_t low = 0;
  for (const auto& [x, y] : few) low += std::abs(y - lowest) < 0.02 * third;
  CHECK(static_cast<double>(low) > 0.9 * width);
}

TEST_CASE("thinning a loop drops only what is closer than a third of a pixel", "[apps][svg_plot]") {
  constexpr Eigen::Index n = 20'001;
  const VectorXd angle = VectorXd::LinSpaced(n, 0.0, 20.0);
  apps::PlotPanel panel{"", "x", "y", {{"", angle.array().cos(), angle.array().sin()}}};
  panel.x_limits = panel.y_limits = {-1.0, 1.0};
  const Pixels few = corners(apps::to_svg({.panels = {panel}, .columns = 1}));
  double length = 0.0;
  for (std::size_t i = 1; i < few.size(); ++i)
    length += std::hypot(few[i].first - few[i - 1].first, few[i].second - few[i - 1].second);
  CHECK(few.size() > 2000);
  CHECK(static_cast<double>(few.size()) <= 1.0 + length / 0.32);
  for (std::size_t i = 1; i + 1 < few.size(); ++i)  // corners have two decimals
    CHECK(std::hypot(few[i].first - few[i - 1].first, few[i].second - few[i - 1].second) >= 0.32);
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
  apps::PlotFigure figure{.panels = {panel}, .columns = 1, .panel_width_px = 486.0, .name = "figure"};
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
