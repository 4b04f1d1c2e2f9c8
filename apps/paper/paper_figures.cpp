#include "apps/paper/paper_figures.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "apps/output/response_report.hpp"
#include "apps/paper/paper_data.hpp"
#include "apps/process/interrupt.hpp"
#include "sim/rig/qzs_rig.hpp"

namespace apps {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

const std::map<std::string, std::string> axis_titles{{"t", "time (s)"},
                                                     {"x", "displacement x (m)"},
                                                     {"v", "velocity v (m/s)"},
                                                     {"a", "acceleration a (m/s\u00b2)"},
                                                     {"z", "hysteretic force z (N)"},
                                                     {"dz", "rate of the force dz/dt (N/s)"}};

VectorXd signal_of(const sim::Simulation& run, const std::string& signal) {
  if (signal == "t") return run.time_s;
  if (signal == "a") return run.derivatives.col(1);
  if (signal == "dz") return run.derivatives.col(2);
  return run.states.col(signal == "x" ? 0 : signal == "v" ? 1 : 2);
}

/// The limits of values with room below and above them, fractions of their size: the legend's place.
std::pair<double, double> with_room(const VectorXd& values, double below, double above) {
  const double low = values.minCoeff(), high = values.maxCoeff(), size = high - low;
  return {low - below * size, high + above * size};
}

/// Every n-th value, so that no more than `most` are left.
VectorXd thinned(const VectorXd& values, Index most) {
  const Index step = (values.size() + most - 1) / most;
  return values(Eigen::seqN(0, (values.size() + step - 1) / step, step));
}

std::string caption_of(const CaseReplication& replication, std::uint64_t seed, double ratio) {
  std::vector<std::string> values;
  for (const Json* run :
       matching(replication.document.at("free_run"), {{"seed", seed}, {"method", "fast_rvm"}, {"ratio", ratio}})) {
    if (run->at("nmse").is_null()) return "no free-run NMSE, " + run->at("status").get<std::string>();
    values.push_back(fmt::format("{} {:.2g}", run->at("signal").get<std::string>(), number_in(run->at("nmse"))));
  }
  return fmt::format("free-run NMSE {}", fmt::join(values, ", "));
}

}  // namespace

PlotFigure case_figure(const CaseReplication& replication) {
  const Section4Case& definition = *replication.study.definition;
  PlotFigure figure;
  figure.title =
      fmt::format("{}: true and identified responses at ratios held out (Fig. {})", definition.name, definition.figure);
  figure.columns = static_cast<int>(definition.figure_x.size());
  const std::uint64_t seed = replication.document.at("free_run")[0]["seed"];
  for (const HeldOutRun& run : replication.runs) {
    const std::string ratio = fmt::format("\u03c9/\u03c9\u2099 = {:g}", run.record.ratio);
    figure.caption.push_back(ratio + ": " + caption_of(replication, seed, run.record.ratio));
    for (std::size_t i = 0; i < definition.figure_x.size(); ++i) {
      const std::string &x = definition.figure_x[i], &y = definition.figure_y[i];
      const VectorXd& true_y = run.record.motion.at(y);
      // A diverging run must not shrink the truth to a line.
      figure.panels.push_back({ratio,
                               axis_titles.at(x),
                               axis_titles.at(y),
                               {{"true", run.record.motion.at(x), true_y}},
                               {},
                               with_room(true_y, 0.12, 0.30)});
      figure.panels.back().series.push_back({"identified", signal_of(run.identified, x), signal_of(run.identified, y),
                                             PlotStyle::dashed, PlotColour::vermilion});
    }
  }
  figure.caption.push_back(
      fmt::format("Identified: mean coefficients of the fast RVM, seed {}; 25 s from rest.", seed));
  return figure;
}

