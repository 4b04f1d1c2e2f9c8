#include "apps/text/svg_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/text/envelope.hpp"
#include "apps/text/html_writer.hpp"
#include "apps/text/wrapped_text.hpp"

namespace apps {
namespace {

using Eigen::Index;
using Pixel = std::pair<double, double>;
using Limits = std::pair<double, double>;

constexpr double margin_left = 72.0, margin_right = 14.0, margin_top = 30.0, margin_bottom = 46.0;
constexpr double title_height = 30.0, line_height = 18.0, panel_gap = 10.0;
constexpr int most_x_ticks = 7, most_y_ticks = 6;

const char* colour_of(PlotColour colour) {
  switch (colour) {
    case PlotColour::black:
      return "#000000";
    case PlotColour::vermilion:
      return "#d55e00";
    case PlotColour::blue:
      return "#0072b2";
    case PlotColour::green:
      return "#009e73";
    case PlotColour::orange:
      return "#e69f00";
    case PlotColour::purple:
      return "#cc79a7";
    case PlotColour::sky:
      return "#56b4e9";
  }
  return "#000000";
}

/// Of y: those of the points that the given limits of x show.
Limits limits_of(const PlotPanel& panel, Eigen::VectorXd PlotSeries::*values, const std::optional<Limits>& given) {
  if (given) return *given;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const PlotSeries& series : panel.series)
    for (Index i = 0; i < series.y.size(); ++i) {
      const bool shown =
          !panel.x_limits || (series.x(i) >= panel.x_limits->first && series.x(i) <= panel.x_limits->second);
      const double value = (series.*values)(i);
      if (shown && std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
    }
  if (!(low <= high)) return {0.0, 1.0};
  const double size = std::max(std::abs(low), std::abs(high));
  if (panel.x_log && values == &PlotSeries::x && low < high) return {low, high};
  const double margin = high - low > 1e-12 * size ? 0.04 * (high - low) : size > 0.0 ? 0.5 * size : 0.5;
  return {low - margin, high + margin};
}

// A tick's label with as many decimals as its step needs.
std::string tick_label(double value, double step) {
  const double size = std::max(std::abs(value), step);
  if (size >= 1e5 || step < 1e-4) return fmt::format("{:.4g}", std::abs(value) < 1e-9 * step ? 0.0 : value);
  const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step) + 1e-9)));
  const std::string text = fmt::format("{:.{}f}", value, decimals);
  return text.find_first_not_of("-0.") == std::string::npos ? text.substr(text.front() == '-' ? 1 : 0) : text;
}

/// The drawing area of a panel and the way from data to pixels.
struct Frame {
  double left, top, width, height;
  Limits x, y;
  bool x_log = false;
  [[nodiscard]] Pixel at(double px, double py) const {
    const double part =
        x_log ? std::log(px / x.first) / std::log(x.second / x.first) : (px - x.first) / (x.second - x.first);
    return {left + width * part, top + height * (1.0 - (py - y.first) / (y.second - y.first))};
  }
};

std::string text_element(double x, double y, const char* anchor, const std::string& text, const char* more = "") {
  return fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\" text-anchor=\"{}\"{}>{}</text>\n", x, y, anchor, more,
                     escaped_markup(text));
}

/// Where an axis has ticks, and what is written there.
struct Tick {
  double value = 0.0;
  std::string label;
};

std::vector<Tick> ticks_of(const Limits& limits, bool is_log, int most, const std::vector<std::string>& names) {
  std::vector<Tick> ticks;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (const auto value = static_cast<double>(i); value >= limits.first && value <= limits.second)
      ticks.push_back({value, names[i]});
  if (!names.empty()) return ticks;
  const std::vector<double> values = (is_log ? log_ticks : nice_ticks)(limits.first, limits.second, most);
  const double step = values.size() > 1 ? values[1] - values[0] : 1.0;
  for (const double value : values)
    ticks.push_back({value, is_log ? fmt::format("{:.6g}", value) : tick_label(value, step)});
  return ticks;
}

/// More than numbers at the left need.
double name_room(const PlotPanel& panel) {
  constexpr double letter_px = 6.6, of_numbers = 50.0;
  std::size_t longest = 0;
  for (const std::string& name : panel.y_names) longest = std::max(longest, name.size());
  return std::max(0.0, letter_px * static_cast<double>(longest) - of_numbers);
}

