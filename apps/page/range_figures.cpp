#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "apps/page/evidence_figures.hpp"
#include "apps/page/figures.hpp"
#include "apps/page/power_spectrum.hpp"
#include "dsp/filter/strongest_line.hpp"
#include "dsp/values/constants.hpp"
#include "dsp/values/names.hpp"
#include "ident/library/expression.hpp"

namespace apps {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

using dsp::nan;
constexpr Index most_cloud_points = 2000;  // of a cloud

/// The rows of a range on one clock: the recordings one behind the other, from its first row to its last.
class RangeClock {
 public:
  RangeClock(const ident::RangeResult& range, const std::vector<ident::Columns>& columns)
      : range_(range), columns_(columns) {
    double start_s = 0.0;
    for (const ident::Columns& recording : columns) {
      starts_s_.push_back(start_s);
      start_s += static_cast<double>(recording.signals->num_samples()) / recording.signals->sample_rate_hz;
      bounds_.push_back({std::numeric_limits<Index>::max(), -1});
    }
    for (const auto* rows : {&range.rows.train, &range.rows.test})
      for (const ident::Row& row : *rows) {
        dsp::IndexRange& bound = bounds_[row.recording];
        bound.first = std::min(bound.first, row.sample);
        bound.last = std::max(bound.last, row.sample);
      }
    for (std::size_t r = 0; r < bounds_.size(); ++r) {
      firsts_.push_back(size_);
      if (bounds_[r].last >= bounds_[r].first) size_ += bounds_[r].last - bounds_[r].first + 1;
    }
  }

  [[nodiscard]] VectorXd times_s() const {
    VectorXd times(size_);
    for (std::size_t r = 0; r < bounds_.size(); ++r)
      for (Index i = bounds_[r].first; i <= bounds_[r].last; ++i)
        times(firsts_[r] + i - bounds_[r].first) =
            starts_s_[r] + static_cast<double>(i) / columns_[r].signals->sample_rate_hz;
    return times;
  }
  /// A value per row of the range (training, then test rows) on the clock; NaN between.
  [[nodiscard]] VectorXd on_clock(const Eigen::Ref<const VectorXd>& values) const {
    VectorXd result = VectorXd::Constant(size_, nan);
    const auto num_train = static_cast<Index>(range_.rows.train.size());
    for (Index i = 0; i < values.size(); ++i) {
      const ident::Row& row = i < num_train ? range_.rows.train[static_cast<std::size_t>(i)]
                                            : range_.rows.test[static_cast<std::size_t>(i - num_train)];
      result(firsts_[row.recording] + row.sample - bounds_[row.recording].first) = values(i);
    }
    return result;
  }
  /// A value per sample of one recording.
  void put(std::size_t recording, const VectorXd& values, VectorXd& on) const {
    const dsp::IndexRange& bound = bounds_[recording];
    for (Index i = bound.first; i <= bound.last; ++i) on(firsts_[recording] + i - bound.first) = values(i);
  }
  [[nodiscard]] double start_s(std::size_t recording) const { return starts_s_[recording]; }
  [[nodiscard]] Index size() const { return size_; }

 private:
  const ident::RangeResult& range_;
  const std::vector<ident::Columns>& columns_;
  std::vector<double> starts_s_;
  std::vector<dsp::IndexRange> bounds_;  ///< samples [first, last]
  std::vector<Index> firsts_;
  Index size_ = 0;
};

/// Indices of at most so many of n, spread without a period that a signal could share (steps of the golden ratio).
std::vector<Index> scattered(Index n, Index most) {
  std::vector<Index> chosen;
  if (n <= most) {
    for (Index i = 0; i < n; ++i) chosen.push_back(i);
    return chosen;
  }
  for (Index i = 0; i < most; ++i)
    chosen.push_back(static_cast<Index>(std::fmod(static_cast<double>(i) * (std::numbers::phi - 1.0), 1.0) *
                                        static_cast<double>(n)));
  std::sort(chosen.begin(), chosen.end());
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  return chosen;
}

std::string axis(const std::string& what, const std::string& unit) {
  return unit.empty() ? what + " (no unit)" : fmt::format("{} ({})", what, unit);
}

/// What all figures of a range are made from.
struct RangeView {
  const ident::RangeResult& range;
  const RunResults& results;
  const ident::JudgedFit& fit;
  const RangeClock& clock;
  VectorXd times_s, residual;  ///< residual: training, then test rows
  std::string slug, title;
  std::optional<std::pair<double, double>> residual_limits = limits_of_most(residual);

