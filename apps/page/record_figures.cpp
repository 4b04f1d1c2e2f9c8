#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include "apps/page/figures.hpp"
#include "apps/page/filter_response.hpp"
#include "apps/page/identified_response.hpp"
#include "apps/page/power_spectrum.hpp"

namespace apps {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr std::size_t most_recordings = 6;  // more are in the files of the run

PlotColour colour_of(dsp::Regime regime) {
  switch (regime) {
    case dsp::Regime::low:
      return PlotColour::sky;
    case dsp::Regime::high:
      return PlotColour::orange;
    case dsp::Regime::stick:
      return PlotColour::green;
    case dsp::Regime::excluded:
      break;
  }
  return PlotColour::black;
}

std::vector<PlotSpan> regime_spans(const Input& input) {
  std::vector<PlotSpan> spans;
  const double rate_hz = input.prepared.intermediate.sample_rate_hz;
  for (const dsp::Segment& segment : input.segmentation.segments)
    if (segment.regime != dsp::Regime::excluded)
      spans.push_back({static_cast<double>(segment.first) / rate_hz, static_cast<double>(segment.last) / rate_hz,
                       std::string(to_string(segment.regime)), colour_of(segment.regime)});
  for (const dsp::Interval& interval : input.prepared.excluded)
    spans.push_back({interval.from_s, interval.to_s, "excluded", PlotColour::black});
  return spans;
}

std::optional<PlotFigure> regime_figure(const Input& input, const std::string& prefix) {
  const dsp::Signal* x = input.prepared.signals.find("x");
  if (x == nullptr) return {};
  PlotPanel panel{"displacement and regimes", "time (s)",
                  x->unit.empty() ? "x (no unit)" : fmt::format("x ({})", x->unit)};
  panel.series = {{"x", input.prepared.signals.at("t"), x->values, PlotStyle::line, PlotColour::black}};
  panel.spans = regime_spans(input);
  std::string caption = input.prepared.name + ": displacement x over the whole record.";
  if (!panel.spans.empty())
    caption +=
        " Shaded: the regimes found in it, low (blue), high (orange) and stick (green), and what is left out (grey).";
  return chart(prefix + "-regimes", std::move(caption), std::move(panel));
}

std::optional<PlotFigure> filter_figure(const dsp::Prepared& prepared, const std::string& prefix) {
  if (!prepared.decimation || prepared.decimation->stages.empty()) return {};
  constexpr Index points = 600;
  const double rate_hz = prepared.signals.sample_rate_hz;
  const VectorXd frequency_hz = VectorXd::LinSpaced(points, 0.0, 1.5 * rate_hz);
  PlotPanel panel{"front-end filter", "frequency (Hz)", "gain (dB)"};
  panel.series = {{"gain", frequency_hz,
                   frequency_hz.unaryExpr([&](double f) { return gain_db(*prepared.decimation, f); }), PlotStyle::line,
                   PlotColour::black}};
  return chart(prefix + "-filter",
               fmt::format("Gain of the filter that decimates from {:.6g} Hz to {:.6g} Hz, computed from its "
                           "coefficients. What it passed above {:.4g} Hz would alias.",
                           prepared.decimation->stages.front().input_rate_hz, rate_hz, 0.5 * rate_hz),
               std::move(panel));
}

std::optional<PlotFigure> before_and_behind(const dsp::Prepared& prepared, const std::string& target,
                                            const std::string& prefix) {
  const dsp::Signal *wide = prepared.intermediate.find(target), *kept = prepared.signals.find(target);
  if (wide == nullptr || kept == nullptr) return {};
  const auto before = power_spectrum_db(wide->values, prepared.intermediate.sample_rate_hz),
             behind = power_spectrum_db(kept->values, prepared.signals.sample_rate_hz);
  if (before.frequency_hz.size() == 0 || behind.frequency_hz.size() == 0) return {};
  PlotPanel panel{"spectra before and after the filter", "frequency (Hz)",
                  fmt::format("power density (dB re 1 ({})^2/Hz)", wide->unit)};
  panel.x_log = true;
  panel.series = {{"before", before.frequency_hz, before.power_db, PlotStyle::line, PlotColour::black},
                  {"after", behind.frequency_hz, behind.power_db, PlotStyle::dashed, PlotColour::vermilion}};
  return chart(prefix + "-spectra",
               fmt::format("Spectrum of {} at {:.6g} Hz, before the filter of the columns, and at the {:.6g} Hz of "
                           "the regression, after it.",
                           target, prepared.intermediate.sample_rate_hz, prepared.signals.sample_rate_hz),
               std::move(panel));
}

/// Amplitude of x at the steps that are end results, up and down apart, and what the chosen equation makes of them.
std::optional<PlotFigure> steps_figure(const RunResults& results, const RecordingSteps& recording,
                                       const std::string& prefix) {
  const dsp::Signal* x = results.inputs.front().prepared.signals.find("x");
  PlotPanel panel{"frequency response", "frequency (Hz)",
                  fmt::format("amplitude of x ({})", x != nullptr ? x->unit : "")};
  std::string caption =
      fmt::format("{}: amplitude of x against frequency, at every step of the sine that reached a steady response.",
                  recording.first);
  const auto add = [&](const char* label, const auto& points, PlotStyle style, PlotColour colour, const auto& counts) {
    std::vector<double> frequency_hz, x_m;
    for (const auto& point : points)
      if (counts(point)) frequency_hz.push_back(point.frequency_hz), x_m.push_back(point.x_m);
    if (!x_m.empty()) panel.series.push_back(plot_series(label, frequency_hz, x_m, style, colour));
  };
  for (const auto& [label, direction, colour] :
       {std::tuple{"measured, up", 1, PlotColour::blue}, std::tuple{"measured, down", -1, PlotColour::vermilion},
        std::tuple{"measured", 0, PlotColour::black}})
    add(label, recording.second, PlotStyle::points, colour, [way = direction](const dsp::SteadyStep& step) {
      return step.tag == dsp::StepTag::final && step.direction == way;
    });
  if (const auto response = identified_response(results, recording.second)) {
    const auto every = [](const sim::ResponsePoint&) { return true; };
    add("equation, up", response->up, PlotStyle::dashed, PlotColour::black, every);
    add("equation, down", response->down, PlotStyle::line, PlotColour::black, every);
    caption +=
        " Lines: steady response of the chosen equation, frequency rising and falling, at the median amplitude of the "
        "drive. Static friction does not show while the payload slips, so the frequency at which it locks may differ; "
        "ardent frc --static-friction sets it.";
  }
  if (panel.series.empty()) return {};
  return cloud(prefix + "-response", std::move(caption), std::move(panel));
}

}  // namespace