std::string axes(const PlotPanel& panel, const Frame& frame) {
  std::string out = fmt::format(
      "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"none\" stroke=\"#444444\"/>\n",
      frame.left, frame.top, frame.width, frame.height);
  const double bottom = frame.top + frame.height;
  for (const auto& [value, label] : ticks_of(frame.x, frame.x_log, most_x_ticks, panel.x_names)) {
    const double x = frame.at(value, frame.y.first).first;
    out += fmt::format("<path d=\"M{:.2f} {:.2f}V{:.2f}\" stroke=\"#dddddd\"/>\n", x, frame.top, bottom);
    out += text_element(x, bottom + 16.0, "middle", label);
  }
  for (const auto& [value, label] : ticks_of(frame.y, false, most_y_ticks, panel.y_names)) {
    const double y = frame.at(frame.x.first, value).second;
    out += fmt::format("<path d=\"M{:.2f} {:.2f}H{:.2f}\" stroke=\"#dddddd\"/>\n", frame.left, y,
                       frame.left + frame.width);
    out += text_element(frame.left - 6.0, y + 4.0, "end", label);
  }
  out += text_element(frame.left + 0.5 * frame.width, bottom + 36.0, "middle", panel.x_label);
  const double middle = frame.top + 0.5 * frame.height, label = frame.left - name_room(panel) - 56.0;
  out += text_element(label, middle, "middle", panel.y_label,
                      fmt::format(" transform=\"rotate(-90 {:.2f} {:.2f})\"", label, middle).c_str());
  out += text_element(frame.left + 0.5 * frame.width, frame.top - 9.0, "middle", panel.title, " font-weight=\"bold\"");
  return out;
}

std::string points(const PlotSeries& series, const Frame& frame) {
  std::string path;
  for (Index i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
    if (!std::isfinite(series.x(i)) || !std::isfinite(series.y(i))) continue;
    const auto [x, y] = frame.at(series.x(i), series.y(i));
    path += fmt::format("M{:.2f} {:.2f}h0", x, y);  // a round cap of no length is a dot
  }
  return path.empty() ? ""
                      : fmt::format("<path d=\"{}\" stroke=\"{}\" stroke-width=\"5\" stroke-linecap=\"round\"/>\n",
                                    path, colour_of(series.colour));
}

/// Those of a series that a frame shows, with one more on each side, as least and greatest value of each pixel column
/// where x ascends.
Envelope shown(const PlotSeries& series, const Frame& frame) {
  const Index n = std::min(series.x.size(), series.y.size());
  const auto x = series.x.head(n), y = series.y.head(n);
  if (!x.allFinite() || !std::is_sorted(x.begin(), x.end())) return {x, y};
  const auto first = std::max<Index>(0, std::lower_bound(x.begin(), x.end(), frame.x.first) - x.begin() - 1),
             last = std::min<Index>(n, std::upper_bound(x.begin(), x.end(), frame.x.second) - x.begin() + 1);
  return envelope(x.segment(first, last - first), y.segment(first, last - first),
                  2 * static_cast<Index>(std::ceil(frame.width)));
}

/// Of points nearer to the one before than this only the last is drawn.
constexpr double least_step_px = 0.33;

std::string line(const PlotSeries& series, const Frame& frame) {
  const auto [xs, ys] = shown(series, frame);
  std::string path;
  const auto is_point = [&, &x = xs, &y = ys](Index i) {
    return i < x.size() && std::isfinite(x(i)) && std::isfinite(y(i));
  };
  Pixel before{};
  bool drawn = false;  // the point before
  for (Index i = 0; i < xs.size(); ++i) {
    if (!is_point(i)) {
      drawn = false;
      continue;
    }
    const auto [x, y] = frame.at(xs(i), ys(i));
    if (drawn && is_point(i + 1) && std::hypot(x - before.first, y - before.second) < least_step_px) continue;
    path += fmt::format("{}{:.2f} {:.2f}", drawn ? "L" : "M", x, y);
    before = {x, y}, drawn = true;
  }
  if (path.empty()) return "";
  return fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"{} stroke-linejoin=\"round\"/>\n",
                     path, colour_of(series.colour), series.style == PlotStyle::dashed ? "1.6" : "1.3",
                     series.style == PlotStyle::dashed ? " stroke-dasharray=\"6 4\"" : "");
}