  [[nodiscard]] const dsp::Motion& signals() const {
    return *results.columns[range.rows.train.front().recording].signals;
  }
  [[nodiscard]] std::string unit(const std::string& name) const {
    const dsp::Signal* signal = signals().find(name);
    return signal == nullptr ? std::string() : signal->unit;
  }
  /// The signal on training and test rows.
  [[nodiscard]] VectorXd on_rows(const std::string& name) const {
    VectorXd values(range.target.size());
    Index i = 0;
    for (const auto* rows : {&range.rows.train, &range.rows.test})
      for (const ident::Row& row : *rows) values(i++) = results.columns[row.recording].signals->at(name)(row.sample);
    return values;
  }
  [[nodiscard]] std::string target_axis() const { return axis(fit.model.target, fit.model.target_unit); }
  [[nodiscard]] std::string residual_axis() const {
    return axis("residual of " + fit.model.target, fit.model.target_unit);
  }
  [[nodiscard]] std::vector<PlotSpan> train_and_test() const {
    std::vector<PlotSpan> spans;
    const bool one = results.columns.size() == 1 || range.recording > 0;
    if (!one) return spans;  // intervals do not say of which recording they are
    const double start_s = clock.start_s(range.recording > 0 ? static_cast<std::size_t>(range.recording) - 1 : 0);
    for (const dsp::Interval& part : range.rows.train_s)
      spans.push_back({start_s + part.from_s, start_s + part.to_s, "train", PlotColour::sky});
    for (const dsp::Interval& part : range.rows.test_s)
      spans.push_back({start_s + part.from_s, start_s + part.to_s, "test", PlotColour::orange});
    return spans;
  }
};

/// Of the strongest line of a signal, NaN where it is too short to have one.
double period_s(const RangeView& view, const VectorXd& values) {
  if (values.size() < 16) return nan;
  const VectorXd filled = values.unaryExpr([](double value) { return std::isfinite(value) ? value : 0.0; });
  return 1.0 / dsp::strongest_line(filled, view.signals().sample_rate_hz).frequency_hz;
}

PlotFigure target_figure(const RangeView& view) {
  PlotPanel panel{"measured and identified", "time (s)", view.target_axis()};
  panel.series = {
      {"measured", view.times_s, view.clock.on_clock(view.range.target), PlotStyle::line, PlotColour::black, true},
      {"identified", view.times_s, view.clock.on_clock(view.fit.predicted), PlotStyle::dashed, PlotColour::vermilion}};
  panel.spans = view.train_and_test();
  const auto first_test =
      std::find_if(panel.spans.begin(), panel.spans.end(), [](const PlotSpan& span) { return span.label == "test"; });
  panel.x_limits =
      some_periods(period_s(view, panel.series.front().y), view.times_s,
                   first_test != panel.spans.end() ? first_test->from : view.times_s(view.times_s.size() / 2));
  return chart(view.slug + "-target",
               fmt::format("{} measured and identified in {}. Shaded: fitted (train) and not fitted (test).{}",
                           view.fit.model.target, view.title, panel.x_limits ? " Some periods are shown." : ""),
               std::move(panel));
}

std::optional<PlotFigure> free_run_figure(const RangeView& view) {
  const ident::FreeRun& run = view.fit.free_run;
  // The series of a run that several methods share are with the first of them.
  const auto holder = std::find_if(view.range.fits.begin(), view.range.fits.end(), [&](const ident::JudgedFit& other) {
    const ident::FreeRun& own = other.free_run;
    return !own.series.empty() && own.reason == run.reason &&
           (own.nmse == run.nmse || (std::isnan(run.nmse) && ident::same_equation(other.model, view.fit.model)));
  });
  const bool has_own = !run.series.empty();
  if (!has_own && holder == view.range.fits.end()) return {};
  VectorXd measured = VectorXd::Constant(view.clock.size(), nan), predicted = measured;
  for (const ident::FreeRunSeries& one : (has_own ? view.fit : *holder).free_run.series) {
    VectorXd shown = one.measured;
    for (Index i = 0; i < shown.size(); ++i)
      if (!std::isfinite(one.predicted(i))) shown(i) = nan;
    view.clock.put(one.recording, shown, measured);
    view.clock.put(one.recording, one.predicted, predicted);
  }
  Index first = 0, last = measured.size();
  while (first < last && !std::isfinite(predicted(first))) ++first;
  while (last > first && !std::isfinite(predicted(last - 1))) --last;
  if (first == last) return {};
  const VectorXd times = view.times_s.segment(first, last - first);
  PlotPanel panel{"free run on data not fitted", "time (s)", axis("x", view.unit("x"))};
  panel.series = {
      {"measured", times, measured.segment(first, last - first), PlotStyle::line, PlotColour::black, true},
      {"free run", times, predicted.segment(first, last - first), PlotStyle::dashed, PlotColour::vermilion, true}};
  panel.x_limits = some_periods(period_s(view, panel.series.front().y), times, times(times.size() - 1));
  PlotFigure figure = chart(
      view.slug + "-free-run",
      fmt::format("Free run of the equation beside the measured x, on data of {} that were not fitted, and what is "
                  "between them. It starts from the measured state at the beginning of each interval and is "
                  "integrated with the measured inputs alone ({}).{}",
                  view.title, run.reason.empty() ? fmt::format("NMSE {:.2g}", run.nmse_centred) : run.reason,
                  panel.x_limits ? " The last periods are shown, where an error of phase would have grown." : ""),
      std::move(panel));
  add_error_panel(figure);
  return figure;
}

PlotFigure residual_figure(const RangeView& view) {
  PlotPanel panel{"residual: measured less identified", "time (s)", view.residual_axis()};
  panel.series = {{"residual", view.times_s, view.clock.on_clock(view.residual), PlotStyle::line, PlotColour::blue}};
  panel.spans = view.train_and_test();
  panel.y_limits = view.residual_limits;
  return chart(view.slug + "-residual",
               fmt::format("Measured less identified {}, sample by sample, in {}.", view.fit.model.target, view.title),
               std::move(panel));
}

std::optional<PlotFigure> spectrum_figure(const RangeView& view) {
  const double rate_hz = view.signals().sample_rate_hz;
  const auto target = power_spectrum_db(view.clock.on_clock(view.range.target), rate_hz),
             residual = power_spectrum_db(view.clock.on_clock(view.residual), rate_hz);
  if (target.frequency_hz.size() == 0 || residual.frequency_hz.size() == 0) return {};
  PlotPanel panel{"spectra of target and residual", "frequency (Hz)",
                  fmt::format("power density (dB re 1 ({})^2/Hz)", view.fit.model.target_unit)};
  panel.series = {{"measured", target.frequency_hz, target.power_db, PlotStyle::line, PlotColour::black},
                  {"residual", residual.frequency_hz, residual.power_db, PlotStyle::dashed, PlotColour::blue}};
  constexpr double beyond_band = 1.25;
  const double band_hz = view.results.columns[view.range.rows.train.front().recording].band_hz;
  if (band_hz > 0.0 && beyond_band * band_hz < 0.45 * rate_hz)
    panel.x_limits = {target.frequency_hz(0), beyond_band * band_hz};
  panel.x_log = true;
  return chart(
      view.slug + "-spectrum",
      fmt::format("Power spectra in {}. Where the residual is as high as the target, the equation explains none of it.",
                  view.title),
      std::move(panel));
}

/// Points, thinned.
PlotSeries points(const std::string& label, const VectorXd& x, const VectorXd& y, PlotColour colour) {
  const std::vector<Index> chosen = scattered(x.size(), most_cloud_points);
  return {label, x(chosen), y(chosen), PlotStyle::points, colour};
}

void add_residual_clouds(const RangeView& view, const FigureTaker& take) {
  for (const dsp::Signal& signal : view.signals().signals) {
    const bool of_interest = signal.name == "x" || signal.name == "v" || ident::acts_from_outside(signal);
    if (!of_interest || signal.name == view.fit.model.target) continue;
    PlotPanel panel{"residual against " + signal.name,
                    axis(signal.name, signal.unit),
                    view.residual_axis(),
                    {points("", view.on_rows(signal.name), view.residual, PlotColour::blue)}};
    panel.y_limits = view.residual_limits;
    take(cloud(
        fmt::format("{}-residual-{}", view.slug, dsp::slug(signal.name)),
        fmt::format("Residual against {}. It should have no shape: a curve or a step is a missing term.", signal.name),
        std::move(panel)));
  }
}

PlotFigure phase_figure(const RangeView& view) {
  return cloud(
      view.slug + "-phase",
      fmt::format(
          "States (x, v) in the data of {}. Between them the equation is tested; beyond them it is an extrapolation.",
          view.title),
      {"phase portrait",
       axis("x", view.unit("x")),
       axis("v", view.unit("v")),
       {points("", view.on_rows("x"), view.on_rows("v"), PlotColour::black)}});
}

/// Sum of the terms in x and v alone, as they act against the motion; `at_rest`: y and dy are these, too.
VectorXd restoring_force(const ident::Model& model, const VectorXd& x, const VectorXd& v, bool at_rest) {
  const double sign = model.target == "a" || model.target == "ddy" ? -1.0 : 1.0;
  VectorXd sum = VectorXd::Zero(x.size());
  dsp::Motion motion;
  motion.signals = {{"x", "", x}, {"v", "", v}};
  if (at_rest) motion.signals.insert(motion.signals.end(), {{"y", "", x}, {"dy", "", v}});
  for (const ident::ModelTerm& term : model.terms) {
    const ident::Expression expression(term.name);
    const auto& names = expression.signals();
    if (!names.empty() &&
        std::all_of(names.begin(), names.end(), [&](const std::string& name) { return motion.find(name) != nullptr; }))
      sum += sign * term.mean * expression.evaluate(motion);
  }
  return sum;
}

VectorXd grid_over(const VectorXd& values) {
  constexpr Index points = 401;
  return VectorXd::LinSpaced(points, values.minCoeff(), values.maxCoeff());
}

/// The part of the restoring force that x alone makes, and that with v: identified as a line, measured as that plus
/// what the equation leaves.
void add_restoring_force(const RangeView& view, const FigureTaker& take) {
  const ident::Model model = equation_of(view.fit.model, 0);
  const char* of_mean =
      differs_by_recording(view.fit.model) ? " Of coefficients that differ by recording, with their mean." : "";
  const VectorXd x = view.on_rows("x"), v = view.on_rows("v"), still = VectorXd::Zero(x.size());
  const double sign = model.target == "a" || model.target == "ddy" ? -1.0 : 1.0;
  const bool at_rest = base_at_rest(view.signals());
  const VectorXd spring = restoring_force(model, x, still, at_rest), both = restoring_force(model, x, v, at_rest);
  const VectorXd left = sign * view.residual;
  if (!both.allFinite() || both.isZero(0.0)) return;
  const std::string what = sign < 0.0 ? "restoring force per mass" : "restoring force";
  const auto add = [&](const char* signal, const VectorXd& at, const VectorXd& force, const VectorXd& line_x,
                       const VectorXd& line, const std::string& caption) {
    if (force.isZero(0.0)) return;
    take(cloud(fmt::format("{}-force-{}", view.slug, signal), caption + of_mean,
               {fmt::format("{} against {}", what, signal),
                axis(signal, view.unit(signal)),
                axis(what, model.target_unit),
                {points("measured", at, force + left, PlotColour::sky),
                 {"identified", line_x, line, PlotStyle::line, PlotColour::vermilion}}}));
  };
  const VectorXd grid_x = grid_over(x), grid_v = grid_over(v), none = VectorXd::Zero(grid_x.size());
  add("x", x, spring, grid_x, restoring_force(model, grid_x, none, at_rest),
      "The spring. Line: identified force at v = 0. Points: the same with the residual of each sample added, so that "
      "their distance from the line is the residual.");
  add("v", v, both - spring, grid_v,
      restoring_force(model, none, grid_v, at_rest) - restoring_force(model, none, none, at_rest),
      "Damping and friction. Line: identified force at x = 0. Points: the same at the measured x, with the residual of "
      "each sample added.");
}

/// Two ranges may differ by what a file name cannot hold, "low+" and "low-".
std::string range_slug(const ident::RangeResult& range, const RunResults& results) {
  return range_prefix(static_cast<std::size_t>(&range - results.ranges.data())) + dsp::slug(range.spec.name);
}

}  // namespace