PlotFigure rig_sweeps() {
  PlotFigure figure{"Response to a sinusoidal base motion of 4.5 mm (Fig. 11)", {}};
  for (const char* twin : {"T1", "T0"}) {
    const ReportedResponse reported{
        sim::frequency_response(sim::qzs_twin(twin), {.step_hz = 0.02, .poll = check_interrupted}), {}, {}};
    for (PlotPanel& panel : response_figure(reported, "").panels) {
      panel.title = fmt::format("{}, {}", twin, panel.title);
      panel.y_limits = {-2.0, 60.0};  // the legend's place
      figure.panels.push_back(std::move(panel));
    }
    const sim::ResponseJumps& jumps = reported.response.jumps;
    figure.caption.push_back(
        fmt::format("{}: breaks loose at {:.2f} Hz on the way up; jumps up at {:.2f} Hz and locks at {:.2f} Hz on "
                    "the way down",
                    twin, jumps.unlock_rising_hz, jumps.jump_up_falling_hz, jumps.lock_falling_hz));
  }
  figure.caption.push_back("The paper: jumps at nearly 1.5 Hz on the way up, to a branch without upper bound.");
  return figure;
}

PlotFigure rig_states(const RigReplication& replication) {
  constexpr Index most_points = 3000;
  PlotFigure figure{"Measured states of the regimes, twin T1 (Fig. 12)", {}, 3, 380.0};
  const std::string time = "time (s)", x = axis_titles.at("x"), v = axis_titles.at("v");
  for (const RigFit& fit : replication.shown) {
    const std::string name = fit.result.spec.name + " amplitude";
    const PlotSeries over_time{"", fit.time_s, fit.v, PlotStyle::line, PlotColour::blue};
    const PlotSeries over_x{"", thinned(fit.x, most_points), thinned(fit.v, most_points), PlotStyle::points,
                            PlotColour::green};
    figure.panels.push_back({name, time, x, {{"", fit.time_s, fit.x}}, {}, {}});
    figure.panels.push_back({name, time, v, {over_time}, {}, {}});
    figure.panels.push_back({name, x, v, {over_x}, {}, {}});
  }
  figure.caption = {
      fmt::format("By the paper's recipe at 25.6 Hz. Right: at most {} samples of each regime.", most_points)};
  return figure;
}

PlotFigure rig_responses(const RigReplication& replication) {
  constexpr double zoom_s = 8.0;
  PlotFigure figure{"Measured and identified acceleration, twin T1 by the paper's recipe, F-RVM (Fig. 13)", {}};
  for (const auto& [result, time_s, x, v] : replication.shown) {
    const ident::JudgedFit& judged = result.fits.front();
    const std::string name = result.spec.name + " amplitude", acceleration = "acceleration (m/s\u00b2)";
    const Index num_train = std::ssize(result.rows.train), size = time_s.size(),
                zoom = std::min<Index>(size - num_train, static_cast<Index>(zoom_s * 25.6));
    const auto limits = with_room(result.target, 0.08, 0.36);
    const auto series = [&, &time_s = time_s](const char* label, const VectorXd& values, Index first, Index count,
                                              PlotStyle style, PlotColour colour) {
      return PlotSeries{label, time_s.segment(first, count), values.segment(first, count), style, colour};
    };
    figure.panels.push_back({name,
                             axis_titles.at("t"),
                             acceleration,
                             {series("measured", result.target, 0, size, PlotStyle::line, PlotColour::black),
                              series("measured - identified", result.target - judged.predicted, 0, size,
                                     PlotStyle::line, PlotColour::vermilion),
                              {"train | test", VectorXd::Constant(2, *result.spec.train_to_s),
                               Eigen::Vector2d(limits.first, limits.second), PlotStyle::line, PlotColour::blue}},
                             {},
                             limits});
    figure.panels.push_back(
        {name,
         axis_titles.at("t"),
         acceleration,
         {series("measured", result.target, num_train, zoom, PlotStyle::line, PlotColour::black),
          series("identified", judged.predicted, num_train, zoom, PlotStyle::dashed, PlotColour::vermilion)},
         {},
         limits});
    const auto print = [&, &result = result](const char* part) {
      return printed_value(9, part, "fast_rvm", "nmse", result.spec.name);
    };
    figure.caption.push_back(fmt::format(
        "{}: NMSE train {:.4f}, test {:.4f}; the paper's {:.4f}, {:.4f}; free run over the test rows {}", name,
        judged.train.value, judged.test.value, print("train"), print("test"),
        judged.free_run.reason.empty() ? fmt::format("{:.2g}", judged.free_run.nmse) : judged.free_run.reason));
  }
  figure.caption.push_back(fmt::format("Right: the first {:g} s of the test rows.", zoom_s));
  return figure;
}

}  // namespace apps