// Fraction of a panel's points, and of places on its lines, in a box; of long series every so many.
double covered(const PlotPanel& panel, const Frame& frame, double left, double top, double width, double height) {
  constexpr Index most = 2000, between = 8;
  double inside = 0.0;
  for (const PlotSeries& series : panel.series) {
    const Index n = std::min(series.x.size(), series.y.size()), stride = std::max<Index>(1, n / most);
    const bool is_line = series.style != PlotStyle::points;
    double hits = 0.0;
    for (Index i = 0; i < n; i += stride) {
      const Index next = is_line ? std::min(i + stride, n - 1) : i;
      const auto from = frame.at(series.x(i), series.y(i)), to = frame.at(series.x(next), series.y(next));
      for (Index k = 0; k < (is_line ? between : 1); ++k) {
        const double u = static_cast<double>(k) / static_cast<double>(between);
        const double x = std::lerp(from.first, to.first, u), y = std::lerp(from.second, to.second, u);
        hits += x >= left && x <= left + width && y >= top && y <= top + height;  // never where it is not finite
      }
    }
    if (n > 0) inside += hits / static_cast<double>(n);
  }
  return inside;
}

// In the corner where it hides least; of equals upper before lower, right before left.
std::string legend(const PlotPanel& panel, const Frame& frame) {
  std::size_t longest = 0;
  int entries = 0;
  for (const PlotSeries& series : panel.series) {
    longest = std::max(longest, series.label.size());
    entries += !series.label.empty();
  }
  if (entries == 0) return "";
  const double width = 44.0 + 6.6 * static_cast<double>(longest), height = 6.0 + 16.0 * entries;
  const double right = frame.left + frame.width - width - 6.0, low = frame.top + frame.height - height - 6.0;
  double left = right, y = frame.top + 6.0, least = std::numeric_limits<double>::infinity();
  for (const auto& [at_left, at_top] : {Pixel{right, frame.top + 6.0}, Pixel{frame.left + 6.0, frame.top + 6.0},
                                        Pixel{right, low}, Pixel{frame.left + 6.0, low}})
    if (const double hidden = covered(panel, frame, at_left, at_top, width, height); hidden < least)
      least = hidden, left = at_left, y = at_top;
  std::string out = fmt::format(
      "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"#ffffff\" fill-opacity=\"0.85\" "
      "stroke=\"#cccccc\"/>\n",
      left, y, width, height);
  for (const PlotSeries& series : panel.series) {
    if (series.label.empty()) continue;
    y += 16.0;
    const PlotSeries key{{}, Eigen::Vector2d(0.0, 1.0), Eigen::Vector2d::Zero(), series.style, series.colour};
    const Frame place{left + 6.0, y - 4.0, 24.0, 0.0, {0.0, 1.0}, {-1.0, 1.0}};
    out += series.style == PlotStyle::points ? points(key, place) : line(key, place);
    out += text_element(left + 36.0, y, "start", series.label);
  }
  return out;
}

/// Behind everything else.
std::string shading(const PlotPanel& panel, const Frame& frame) {
  constexpr double letter_px = 6.6;
  std::string out;
  for (const PlotSpan& span : panel.spans) {
    const double from = std::max(frame.left, frame.at(span.from, 0.0).first),
                 to = std::min(frame.left + frame.width, frame.at(span.to, 0.0).first);
    if (!(to > from)) continue;
    out += fmt::format(
        "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"{}\" fill-opacity=\"0.18\"/>\n",
        from, frame.top, to - from, frame.height, colour_of(span.colour));
    if (letter_px * static_cast<double>(span.label.size()) < to - from)
      out += text_element(0.5 * (from + to), frame.top + 13.0, "middle", span.label);
  }
  return out;
}