void range_figures(const ident::RangeResult& range, const RunResults& results, const FigureTaker& take) {
  const ChosenEquation chosen = chosen_equation(range);
  if (chosen.fit == nullptr) return;
  const RangeClock clock(range, results.columns);
  const RangeView view{range,
                       results,
                       *chosen.fit,
                       clock,
                       clock.times_s(),
                       range.target - chosen.fit->predicted,
                       range_slug(range, results),
                       range.spec.name};
  const auto answering = [&](Question question) {
    return [&take, question](PlotFigure figure) {
      figure.question = question;
      take(std::move(figure));
    };
  };
  const auto take_if_any = [](const FigureTaker& taker, std::optional<PlotFigure> figure) {
    if (figure) taker(std::move(*figure));
  };
  const bool has_states = view.signals().find("x") != nullptr && view.signals().find("v") != nullptr;
  const FigureTaker follows = answering(Question::follows), left_over = answering(Question::left_over);
  take_if_any(follows, free_run_figure(view));
  follows(target_figure(view));
  if (has_states) follows(phase_figure(view));
  take_if_any(left_over, spectrum_figure(view));
  left_over(residual_figure(view));
  add_residual_clouds(view, left_over);
  if (has_states) add_restoring_force(view, answering(Question::coefficients));
  evidence_figures(*chosen.fit, view.slug, answering(Question::choice));
}

}  // namespace apps
