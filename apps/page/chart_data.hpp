#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "apps/text/svg_plot.hpp"

namespace apps {

/// Numbers as a page carries them: whole numbers q from -32767 to 32767, value = middle + step q, -32768 for none; two
/// bytes each, least first.
struct Packed {
  double middle = 0.0, step = 0.0;
  std::vector<std::int16_t> codes;
};
[[nodiscard]] Packed packed(const Eigen::Ref<const Eigen::VectorXd>& values);

[[nodiscard]] std::string base64(std::string_view bytes);

/// A panel as the JSON document that page.js draws: {"title", "x_label", "y_label", "x_log" (left out: false), "view",
/// "y_view": [from, to] (what is shown first, left out: all), "spans": [{"from", "to", "label", "colour"}], "series":
/// [{"label", "dashed", "points", "band_limited", "colour", "n", "x", "middle", "step", "y" (int16)}]}. "x": [[length,
/// first, step, thinned], ...], runs one behind the other, or float32; arrays in base64; of long series the envelope,
/// but for what is shown first.
[[nodiscard]] std::string chart_json(const PlotPanel& panel);

}  // namespace apps