std::string panel_element(const PlotPanel& panel, const PlotFigure& figure, double left, double top, int number) {
  const double width = figure.panel_width_px, height = figure.panel_height_px;
  const double room = margin_left + name_room(panel);
  const Frame frame{left + room,
                    top + margin_top,
                    width - room - margin_right,
                    height - margin_top - margin_bottom,
                    limits_of(panel, &PlotSeries::x, panel.x_limits),
                    limits_of(panel, &PlotSeries::y, panel.y_limits),
                    panel.x_log};
  std::string out = shading(panel, frame) + axes(panel, frame);
  out += fmt::format(
      "<clipPath id=\"{0}\"><rect x=\"{1:.2f}\" y=\"{2:.2f}\" width=\"{3:.2f}\" height=\"{4:.2f}\"/></clipPath>\n"
      "<g clip-path=\"url(#{0})\">\n",
      figure.name + "-" + std::to_string(number), frame.left, frame.top, frame.width, frame.height);
  for (const PlotSeries& series : panel.series)
    out += series.style == PlotStyle::points ? points(series, frame) : line(series, frame);
  return out + "</g>\n" + legend(panel, frame);
}

}  // namespace

PlotSeries plot_series(std::string label, const std::vector<double>& x, const std::vector<double>& y, PlotStyle style,
                       PlotColour colour) {
  return {std::move(label), Eigen::Map<const Eigen::VectorXd>(x.data(), std::ssize(x)),
          Eigen::Map<const Eigen::VectorXd>(y.data(), std::ssize(y)), style, colour};
}

std::vector<double> nice_ticks(double low, double high, int most) {
  const double rough = (high - low) / most;
  if (!(rough > 0.0) || !std::isfinite(rough)) return {};
  const double decade = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10.0 * decade;
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * decade >= rough * (1.0 - 1e-12)) {
      step = factor * decade;
      break;
    }
  std::vector<double> ticks;
  for (double n = std::ceil(low / step - 1e-9); n * step <= high + 1e-9 * step; ++n) ticks.push_back(n * step);
  return ticks;
}

std::vector<double> log_ticks(double low, double high, int most) {
  const double first = std::floor(std::log10(low)), last = std::log10(high);
  const std::vector<double> all{1.0, 2.0, 5.0}, alone{1.0};
  for (double stride = 0.0; stride <= last - first; stride += 1.0) {
    std::vector<double> ticks;
    for (double power = first; power <= last; power += std::max(1.0, stride))
      for (const double factor : stride > 0.0 ? alone : all)
        if (const double value = factor * std::pow(10.0, power); value >= low && value <= high) ticks.push_back(value);
    if (ticks.size() < 2) break;
    if (std::ssize(ticks) <= most) return ticks;
  }
  return nice_ticks(low, high, most);
}

std::string to_svg(const PlotFigure& figure) {
  const int columns = std::max(1, std::min(figure.columns, static_cast<int>(figure.panels.size())));
  const int rows = (static_cast<int>(figure.panels.size()) + columns - 1) / columns;
  const double width = columns * figure.panel_width_px + (columns + 1) * panel_gap;
  const double panels_top = figure.title.empty() ? panel_gap : title_height;
  const double caption_top = panels_top + rows * (figure.panel_height_px + panel_gap);
  constexpr double letter_px = 6.4;
  std::vector<std::string> caption;
  for (const std::string& paragraph : figure.caption)
    for (std::string& line : wrapped(paragraph, static_cast<std::size_t>((width - 4.0 * panel_gap) / letter_px)))
      caption.push_back(std::move(line));
  const double height = caption_top + line_height * static_cast<double>(caption.size()) + panel_gap;
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} {1:.0f}\" "
      "font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n",
      width, height);
  if (!figure.title.empty())
    out += text_element(0.5 * width, 20.0, "middle", figure.title, " font-size=\"15\" font-weight=\"bold\"");
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    const int number = static_cast<int>(i), row = number / columns;
    out += panel_element(figure.panels[i], figure, panel_gap + (number % columns) * (figure.panel_width_px + panel_gap),
                         panels_top + row * (figure.panel_height_px + panel_gap), number);
  }
  for (std::size_t i = 0; i < caption.size(); ++i)
    out +=
        text_element(2.0 * panel_gap, caption_top + line_height * (static_cast<double>(i) + 0.7), "start", caption[i]);
  return out + "</svg>\n";
}

}  // namespace apps
