#include "apps/page/chart_data.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>

#include "apps/process/printable.hpp"
#include "apps/text/envelope.hpp"

namespace apps {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Json = nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little, "pages hold numbers least byte first");

template <class Numbers>
std::string_view bytes_of(const Numbers& numbers) {
  return {reinterpret_cast<const char*>(numbers.data()),
          static_cast<std::size_t>(numbers.size()) * sizeof(*numbers.data())};
}

const char* name_of(PlotColour colour) {
  constexpr std::array<const char*, 7> names{"ink", "vermilion", "blue", "green", "orange", "purple", "sky"};
  return names[static_cast<std::size_t>(colour)];
}

/// What is carried of a series: parts one behind the other.
struct Carried {
  struct Part {
    Index length = 0;
    bool is_thinned = false;
  };
  VectorXd x, y;
  std::vector<Part> parts;
};

/// The envelope of a long one, but for what is seen first, which is carried as it is.
Carried carried(const PlotSeries& series, const std::optional<std::pair<double, double>>& view) {
  constexpr Index most = 40'000;
  const Index n = series.x.size();
  Index first = 0, last = 0;
  if (n > most && view && std::is_sorted(series.x.begin(), series.x.end())) {
    first = std::lower_bound(series.x.begin(), series.x.end(), view->first) - series.x.begin();
    last = std::upper_bound(series.x.begin(), series.x.end(), view->second) - series.x.begin();
    if (last - first > most) last = first;
  }
  Carried result;
  const auto add = [&](Index from, Index count, Index at_most) {
    if (count == 0) return;
    const Envelope part = envelope(series.x.segment(from, count), series.y.segment(from, count), at_most);
    const Index before = result.x.size(), length = part.x.size();
    result.x.conservativeResize(before + length);
    result.y.conservativeResize(before + length);
    result.x.tail(length) = part.x;
    result.y.tail(length) = part.y;
    result.parts.push_back({length, length < count});
  };
  const auto share = [&](Index count) { return std::max<Index>(2, most * count / std::max<Index>(n, 1)); };
  if (first == last) {
    add(0, n, most);
  } else {
    add(0, first, share(first));
    add(first, last - first, last - first);
    add(last, n - last, share(n - last));
  }
  return result;
}

/// Their x as runs of equal steps, [length, first, step, thinned]; null where these would be many.
Json runs_of(const Carried& carried) {
  const std::size_t most_runs = 8 + static_cast<std::size_t>(carried.x.size()) / 50;  // four numbers each
  Json runs = Json::array();
  Index end = 0;
  for (const Carried::Part& part : carried.parts) {
    Index at = end;
    end += part.length;
    while (at < end && runs.size() <= most_runs) {
      Index length = std::min<Index>(2, end - at);
      while (at + length < end && is_uniform(carried.x.segment(at + length - 2, 3))) ++length;
      while (length > 2 && !is_uniform(carried.x.segment(at, length))) length = (length + 1) / 2;
      const auto x = carried.x.segment(at, length);
      runs.push_back({length, x(0), length > 1 ? (x(length - 1) - x(0)) / static_cast<double>(length - 1) : 0.0,
                      part.is_thinned ? 1 : 0});
      at += length;
    }
  }
  return runs.size() > most_runs ? Json() : runs;
}

Json series_json(const PlotSeries& series, const std::optional<std::pair<double, double>>& view) {
  const Carried shown = carried(series, view);
  const Packed y = packed(shown.y);
  Json result{{"label", printable(series.label)},
              {"dashed", series.style == PlotStyle::dashed},
              {"points", series.style == PlotStyle::points},
              {"band_limited", series.band_limited},
              {"colour", name_of(series.colour)},
              {"n", shown.x.size()}};
  result["x"] = runs_of(shown);
  if (result["x"].is_null()) {
    const Eigen::VectorXf written = shown.x.cast<float>();
    result["x"] = base64(bytes_of(written));
  }
  result["middle"] = y.middle;
  result["step"] = y.step;
  result["y"] = base64(bytes_of(y.codes));
  return result;
}

}  // namespace

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

std::string chart_json(const PlotPanel& panel) {
  Json document{{"title", printable(panel.title)},
                {"x_label", printable(panel.x_label)},
                {"y_label", printable(panel.y_label)},
                {"spans", Json::array()},
                {"series", Json::array()}};
  if (panel.x_log) document["x_log"] = true;
  if (panel.x_limits) document["view"] = {panel.x_limits->first, panel.x_limits->second};
  if (panel.y_limits) document["y_view"] = {panel.y_limits->first, panel.y_limits->second};
  for (const PlotSpan& span : panel.spans)
    document["spans"].push_back(
        {{"from", span.from}, {"to", span.to}, {"label", printable(span.label)}, {"colour", name_of(span.colour)}});
  for (const PlotSeries& series : panel.series) document["series"].push_back(series_json(series, panel.x_limits));
  return document.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace apps
