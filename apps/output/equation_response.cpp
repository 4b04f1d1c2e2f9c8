#include "apps/output/equation_response.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>

#include "apps/output/response_report.hpp"
#include "apps/process/printable.hpp"
#include "apps/text/json_number.hpp"
#include "apps/text/json_parts.hpp"
#include "apps/text/number_text.hpp"

namespace apps {
namespace {

using Json = nlohmann::ordered_json;

/// How far the equation's curves are from the record's steady amplitudes; each against the nearer of the two sweeps,
/// because hands and chance decide which branch a test is on.
struct Misfit {
  int count = 0;
  double rms = 0.0, worst = 0.0, worst_hz = 0.0;  ///< relative, of x
};

Misfit misfit_of(const EquationResponse& result) {
  Misfit misfit;
  double squares = 0.0;
  for (const StepPoint& step : result.steps) {
    if (step.locked) continue;  // what is left there is the sensors'
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto* points : {&result.steady.response.up, &result.steady.response.down})
      for (std::size_t k = 1; k < points->size(); ++k) {
        const sim::ResponsePoint &a = (*points)[k - 1], &b = (*points)[k];
        const double fraction = (step.frequency_hz - a.frequency_hz) / (b.frequency_hz - a.frequency_hz);
        if (!(fraction >= 0.0 && fraction <= 1.0)) continue;
        const double x_m = a.x_m + fraction * (b.x_m - a.x_m);
        if (std::abs(x_m - step.x_m) < std::abs(nearest)) nearest = x_m - step.x_m;
      }
    if (!std::isfinite(nearest)) continue;
    const double relative = std::abs(nearest) / step.x_m;
    ++misfit.count;
    squares += relative * relative;
    if (relative > misfit.worst) misfit.worst = relative, misfit.worst_hz = step.frequency_hz;
  }
  misfit.rms = std::sqrt(squares / std::max(misfit.count, 1));
  return misfit;
}

ident::DrawnFigure drawn(const EquationResponse& result, const ResponseEvent& event) {
  std::vector<double> values;
  for (const sim::ResponseJumps& jumps : result.draws.located) values.push_back(jumps.*event.frequency_hz);
  return ident::drawn_figure(values);
}

std::vector<std::string> remarks_of(const EquationResponse& result) {
  std::vector<std::string> remarks;
  if (result.equation.verdict == ident::Verdict::does_not)
    remarks.push_back("the equation does not describe its record: see equation.txt of the run");
  if (result.has_friction && result.static_friction > 0.0)
    remarks.push_back(fmt::format("static friction of {:g} m/s^2 is given, not identified", result.static_friction));
  if (result.has_friction && result.static_friction == 0.0)
    remarks.push_back(
        fmt::format("static friction cannot be identified while the payload slips: the frequencies of locking and "
                    "breaking loose are those of the identified sliding friction{}",
                    result.equation.takes_static_friction
                        ? ". If static friction is known from elsewhere, give it with --static-friction"
                        : ""));
  const double limit = result.equation.largest_x;
  const ShownUnit unit = shown_unit(result.equation.x_unit);
  const auto& response = result.steady.response;
  if (const double largest = std::max(sim::peak(response.up).x_m, sim::peak(response.down).x_m);
      limit > 0.0 && largest > 1.1 * limit)
    remarks.push_back(fmt::format("amplitudes beyond {:.3g} {} are extrapolated: the training rows end there",
                                  unit.factor * limit, unit.name));
  const double first_hz = response.up.front().frequency_hz, last_hz = response.up.back().frequency_hz,
               peak_hz = sim::peak(response.up).frequency_hz;
  if (peak_hz == last_hz && !std::isfinite(result.steady.diverged_hz))
    remarks.push_back(
        fmt::format("the amplitude is largest where the sweep up ends: --set to_hz={:.2g} shows more", 1.5 * last_hz));
  if (peak_hz == first_hz && sim::peak(response.up).x_m > 0.0)
    remarks.push_back(fmt::format("the amplitude is largest where the sweep begins: --set from_hz={:.2g} shows more",
                                  first_hz / 1.5));
  if (result.steady.num_unsettled > 0)
    remarks.push_back(
        fmt::format("{} frequencies have no steady motion of the drive's period", result.steady.num_unsettled));
  if (std::isfinite(result.steady.diverged_hz))
    remarks.push_back(
        fmt::format("the motion runs away at {:.5g} Hz; the sweep ends there", result.steady.diverged_hz));
  if (result.draws.num_diverged > 0)
    remarks.push_back(
        fmt::format("in {} of {} draws the motion runs away", result.draws.num_diverged, result.num_draws));
  return remarks;
}

Json json_of(const EquationResponse& result) {
  const RespondingEquation& equation = result.equation;
  Json named = Json::object();
  for (const auto& [key, value] : equation.keys) named[key] = value;
  named["text"] = equation.text;
  Json document{{"equation", std::move(named)},
                {"drive", result.drive == ident::DriveKind::base ? "base displacement, m" : result.input},
                {"x_unit", equation.x_unit},
                {"sweep",
                 {{"from_hz", result.sweep.from_hz},
                  {"to_hz", result.sweep.to_hz},
                  {"step_hz", result.sweep.step_hz},
                  {"amplitude", result.sweep.amplitude_m},
                  {"amplitude_std", result.amplitude_std * result.sweep.amplitude_m}}},
                {"static_friction", result.static_friction > 0.0 ? Json(result.static_friction) : Json()},
                {"draws", result.num_draws},
                {"seed", result.seed},
                {"coordinates", equation.coordinates},
                {"frequency_response", response_json(result.steady.response)},
                {"located", {{"up", Json::object()}, {"down", Json::object()}}}};
  for (const ResponseEvent& event : response_events()) {
    const ident::DrawnFigure spread = drawn(result, event);
    document["located"][event.way][event.key] = {
        {"value", number_or_null(result.steady.located.*event.frequency_hz)},
        {"draws_mean", number_or_null(spread.mean)},
        {"draws_std", number_or_null(spread.std)},
        {"draws_share", result.num_draws > 0 ? Json(spread.fraction) : Json()}};
  }
  document["frequency_response"]["up"]["peak"]["std_m"] =
      number_or_null(ident::drawn_figure(result.draws.peak_up_m).std);
  document["frequency_response"]["down"]["peak"]["std_m"] =
      number_or_null(ident::drawn_figure(result.draws.peak_down_m).std);
  if (const Misfit misfit = misfit_of(result); misfit.count > 0)
    document["record"] = {
        {"num_steps", misfit.count}, {"rms", misfit.rms}, {"worst", misfit.worst}, {"worst_hz", misfit.worst_hz}};
  document["num_unsettled"] = result.steady.num_unsettled;
  document["remarks"] = remarks_of(result);
  return document;
}

/// The record's own end results over the equation's curves, as Fig. 11 of [QZS23] has them.
void add_steps(PlotFigure& figure, const std::vector<StepPoint>& steps, double factor) {
  for (const bool up : {true, false}) {
    std::vector<double> f_hz, x, y;
    for (const StepPoint& step : steps)
      if (step.up == up)
        f_hz.push_back(step.frequency_hz), x.push_back(factor * step.x_m), y.push_back(factor * step.y_m);
    if (f_hz.empty()) continue;
    const auto add = [&](PlotPanel& panel, const std::vector<double>& amplitude) {
      panel.series.push_back(plot_series(up ? "record, up" : "record, down", f_hz, amplitude, PlotStyle::points,
                                         up ? PlotColour::orange : PlotColour::black));
    };
    if (figure.panels.size() > 1) add(figure.panels.front(), y);
    add(figure.panels.back(), x);
  }
}

ReportedResponse reported(const EquationResponse& result) {
  return {result.steady.response, result.draws.up, result.draws.down, result.equation.x_unit,
          result.drive == ident::DriveKind::base};
}

}  // namespace

