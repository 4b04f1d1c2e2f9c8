#include "apps/output/response_report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/text/json_number.hpp"
#include "apps/text/number_text.hpp"
#include "dsp/values/constants.hpp"

namespace apps {
namespace {

using nlohmann::ordered_json;
using Points = std::vector<sim::ResponsePoint>;

const char* mode_of(const sim::ResponsePoint& point) {
  return point.locked ? "locked" : point.stuck_fraction > 0.0 ? "stick-slip" : "slip";
}

std::string rows(const Points& points, const ident::ResponseBand& band, const char* direction) {
  std::string text;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const sim::ResponsePoint& point = points[k];
    text += fmt::format("{},{:.6g},{:.9g},{},{:.9g},{},{:.6g}", direction, point.frequency_hz, point.x_m,
                        mode_of(point), point.y_m, number_text(dsp::degrees_a_radian * point.phase_rad, "{:.6g}", ""),
                        point.stuck_fraction);
    if (!band.x_std_m.empty())
      text += fmt::format(",{:.6g},{:.9g},{:.9g}", band.x_std_m[k], band.x_low_m[k], band.x_high_m[k]);
    text += "\n";
  }
  return text;
}

ordered_json peak_json(const Points& points) {
  const sim::ResponsePoint peak = sim::peak(points);
  return {{"f_hz", peak.frequency_hz}, {"amplitude_m", peak.x_m}, {"payload_amplitude_m", peak.y_m}};
}

/// The curve of one sweep, and dashed what bounds 95 % of the draws.
void add_series(PlotPanel& panel, const Points& points, const char* label, PlotColour colour, double factor,
                double sim::ResponsePoint::*amplitude, const std::vector<double>& low,
                const std::vector<double>& high) {
  const auto count = static_cast<Eigen::Index>(points.size());
  PlotSeries line{label, Eigen::VectorXd(count), Eigen::VectorXd(count), PlotStyle::line, colour};
  for (Eigen::Index k = 0; k < count; ++k) {
    line.x[k] = points[static_cast<std::size_t>(k)].frequency_hz;
    line.y[k] = factor * (points[static_cast<std::size_t>(k)].*amplitude);
  }
  for (const auto* bound : {&low, &high})
    if (!bound->empty())
      panel.series.push_back({bound == &low ? fmt::format("{}, 95 % of draws", label) : "", line.x,
                              factor * Eigen::Map<const Eigen::VectorXd>(bound->data(), count), PlotStyle::dashed,
                              colour});
  panel.series.push_back(std::move(line));
}

}  // namespace

ShownUnit shown_unit(std::string_view x_unit) {
  return x_unit == "rad" ? ShownUnit{1.0, "rad"} : ShownUnit{};
}

std::string response_csv(const ReportedResponse& reported) {
  std::string text = "direction,f_hz,amplitude_m,mode,payload_amplitude_m,phase_deg,stuck_share";
  if (!reported.up.x_std_m.empty()) text += ",amplitude_std_m,amplitude_low_m,amplitude_high_m";
  return text + "\n" + rows(reported.response.up, reported.up, "up") +
         rows(reported.response.down, reported.down, "down");
}

const std::array<ResponseEvent, 6>& response_events() {
  using Jumps = sim::ResponseJumps;
  static constexpr std::array<ResponseEvent, 6> events{
      {{"up", "unlock_hz", "the locked payload breaks loose", &Jumps::unlock_rising_hz, true},
       {"up", "jump_hz", "the sliding payload jumps up", &Jumps::jump_up_rising_hz},
       {"up", "fall_hz", "it jumps down", &Jumps::jump_down_rising_hz},
       {"down", "jump_hz", "it jumps up", &Jumps::jump_up_falling_hz},
       {"down", "fall_hz", "it jumps down", &Jumps::jump_down_falling_hz},
       {"down", "lock_hz", "it locks", &Jumps::lock_falling_hz, true}}};
  return events;
}

ordered_json response_json(const sim::FrequencyResponse& response) {
  ordered_json document{{"up", ordered_json::object()}, {"down", ordered_json::object()}};
  for (const ResponseEvent& event : response_events())
    document[event.way][event.key] = number_or_null(response.jumps.*event.frequency_hz);
  document["up"]["peak"] = peak_json(response.up);
  document["down"]["peak"] = peak_json(response.down);
  return document;
}

std::string response_text(const sim::FrequencyResponse& response) {
  std::string text;
  for (const ResponseEvent& event : response_events()) {
    const double hz = response.jumps.*event.frequency_hz;
    text +=
        fmt::format("  {:<5} {:<34} {}\n", event.way, event.sentence, number_text(hz, "{:.5g} Hz", "does not happen"));
  }
  for (const auto& [way, points] : {std::pair{"up", &response.up}, std::pair{"down", &response.down}})
    text += fmt::format("  {:<5} {:<34} {:.4g} mm at {:.5g} Hz\n", way, "largest relative amplitude",
                        1e3 * sim::peak(*points).x_m, sim::peak(*points).frequency_hz);
  return text;
}

PlotFigure response_figure(const ReportedResponse& reported, std::string_view title) {
  PlotFigure figure;
  figure.title = title;
  const ShownUnit unit = shown_unit(reported.x_unit);
  const auto panel = [&](const char* panel_title, const char* name) {
    return PlotPanel{panel_title, "frequency (Hz)", fmt::format("amplitude of {} ({})", name, unit.name)};
  };
  if (reported.has_base) figure.panels = {panel("payload", "y")};
  figure.panels.push_back(panel(reported.has_base ? "relative" : "", "x"));
  const auto add = [&](const Points& points, const ident::ResponseBand& band, const char* label, PlotColour colour) {
    if (reported.has_base)
      add_series(figure.panels.front(), points, label, colour, unit.factor, &sim::ResponsePoint::y_m, band.y_low_m,
                 band.y_high_m);
    add_series(figure.panels.back(), points, label, colour, unit.factor, &sim::ResponsePoint::x_m, band.x_low_m,
               band.x_high_m);
  };
  add(reported.response.up, reported.up, "up", PlotColour::vermilion);
  add(reported.response.down, reported.down, "down", PlotColour::blue);
  return figure;
}

bool set_sweep_option(sim::FrequencyResponseOptions& options, std::string_view name, double value) {
  if (name == "from_hz") return options.from_hz = value, true;
  if (name == "to_hz") return options.to_hz = value, true;
  if (name == "step_hz") return options.step_hz = value, true;
  if (name == "dwell_s") return options.dwell_s = value, true;
  if (name == "transition_s") return options.transition_s = value, true;
  if (name == "amplitude_mm") return options.amplitude_m = 1e-3 * value, true;
  return false;
}

ordered_json sweep_json(const sim::FrequencyResponseOptions& options) {
  return {{"from_hz", options.from_hz},           {"to_hz", options.to_hz},
          {"step_hz", options.step_hz},           {"dwell_s", options.dwell_s},
          {"transition_s", options.transition_s}, {"amplitude_m", options.amplitude_m}};
}

std::string_view sweep_option_names() {
  return "from_hz, to_hz, step_hz, dwell_s, transition_s, amplitude_mm";
}

}  // namespace apps
