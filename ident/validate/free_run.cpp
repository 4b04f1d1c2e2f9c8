#include "ident/validate/free_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "dsp/filter/strongest_line.hpp"
#include "ident/equation/equation_of_motion.hpp"
#include "ident/switches/interpolant.hpp"
#include "sim/ode/friction.hpp"
#include "sim/simulate.hpp"

namespace ident {
namespace {

using Eigen::Index;

EquationOfMotion equation_on(const Model& model, const dsp::Motion& motion) {
  StateEquation row{.state = 1, .terms = {}, .coefficients = {}};
  for (const ModelTerm& term : model.terms) {
    row.terms.push_back(term.name);
    row.coefficients.push_back(term.mean);
  }
  EquationFrame frame;
  if (model.target == "ddy") frame.states = {"y", "dy"};
  frame.base_moves = motion.find("r") != nullptr;
  for (const dsp::Signal& signal : motion.signals) frame.inputs.push_back(signal.name);
  if (const dsp::Signal* y = motion.find("y")) {  // what was subtracted as the displacement's zero
    Eigen::VectorXd offset = y->values - motion.at("x");
    if (frame.base_moves) offset -= motion.at("r");
    frame.offset_m = offset.mean();
  }
  return EquationOfMotion({std::move(row)}, std::move(frame));
}

/// Why it cannot run; empty: it can.
std::string obstacle(const EquationOfMotion& equation) {
  std::string why;
  for (const std::string& name : equation.signals()) {
    if (name == "a" || name == "ddy")
      why = fmt::format("the equation contains {}, which follows from its own left side", name);
  }
  if (equation.switches().size() > sim::max_switches)
    why = fmt::format("{} switches are more than the {} it can follow", equation.switches().size(), sim::max_switches);
  return why;
}

/// The measured inputs over one range, between their samples.
class Inputs {
 public:
  Inputs(const EquationOfMotion& equation, const dsp::Motion& motion, const dsp::IndexRange& range) {
    const auto over_range = [&](const std::string& name) {
      return Interpolant(motion.at(name), motion.sample_rate_hz, range.first, range.last);
    };
    for (const std::string& name : equation.inputs()) inputs_.push_back(over_range(name));
    if (equation.frame().states[0] != "y") return;
    offset_m_ = equation.frame().offset_m;
    if (equation.frame().base_moves) base_ = over_range("r");
  }
  void at(double t, double* values) const {
    for (const Interpolant& input : inputs_) *values++ = input.at(t);
  }
  /// x from the position that is integrated.
  [[nodiscard]] double x_at(double t, double position) const {
    return position - (base_ ? base_->at(t) : 0.0) - offset_m_;
  }

