#include <fmt/format.h>

#include <algorithm>

#include "apps/output/response_report.hpp"
#include "apps/output/svg_plot.hpp"
#include "apps/paper/section5_output.hpp"
#include "apps/process/interrupt.hpp"
#include "sim/ode/frequency_response.hpp"

namespace apps {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Every n-th value, so that no more than `most` are left.
VectorXd thinned(const VectorXd& values, Index most) {
  const Index step = (values.size() + most - 1) / most;
  return values(Eigen::seqN(0, (values.size() + step - 1) / step, step));
}

std::pair<double, double> with_room(const VectorXd& values) {
  const double low = values.minCoeff(), high = values.maxCoeff(), size = high - low;
  return {low - 0.08 * size, high + 0.36 * size};  // the legend's place
}

}  // namespace

std::string section5_sweeps_figure() {
  PlotFigure figure;
  figure.title = "Response to a sinusoidal base motion of 4.5 mm (Fig. 11)";
  figure.name = "fig-11";
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
  return to_svg(figure);
}

std::string section5_states_figure(const Section5Replication& replication) {
  constexpr Index most_points = 3000;
  PlotFigure figure;
  figure.title = "Measured states of the regimes, twin T1 (Fig. 12)";
  figure.name = "fig-12";
  figure.columns = 3;
  figure.panel_width_px = 380.0;
  for (const Section5States& states : replication.states) {
    const std::string name = states.definition->regime + " amplitude";
    const char *time = "time (s)", *x = "displacement x (m)", *v = "velocity v (m/s)";
    figure.panels.push_back({name, time, x, {{"", states.time_s, states.x}}, {}, {}});
    figure.panels.push_back(
        {name, time, v, {{"", states.time_s, states.v, PlotStyle::line, PlotColour::blue}}, {}, {}});
    figure.panels.push_back(
        {name,
         x,
         v,
         {{"", thinned(states.x, most_points), thinned(states.v, most_points), PlotStyle::points, PlotColour::green}},
         {},
         {}});
  }
  figure.caption = {
      fmt::format("By the paper's recipe at 25.6 Hz. Right: at most {} samples of each regime.", most_points)};
  return to_svg(figure);
}

std::string section5_responses_figure(const Section5Replication& replication) {
  constexpr double zoom_s = 8.0;
  PlotFigure figure;
  figure.title = "Measured and identified acceleration, twin T1 by the paper's recipe, F-RVM (Fig. 13)";
  figure.name = "fig-13";
  for (const Section5States& states : replication.states) {
    const auto fit = std::find_if(replication.fits.begin(), replication.fits.end(), [&](const Section5Fit& one) {
      return one.definition == states.definition && one.candidates == paper_candidates &&
             one.way == section5_ways().data();
    });
    const ident::JudgedFit& judged = fit->result.fits.front();
    const std::string name = states.definition->regime + " amplitude";
    const double split_s = states.definition->train_to_s;
    const auto num_train = static_cast<Index>(fit->result.rows.train.size());
    const Index zoom = std::min<Index>(states.time_s.size() - num_train, static_cast<Index>(zoom_s * 25.6));
    const std::pair<double, double> limits = with_room(fit->result.target);
    const PlotSeries split{"train | test", Eigen::Vector2d(split_s, split_s),
                           Eigen::Vector2d(limits.first, limits.second), PlotStyle::line, PlotColour::blue};
    const auto panel = [&](Index first, Index count, PlotSeries other) {
      return PlotPanel{name,
                       "time (s)",
                       "acceleration (m/s\u00b2)",
                       {{"measured", states.time_s.segment(first, count), fit->result.target.segment(first, count)},
                        std::move(other)},
                       {},
                       limits};
    };
    figure.panels.push_back(panel(0, states.time_s.size(),
                                  {"measured - identified", states.time_s, fit->result.target - judged.predicted,
                                   PlotStyle::line, PlotColour::vermilion}));
    figure.panels.back().series.push_back(split);
    figure.panels.push_back(
        panel(num_train, zoom,
              {"identified", states.time_s.segment(num_train, zoom), judged.predicted.segment(num_train, zoom),
               PlotStyle::dashed, PlotColour::vermilion}));
    for (const PaperErrors& paper : paper_errors())
      if (paper.table == states.definition->table)
        figure.caption.push_back(fmt::format(
            "{}: NMSE train {:.4f}, test {:.4f}; the paper's {:.4f}, {:.4f}; free run over the test rows {}", name,
            judged.train.value, judged.test.value, paper.train[0], paper.test[0],
            judged.free_run.reason.empty() ? fmt::format("{:.2g}", judged.free_run.nmse) : judged.free_run.reason));
  }
  figure.caption.push_back(fmt::format("Right: the first {:g} s of the test rows.", zoom_s));
  return to_svg(figure);
}

}  // namespace apps