RespondingEquation responding(const ident::IdentifiedEquation& equation) {
  const std::string of = fmt::format("range {} by {}", equation.range, equation.method);
  return {.of = of,
          .title = "Response of the equation of " + of,
          .keys = {{"range", equation.range}, {"method", equation.method}},
          .text = equation.text,
          .coordinates = equation.coordinates,
          .x_unit = equation.x_unit,
          .verdict = equation.verdict,
          .largest_x = equation.largest_x};
}

std::string response_text(const EquationResponse& result) {
  const auto& sweep = result.sweep;
  const ShownUnit unit = shown_unit(result.equation.x_unit);
  std::string text = printable(fmt::format("{}: {}", result.equation.of, result.equation.text));
  if (!result.equation.coordinates.empty()) text += "\n" + result.equation.coordinates;
  text += fmt::format("\n{}{}, {:g} to {:g} Hz in steps of {:g} Hz; {} draws of the coefficients, seed {}\n\n",
                      result.drive == ident::DriveKind::base
                          ? fmt::format("base motion of {:g} {}", unit.factor * sweep.amplitude_m, unit.name)
                          : fmt::format("{} of amplitude {:g}", result.input, sweep.amplitude_m),
                      result.amplitude_std > 0.0 ? fmt::format(" within {:.2g} %", 100.0 * result.amplitude_std) : "",
                      sweep.from_hz, sweep.to_hz, sweep.step_hz, result.num_draws, result.seed);
  text += fmt::format("  {:<5} {:<34} {:>9} {:>11} {:>9}\n", "", "Hz", "step", "located", "sd");
  for (const ResponseEvent& event : response_events()) {
    if (event.needs_friction && !result.has_friction) continue;
    const double step_hz = result.steady.response.jumps.*event.frequency_hz;
    const ident::DrawnFigure spread = drawn(result, event);
    text +=
        fmt::format("  {:<5} {:<34} {:>9} {:>11} {:>9}", event.way,
                    !result.has_friction && event.key == std::string_view("jump_hz") ? "it jumps up" : event.sentence,
                    number_text(step_hz, "{:.6g}"), number_text(result.steady.located.*event.frequency_hz, "{:.6g}"),
                    number_text(spread.std, "{:.2g}"));
    if (result.num_draws > 0 && spread.fraction != std::isfinite(step_hz))
      text += fmt::format("  in {:.0f} % of the draws", 100.0 * spread.fraction);
    text += "\n";
  }
  for (const auto& [way, points, peaks] : {std::tuple{"up", &result.steady.response.up, &result.draws.peak_up_m},
                                           std::tuple{"down", &result.steady.response.down, &result.draws.peak_down_m}})
    text += fmt::format(
        "  {:<5} {:<34} {:.5g} {} at {:.5g} Hz{}\n", way, "largest amplitude of x",
        unit.factor * sim::peak(*points).x_m, unit.name, sim::peak(*points).frequency_hz,
        peaks->empty() ? "" : fmt::format(", sd {:.2g} {}", unit.factor * ident::drawn_figure(*peaks).std, unit.name));
  if (const Misfit misfit = misfit_of(result); misfit.count > 0)
    text += fmt::format(
        "  from the record's {} steady amplitudes in motion it is {:.2g} % away (rms), at most {:.2g} % at {:.5g} Hz\n",
        misfit.count, 100.0 * misfit.rms, 100.0 * misfit.worst, misfit.worst_hz);
  for (const std::string& remark : remarks_of(result)) text += "  - " + remark + "\n";
  return text;
}

std::string response_document(const EquationResponse& result) {
  return text_of(json_of(result));
}

std::string response_csv(const EquationResponse& result) {
  return response_csv(reported(result));
}

PlotFigure response_figure(const EquationResponse& result) {
  PlotFigure figure = response_figure(reported(result), result.equation.title);
  add_steps(figure, result.steps, shown_unit(result.equation.x_unit).factor);
  figure.caption = remarks_of(result);
  return figure;
}

}  // namespace apps