void prediction_figures(const std::vector<ident::RecordPrediction>& predictions, const FigureTaker& take) {
  int number = 0;
  for (const ident::RecordPrediction& prediction : predictions) {
    if (prediction.time_s.size() == 0) continue;
    PlotPanel panel{"free run on another recording", "time (s)", fmt::format("x ({})", prediction.unit)};
    panel.series = {
        {"measured", prediction.time_s, prediction.x, PlotStyle::line, PlotColour::black, true},
        {"free run", prediction.time_s, prediction.predicted, PlotStyle::dashed, PlotColour::vermilion, true}};
    PlotFigure figure =
        chart(fmt::format("prediction-{}", ++number),
              fmt::format("{}, not fitted: measured x, the free run of the chosen equation, and what is between them.",
                          prediction.recording),
              std::move(panel));
    add_error_panel(figure);
    take(std::move(figure));
  }
}

void record_figures(const RunResults& results, const FigureTaker& take) {
  const auto take_if_any = [&](std::optional<PlotFigure> figure) {
    if (figure) take(std::move(*figure));
  };
  for (std::size_t i = 0; i < std::min(most_recordings, results.inputs.size()); ++i)
    take_if_any(regime_figure(results.inputs[i], fmt::format("recording-{}", i + 1)));
  for (std::size_t i = 0; i < std::min(most_recordings, results.steps.size()); ++i)
    take_if_any(steps_figure(results, results.steps[i], fmt::format("steps-{}", i + 1)));
  const dsp::Prepared& first = results.inputs.front().prepared;
  take_if_any(filter_figure(first, "front-end"));
  take_if_any(before_and_behind(first, results.config.fit.target, "front-end"));
}

}  // namespace apps