 private:
  std::vector<Interpolant> inputs_;
  std::optional<Interpolant> base_;  ///< where y is integrated
  double offset_m_ = 0.0;
};

// On average. The fastest sine that samples resolve, two of them a period, takes 23; each switch passed takes some ten
// more. Coefficients in a wrong unit make hundreds and thousands of them.
constexpr double max_steps_per_sample = 100.0;

/// A period in samples, of the motion of the whole record, since a short range holds no line below its own length; 0
/// where there is none.
double period(const Course& course) {
  const Eigen::VectorXd x =
      course.signals->at("x").unaryExpr([](double value) { return std::isfinite(value) ? value : 0.0; });
  const double rate_hz = course.signals->sample_rate_hz,
               line_hz = x.size() < 2 ? 0.0 : dsp::strongest_line(x, rate_hz).frequency_hz;
  return line_hz > 0.0 ? rate_hz / line_hz : 0.0;
}

/// Equal pieces of about this many samples.
std::vector<dsp::IndexRange> pieces(const dsp::IndexRange& range, double most) {
  const auto length = static_cast<double>(range.last - range.first);
  const auto count = static_cast<Index>(std::max(1.0, std::round(length / most)));
  std::vector<dsp::IndexRange> result;
  for (Index i = 0; i < count; ++i)
    result.push_back({range.first + (range.last - range.first) * i / count,
                      range.first + (range.last - range.first) * (i + 1) / count});
  return result;
}

/// Ranges shorter than this, in samples, tell nothing.
double least_length(double period, const FreeRunOptions& options) {
  constexpr double min_samples = 16.0;
  return std::max(min_samples, options.min_periods * period);
}

/// Between these samples.
std::vector<dsp::IndexRange> pieces_between(const dsp::IndexRange& range, const std::vector<Index>& restarts) {
  std::vector<dsp::IndexRange> result{range};
  for (const Index sample : restarts)
    if (sample > result.back().first && sample < range.last) {
      result.back().last = sample;
      result.push_back({sample, range.last});
    }
  return result;
}

/// Squared errors and squared sizes of x, summed over the ranges so far.
struct Tally {
  double error = 0.0, size = 0.0, about_mean = 0.0, count = 0.0;
};

/// What the pieces of one range have in common.
struct WholeRange {
  double position_scale = 0.0, speed_scale = 0.0, mean_x = 0.0;
};

WholeRange whole_range(const EquationOfMotion& equation, const Course& course, const dsp::IndexRange& range) {
  const dsp::Motion& motion = *course.signals;
  const auto of = [&](const std::string& name) {
    return motion.at(name).segment(range.first, range.last - range.first);
  };
  WholeRange result{of(equation.frame().states[0]).cwiseAbs().maxCoeff(),
                    of(equation.frame().states[1]).cwiseAbs().maxCoeff(), 0.0};
  double count = 0.0;
  for (Index i = range.first; i < range.last; ++i)
    if (course.scored[static_cast<std::size_t>(i)] != 0) result.mean_x += motion.at("x")(i), count += 1.0;
  if (count > 0.0) result.mean_x /= count;
  return result;
}

/// Whether the motion came to be held on a switch.
bool sticks(const sim::Simulation& run, int num_switches) {
  std::array<double, sim::max_switches> sides;
  return std::any_of(run.events.begin(), run.events.end(), [&](const sim::Event& event) {
    sim::sides_of(event.mode_after, num_switches, sides.data());
    return std::find(sides.begin(), sides.begin() + num_switches, 0.0) != sides.begin() + num_switches;
  });
}

/// Runs one range, or a piece of the whole; false: `result` says how it ended.
bool run_range(const std::shared_ptr<const EquationOfMotion>& equation, const Course& course,
               const dsp::IndexRange& range, const WholeRange& whole, const FreeRunOptions& options, Tally& tally,
               Eigen::VectorXd* series, FreeRun& result) {
  const dsp::Motion& motion = *course.signals;
  const auto inputs = std::make_shared<const Inputs>(*equation, motion, range);
  const Eigen::VectorXd& position = motion.at(equation->frame().states[0]);
  const Eigen::VectorXd& speed = motion.at(equation->frame().states[1]);
  const Index length = range.last - range.first;
  const double position_scale = whole.position_scale, speed_scale = whole.speed_scale;
  if (!(position_scale > 0.0) || !(speed_scale > 0.0)) {
    result.reason = "x does not move";
    return false;
  }
  const double start_s = static_cast<double>(range.first) / motion.sample_rate_hz;
  const Eigen::Vector2d initial(position(range.first) / position_scale + options.start_error,
                                speed(range.first) / speed_scale);
  sim::SimulateOptions simulate_options{.duration_s = static_cast<double>(length - 1) / motion.sample_rate_hz,
                                        .sample_rate_hz = motion.sample_rate_hz,
                                        .start_s = start_s,
                                        .relative_tolerance = options.relative_tolerance,
                                        .absolute_tolerance = options.relative_tolerance,
                                        .max_steps_per_output = max_steps_per_sample,
                                        .divergence_bound = options.divergence_factor,
                                        .poll = options.poll};
  // Held on a switch nothing moves and steps would grow past the moment it is let go.
  const int num_switches = static_cast<int>(equation->switches().size());
  if (num_switches > 0) simulate_options.max_step_s = 1.0 / motion.sample_rate_hz;
  sim::System system =
      system_of(equation, [inputs](double t, double* values) { inputs->at(t, values); }, {position_scale, speed_scale});
  system.name = "free run";
  const sim::Simulation run = sim::simulate(system, initial, simulate_options);
  result.sticks = result.sticks || sticks(run, num_switches);
  for (Index i = 0; series != nullptr && i < std::min(length, run.time_s.size()); ++i)
    (*series)(range.first + i) = inputs->x_at(run.time_s(i), run.states(i, 0) * position_scale);
  if (run.status != sim::SimulationStatus::finished) {
    result.diverged_after_s = static_cast<double>(run.time_s.size()) / motion.sample_rate_hz;
    const bool spent = run.status == sim::SimulationStatus::step_limit;
    result.reason = fmt::format(
        "{} {:.4g} s after its start at t = {:.6g} s ({})", spent ? "was given up" : "diverged",
        result.diverged_after_s, start_s,
        spent ? fmt::format("it takes more than {:g} steps a sample: the equation is far faster than the record",
                            max_steps_per_sample)
              : run.reason);
    return false;
  }
  for (Index i = 0; i < length; ++i) {
    const Index sample = range.first + i;
    if (course.scored[static_cast<std::size_t>(sample)] == 0) continue;
    const double measured = motion.at("x")(sample);
    const double x = inputs->x_at(run.time_s(i), run.states(i, 0) * position_scale);
    tally.error += (x - measured) * (x - measured);
    tally.size += measured * measured;
    tally.about_mean += (measured - whole.mean_x) * (measured - whole.mean_x);
    tally.count += 1.0;
  }
  return true;
}

/// For how long, in whole windows, a squared difference between two runs of a piece has not grown tenfold in rms over a
/// window, beside the first; all of the piece where it never has.
Index known_length(const Eigen::VectorXd& square, const dsp::IndexRange& piece, Index window) {
  constexpr double grown = 10.0;
  const double first = square.segment(piece.first, std::min(window, piece.last - piece.first)).sum();
  for (Index i = piece.first + window; i + window <= piece.last; i += window)
    if (!(square.segment(i, window).sum() <= grown * grown * first)) return i - piece.first;  // NaN: one diverged
  return piece.last - piece.first;
}

/// Adds restarts where the difference of two runs grows tenfold within a piece; false: it does so nowhere.
bool add_restarts(Course& course, const Eigen::VectorXd& difference, const FreeRunOptions& options) {
  const double cycle = period(course);
  const auto window = static_cast<Index>(std::ceil(cycle));
  if (window < 1) return false;
  const Eigen::VectorXd square = difference.array().square();
  bool added = false;
  std::vector<Index> restarts;
  for (const dsp::IndexRange& range : course.ranges) {
    if (static_cast<double>(range.last - range.first) < least_length(cycle, options)) continue;
    for (const dsp::IndexRange& piece : pieces_between(range, course.restarts)) {
      if (piece.first > range.first) restarts.push_back(piece.first);
      const Index known = known_length(square, piece, window);
      for (Index at = piece.first + known; at + window <= piece.last; at += known) {
        restarts.push_back(at);
        added = true;
      }
    }
  }
  course.restarts = std::move(restarts);
  return added;
}

}  // namespace

FreeRun free_run(const Model& model, const std::vector<Course>& courses, const FreeRunOptions& options) {
  FreeRun result;
  result.nmse = std::numeric_limits<double>::quiet_NaN();
  result.alone = !courses.empty();
  if (model.terms.empty())
    result.reason = "no term was selected";
  else if (model.target != "a" && model.target != "ddy")
    result.reason = fmt::format("an equation for {} is not an equation of motion of x", model.target);
  Tally tally;
  for (const Course& course : courses) {
    if (!result.reason.empty()) return result;
    if (options.keep_series) {
      const Eigen::VectorXd& measured = course.signals->at("x");
      result.series.push_back({course.recording, Eigen::VectorXd::Constant(measured.size(), result.nmse), measured});
    }
    const auto equation = std::make_shared<const EquationOfMotion>(
        equation_on(equation_of(model, static_cast<int>(course.recording) + 1), *course.signals));
    result.reason = obstacle(*equation);
    if (!result.reason.empty()) return result;
    const double cycle = period(course), least = least_length(cycle, options);
    const bool alone = equation->inputs().empty() && !(equation->frame().base_moves && model.target == "ddy");
    result.alone = result.alone && alone;
    const double most =
        alone && cycle > 0.0 ? std::max(least, options.periods_alone * cycle) : std::numeric_limits<double>::infinity();
    const bool restarts = !alone && !course.restarts.empty();
    for (const dsp::IndexRange& range : course.ranges) {
      if (static_cast<double>(range.last - range.first) < least) continue;
      ++result.num_ranges;
      const WholeRange whole = whole_range(*equation, course, range);
      const std::vector<dsp::IndexRange> parts =
          restarts ? pieces_between(range, course.restarts) : pieces(range, most);
      if (restarts) result.num_restarts += static_cast<int>(parts.size()) - 1;
      for (const dsp::IndexRange& piece : parts) {
        const double rate_hz = course.signals->sample_rate_hz;
        result.starts.push_back(
            {course.recording, static_cast<double>(piece.first) / rate_hz, static_cast<double>(piece.last) / rate_hz});
        if (!run_range(equation, course, piece, whole, options, tally,
                       options.keep_series ? &result.series.back().predicted : nullptr, result))
          return result;
      }
    }
  }
  if (result.num_ranges == 0) {
    result.reason = fmt::format("no test interval without a gap is {:g} period{} long", options.min_periods,
                                options.min_periods == 1.0 ? "" : "s");
  } else if (!(tally.size > 0.0)) {
    result.reason = "x is zero over the test rows";
  } else {
    result.nmse = tally.error / tally.size;
    result.mean_square = tally.about_mean / tally.count;
    if (tally.about_mean > 0.0) result.nmse_centred = tally.error / tally.about_mean;
  }
  return result;
}

RestartedRun restarted_run(const Model& model, std::vector<Course> courses, FreeRunOptions options) {
  constexpr double start_error = 1e-4;  // small beside what it grows to, large beside the error of a step
  constexpr int most_rounds = 8;        // each shortens pieces to what their own growth allows
  options.keep_series = true;
  RestartedRun found{free_run(model, courses, options), courses};
  FreeRun run = found.run;
  for (int round = 0; round < most_rounds && !run.alone && run.reason.empty() && found.run.nmse_centred > follows;
       ++round) {
    options.start_error = start_error;
    const FreeRun moved = free_run(model, courses, options);
    options.start_error = 0.0;
    bool added = false;
    for (std::size_t c = 0; c < moved.series.size(); ++c)
      added = add_restarts(courses[c], moved.series[c].predicted - run.series[c].predicted, options) || added;
    if (!added) break;
    run = free_run(model, courses, options);
  }
  if (run.reason.empty() && run.num_restarts > 0) found = {std::move(run), std::move(courses)};
  return found;
}

}  // namespace ident
