#include "apps/page/chart_data.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>

#include "apps/process/printable.hpp"

namespace apps {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Json = nlohmann::ordered_json;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
static_assert(std::endian::native == std::endian::little, "pages hold numbers least byte first");

template <class Number>
std::string bytes_of(const std::vector<Number>& numbers) {
  std::string bytes(numbers.size() * sizeof(Number), '\0');
  if (!numbers.empty()) std::memcpy(bytes.data(), numbers.data(), bytes.size());
  return bytes;
}

bool is_uniform(const VectorXd& x) {
  if (x.size() < 2) return false;
  const double step = (x(x.size() - 1) - x(0)) / static_cast<double>(x.size() - 1);
  constexpr double tolerance = 1e-6;  // of a step
  for (Index i = 0; i < x.size(); ++i)
    if (!(std::abs(x(i) - x(0) - step * static_cast<double>(i)) <= tolerance * std::abs(step))) return false;
  return true;
}

const char* name_of(PlotColour colour) {
  constexpr std::array<const char*, 7> names{"ink", "vermilion", "blue", "green", "orange", "purple", "sky"};
  return names[static_cast<std::size_t>(colour)];
}

Json series_json(const PlotSeries& series, Index most_points) {
  const Decimated shown = min_max_decimated(series.x, series.y, most_points);
  const Packed y = packed(shown.y);
  Json result{{"label", printable(series.label)},
              {"dashed", series.style == PlotStyle::dashed},
              {"colour", name_of(series.colour)},
              {"n", shown.y.size()}};
  if (is_uniform(shown.x)) {
    result["x0"] = shown.x(0);
    result["dx"] = (shown.x(shown.x.size() - 1) - shown.x(0)) / static_cast<double>(shown.x.size() - 1);
  } else {
    std::vector<float> x;
    for (const double value : shown.x) x.push_back(static_cast<float>(value));
    result["x"] = base64(bytes_of(x));
  }
  result["middle"] = y.middle;
  result["step"] = y.step;
  result["y"] = base64(bytes_of(y.codes));
  return result;
}

}  // namespace

Decimated min_max_decimated(const Eigen::Ref<const VectorXd>& x, const Eigen::Ref<const VectorXd>& y, Index most) {
  const Index n = std::min(x.size(), y.size());
  if (n <= most || most < 2) return {x.head(n), y.head(n)};
  const Index runs = most / 2;
  const bool uniform = is_uniform(x);
  const double span = (x(n - 1) - x(0)) * static_cast<double>(n) / static_cast<double>(n - 1);
  Decimated result{VectorXd(2 * runs), VectorXd(2 * runs)};
  for (Index run = 0; run < runs; ++run) {
    const Index first = n * run / runs, end = n * (run + 1) / runs;
    Index least = -1, greatest = -1;
    for (Index i = first; i < end; ++i) {
      if (!std::isfinite(y(i))) continue;
      if (least < 0 || y(i) < y(least)) least = i;
      if (greatest < 0 || y(i) > y(greatest)) greatest = i;
    }
    const bool any = least >= 0;
    for (const Index half : {2 * run, 2 * run + 1})  // of equal steps where x is: less than a sample aside
      result.x(half) = uniform ? x(0) + span * static_cast<double>(half) / static_cast<double>(2 * runs)
                               : x(half == 2 * run ? first : (first + end) / 2);
    result.y(2 * run) = any ? y(std::min(least, greatest)) : nan;
    result.y(2 * run + 1) = any ? y(std::max(least, greatest)) : nan;
  }
  return result;
}

Packed packed(const Eigen::Ref<const VectorXd>& values) {
  constexpr double most = 32767.0;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double value : values)
    if (std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
  Packed result;
  if (low <= high) {
    result.middle = 0.5 * low + 0.5 * high;
    result.step = (0.5 * high - 0.5 * low) / most;
  }
  result.codes.reserve(static_cast<std::size_t>(values.size()));
  for (const double value : values) {
    const double code = result.step > 0.0 ? std::round((value - result.middle) / result.step) : 0.0;
    result.codes.push_back(std::isfinite(value) ? static_cast<std::int16_t>(std::clamp(code, -most, most))
                                                : std::numeric_limits<std::int16_t>::min());
  }
  return result;
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    const std::size_t left = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k) three = three << 8 | (k < left ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= left ? letters[three >> (18 - 6 * k) & 63u] : '=';
  }
  return text;
}

std::string chart_json(const PlotPanel& panel, Index most_points) {
  Json document{{"title", printable(panel.title)},
                {"x_label", printable(panel.x_label)},
                {"y_label", printable(panel.y_label)},
                {"spans", Json::array()},
                {"series", Json::array()}};
  if (panel.x_limits) document["view"] = {panel.x_limits->first, panel.x_limits->second};
  for (const PlotSpan& span : panel.spans)
    document["spans"].push_back(
        {{"from", span.from}, {"to", span.to}, {"label", printable(span.label)}, {"colour", name_of(span.colour)}});
  for (const PlotSeries& series : panel.series) document["series"].push_back(series_json(series, most_points));
  return document.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace apps
