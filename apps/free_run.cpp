#include "apps/free_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <optional>

#include "apps/interpolant.hpp"
#include "apps/process/interrupt.hpp"
#include "dsp/filter/fft.hpp"
#include "ident/library/expression.hpp"
#include "sim/simulate.hpp"

namespace apps {
namespace {

using Eigen::Index;

constexpr int max_switches = 12;  // 3^12 modes

/// Which side of each switch the motion is on: -1, 0 (held on it), 1.
using Signs = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_switches, 1>;

/// An expression of the model, with the places of its signals and switches among those of the whole equation.
struct Part {
  ident::Expression expression;
  double coefficient = 0.0;
  std::vector<std::size_t> signals, switches;
};

/// The identified equation as accelerations of (position, speed): of x where the target is a, of y where it is ddy.
class Equation {
 public:
  Equation(const ident::Model& model, const dsp::Motion& motion);
  /// Makes the measured inputs available over samples [first, last).
  void cover(Index first, Index last);
  [[nodiscard]] double acceleration(double t, const double* state, const Signs& signs) const;
  [[nodiscard]] double switch_value(std::size_t i, double t, const double* state) const;
  /// d/dt of switch i where it is a velocity (then a switch can hold the motion); `signs` of all switches.
  [[nodiscard]] double switch_rate(std::size_t i, double t, const double* state, const Signs& signs) const;
  [[nodiscard]] bool can_hold(std::size_t i) const { return holds_[i] != Holds::nothing; }
  /// Acceleration that keeps switch i at zero, and the speed at which it is.
  [[nodiscard]] double held_acceleration(std::size_t i, double t) const {
    return hold_sign(i) == 0.0 ? 0.0 : hold_sign(i) * input("ddr", t);
  }
  [[nodiscard]] double held_speed(std::size_t i, double t) const {
    return hold_sign(i) == 0.0 ? 0.0 : hold_sign(i) * input("dr", t);
  }
  [[nodiscard]] std::size_t num_switches() const { return switches_.size(); }
  [[nodiscard]] bool of_payload() const { return of_payload_; }
  /// x from the position.
  [[nodiscard]] double x_at(double t, double position) const;
  [[nodiscard]] const std::string& trouble() const { return trouble_; }

 private:
  enum class Holds { nothing, own_speed, other_speed };
  enum class Source { time, relative_position, relative_speed, absolute_position, absolute_speed, measured };
  [[nodiscard]] static Source source_of(const std::string& name);
  Part make_part(const std::string& text, double coefficient, const std::vector<std::string>& names);
  [[nodiscard]] double hold_sign(std::size_t i) const {
    return holds_[i] == Holds::own_speed ? 0.0 : of_payload_ ? 1.0 : -1.0;
  }
  [[nodiscard]] double input(const std::string& name, double t) const {
    const auto found = inputs_.find(name);
    return found == inputs_.end() ? 0.0 : found->second.at(t);
  }
  [[nodiscard]] double value_of(std::size_t signal, double t, const double* state) const;
  void evaluate_signals(double t, const double* state) const;
  [[nodiscard]] double evaluate(const Part& part, const Signs& signs) const;

  const dsp::Motion* motion_;
  bool of_payload_, has_base_;
  double offset_ = 0.0;  ///< y - r - x: what was subtracted as the displacement's zero
  std::vector<std::string> signals_, switch_names_;
  std::vector<Source> sources_;               ///< of each signal
  std::vector<const Interpolant*> measured_;  ///< of each signal, where that is its source
  std::vector<Part> terms_, switches_;
  std::vector<Holds> holds_;
  std::map<std::string, Interpolant, std::less<>> inputs_;
  std::string trouble_;
  mutable std::vector<double> values_, part_values_, part_signs_;  ///< scratch of one evaluation
};

template <class T>
std::size_t place_of(std::vector<T>& known, const T& wanted) {
  const auto found = std::find(known.begin(), known.end(), wanted);
  if (found != known.end()) return static_cast<std::size_t>(found - known.begin());
  known.push_back(wanted);
  return known.size() - 1;
}

Equation::Equation(const ident::Model& model, const dsp::Motion& motion)
    : motion_(&motion), of_payload_(model.target == "ddy"), has_base_(motion.find("r") != nullptr) {
  if (model.target != "a" && model.target != "ddy") {
    trouble_ = fmt::format("an equation for {} is not an equation of motion of x", model.target);
    return;
  }
  std::vector<std::string> names;
  for (const dsp::Signal& signal : motion.signals) names.push_back(signal.name);
  for (const ident::ModelTerm& term : model.terms) terms_.push_back(make_part(term.name, term.mean, names));
  for (std::size_t i = 0; i < switch_names_.size(); ++i) {  // make_part may not be given a switch inside a switch
    const std::string text = switch_names_[i];
    switches_.push_back(make_part(text, 1.0, names));
    const bool own = text == (of_payload_ ? "dy" : "v"), other = text == (of_payload_ ? "v" : "dy");
    holds_.push_back(own || (other && !has_base_) ? Holds::own_speed : other ? Holds::other_speed : Holds::nothing);
  }
  for (const std::string& name : signals_) {
    if (name == "a" || name == "ddy")
      trouble_ = fmt::format("the equation contains {}, which follows from its own left side", name);
    if (name == "z") trouble_ = "z has no equation of its own here";
  }
  if (switches_.size() > max_switches)
    trouble_ = fmt::format("{} switches are more than the {} it can follow", switches_.size(), max_switches);
  if (const dsp::Signal* y = motion.find("y")) {
    Eigen::VectorXd offset = y->values - motion.at("x");
    if (has_base_) offset -= motion.at("r");
    offset_ = offset.mean();
  }
  values_.resize(signals_.size());
}

Part Equation::make_part(const std::string& text, double coefficient, const std::vector<std::string>& names) {
  Part part{ident::Expression(text, names), coefficient, {}, {}};
  for (const std::string& signal : part.expression.signals()) part.signals.push_back(place_of(signals_, signal));
  for (const std::string& name : part.expression.switches()) part.switches.push_back(place_of(switch_names_, name));
  return part;
}

void Equation::cover(Index first, Index last) {
  inputs_.clear();
  const auto add = [&](const std::string& name) {
    if (const dsp::Signal* signal = motion_->find(name))
      inputs_.insert_or_assign(name, Interpolant(signal->values, motion_->sample_rate_hz, first, last));
  };
  const bool needs_base = of_payload_ || std::find(holds_.begin(), holds_.end(), Holds::other_speed) != holds_.end() ||
                          std::any_of(signals_.begin(), signals_.end(),
                                      [](const std::string& name) { return name == "y" || name == "dy"; });
  if (has_base_ && needs_base)
    for (const char* name : {"r", "dr", "ddr"}) add(name);
  sources_.clear();
  measured_.clear();
  for (const std::string& name : signals_) {
    sources_.push_back(source_of(name));
    if (sources_.back() == Source::measured && inputs_.find(name) == inputs_.end()) add(name);
    const auto input = inputs_.find(name);
    measured_.push_back(input == inputs_.end() ? nullptr : &input->second);
  }
}

Equation::Source Equation::source_of(const std::string& name) {
  if (name == "t") return Source::time;
  if (name == "x") return Source::relative_position;
  if (name == "v") return Source::relative_speed;
  if (name == "y") return Source::absolute_position;
  return name == "dy" ? Source::absolute_speed : Source::measured;
}

double Equation::value_of(std::size_t signal, double t, const double* state) const {
  switch (sources_[signal]) {
    case Source::time:
      return t;
    case Source::relative_position:
      return x_at(t, state[0]);
    case Source::relative_speed:
      return of_payload_ ? state[1] - input("dr", t) : state[1];
    case Source::absolute_position:
      return of_payload_ ? state[0] : state[0] + input("r", t) + offset_;
    case Source::absolute_speed:
      return of_payload_ ? state[1] : state[1] + input("dr", t);
    case Source::measured:
      break;
  }
  return measured_[signal] == nullptr ? 0.0 : measured_[signal]->at(t);
}

double Equation::x_at(double t, double position) const {
  return of_payload_ ? position - input("r", t) - offset_ : position;
}

void Equation::evaluate_signals(double t, const double* state) const {
  for (std::size_t i = 0; i < signals_.size(); ++i) values_[i] = value_of(i, t, state);
}

double Equation::evaluate(const Part& part, const Signs& signs) const {
  part_values_.resize(part.signals.size());
  part_signs_.resize(part.switches.size());
  for (std::size_t i = 0; i < part.signals.size(); ++i) part_values_[i] = values_[part.signals[i]];
  for (std::size_t i = 0; i < part.switches.size(); ++i) part_signs_[i] = signs[part.switches[i]];
  return part.expression.evaluate(part_values_.data(), part_signs_.data());
}

double Equation::acceleration(double t, const double* state, const Signs& signs) const {
  evaluate_signals(t, state);
  double sum = 0.0;
  for (const Part& term : terms_) sum += term.coefficient * evaluate(term, signs);
  return sum;
}

double Equation::switch_value(std::size_t i, double t, const double* state) const {
  evaluate_signals(t, state);
  return evaluate(switches_[i], {});
}

double Equation::switch_rate(std::size_t i, double t, const double* state, const Signs& signs) const {
  return acceleration(t, state, signs) - held_acceleration(i, t);
}

/// The sides of all switches, coded as a whole number to the base 3.
Signs signs_of(int mode, std::size_t num_switches) {
  Signs signs(static_cast<Index>(num_switches));
  for (double& sign : signs) {
    sign = mode % 3 - 1;
    mode /= 3;
  }
  return signs;
}

int mode_of(const Signs& signs) {
  int mode = 0;
  for (Index i = signs.size(); i-- > 0;) mode = 3 * mode + static_cast<int>(signs[i]) + 1;
  return mode;
}

/// Where the motion goes from switch i: back onto it from both sides (Filippov: it is held, 0), or to one side.
double side_after(const Equation& equation, std::size_t i, double t, const double* state, Signs signs) {
  const double before = signs[i];
  if (!equation.can_hold(i)) {
    const double value = equation.switch_value(i, t, state);
    return value > 0.0 ? 1.0 : value < 0.0 ? -1.0 : -before;
  }
  signs[i] = 1.0;
  const double above = equation.switch_rate(i, t, state, signs);
  signs[i] = -1.0;
  const double below = equation.switch_rate(i, t, state, signs);
  if (above < 0.0 && below > 0.0) return 0.0;
  if (above > 0.0 && below < 0.0) return -before;  // both sides push away: it goes on as it came
  return above > 0.0 ? 1.0 : -1.0;
}

/// The equation with its switches as a system to integrate; states are scaled by their largest measured magnitudes.
sim::System switched_system(const std::shared_ptr<const Equation>& equation, double position_scale,
                            double speed_scale) {
  const std::size_t num = equation->num_switches();
  const auto physical = [=](const double* y) { return std::array{y[0] * position_scale, y[1] * speed_scale}; };
  sim::System system;
  system.name = "free run";
  system.states = {equation->of_payload() ? "y" : "x", equation->of_payload() ? "dy" : "v"};
  system.rhs = [=](double t, const double* y, int mode, double* dydt) {
    const auto state = physical(y);
    const Signs signs = signs_of(mode, num);
    const auto held = std::find(signs.begin(), signs.end(), 0.0);
    dydt[0] = state[1] / position_scale;
    dydt[1] = (held == signs.end() ? equation->acceleration(t, state.data(), signs)
                                   : equation->held_acceleration(static_cast<std::size_t>(held - signs.begin()), t)) /
              speed_scale;
  };
  if (num == 0) return system;
  system.num_switches = static_cast<int>(2 * num);
  // Off a switch: its own value. On it: what either side would do; when one stops pushing back, the motion leaves
  // there.
  system.switching = [=](double t, const double* y, int mode, double* values) {
    const auto state = physical(y);
    const Signs signs = signs_of(mode, num);
    for (std::size_t i = 0; i < num; ++i) {
      Signs side = signs;
      const bool on = signs[i] == 0.0;
      side[i] = 1.0;
      values[2 * i] = on ? equation->switch_rate(i, t, state.data(), side) : equation->switch_value(i, t, state.data());
      side[i] = -1.0;
      values[2 * i + 1] = on ? equation->switch_rate(i, t, state.data(), side) : 1.0;
    }
  };
  system.next_mode = [=](double t, double* y, int mode, int which) {
    Signs signs = signs_of(mode, num);
    const auto state = physical(y);
    if (which < 0) {
      signs.setOnes();
      for (std::size_t i = 0; i < num; ++i) {
        const double value = equation->switch_value(i, t, state.data());
        signs[i] = value == 0.0 ? side_after(*equation, i, t, state.data(), signs) : value < 0.0 ? -1.0 : 1.0;
      }
      return mode_of(signs);
    }
    const auto i = static_cast<std::size_t>(which) / 2;
    if (signs[i] == 0.0) {
      signs[i] = which % 2 == 0 ? 1.0 : -1.0;
    } else {
      signs[i] = side_after(*equation, i, t, state.data(), signs);
      if (signs[i] == 0.0) y[1] = equation->held_speed(i, t) / speed_scale;
    }
    return mode_of(signs);
  };
  return system;
}

/// Dominant frequency of a stretch, by its largest periodogram line.
double dominant_hz(const Eigen::Ref<const Eigen::VectorXd>& x, double sample_rate_hz) {
  const Eigen::VectorXcd spectrum = dsp::RealFft(x.size()).forward(x.array() - x.mean());
  Index strongest = 0;
  spectrum.tail(spectrum.size() - 1).cwiseAbs2().maxCoeff(&strongest);
  return static_cast<double>(strongest + 1) * sample_rate_hz / static_cast<double>(x.size());
}

bool long_enough(const Course& course, const Course::Stretch& stretch, double min_periods) {
  constexpr Index min_samples = 16;
  const Index length = stretch.last - stretch.first;
  if (length < min_samples) return false;
  const Eigen::VectorXd x = course.signals->at("x").segment(stretch.first, length);
  return static_cast<double>(length) / course.signals->sample_rate_hz *
             dominant_hz(x, course.signals->sample_rate_hz) >=
         min_periods;
}

/// Squared errors and squared sizes of x, summed over the stretches so far.
struct Tally {
  double error = 0.0, size = 0.0;
};

/// Runs one stretch; false: `result` says how it ended.
bool run_stretch(const ident::Model& model, const Course& course, const Course::Stretch& stretch,
                 const FreeRunOptions& options, Tally& tally, FreeRun& result) {
  const dsp::Motion& motion = *course.signals;
  const auto equation = std::make_shared<Equation>(model, motion);
  equation->cover(stretch.first, stretch.last);
  const Eigen::VectorXd& position = motion.at(equation->of_payload() ? "y" : "x");
  const Eigen::VectorXd& speed = motion.at(equation->of_payload() ? "dy" : "v");
  const Index length = stretch.last - stretch.first;
  const double position_scale = position.segment(stretch.first, length).cwiseAbs().maxCoeff();
  const double speed_scale = speed.segment(stretch.first, length).cwiseAbs().maxCoeff();
  if (!(position_scale > 0.0) || !(speed_scale > 0.0)) {
    result.reason = "x does not move";
    return false;
  }
  const double start_s = static_cast<double>(stretch.first) / motion.sample_rate_hz;
  const Eigen::Vector2d initial(position(stretch.first) / position_scale, speed(stretch.first) / speed_scale);
  sim::SimulateOptions simulate_options{.duration_s = static_cast<double>(length - 1) / motion.sample_rate_hz,
                                        .sample_rate_hz = motion.sample_rate_hz,
                                        .start_s = start_s,
                                        .relative_tolerance = options.relative_tolerance,
                                        .absolute_tolerance = options.relative_tolerance,
                                        .formula = sim::Formula::dormand_prince,
                                        .divergence_bound = options.divergence_factor,
                                        .poll = check_interrupted};
  // Held on a switch nothing moves and steps would grow past the moment it is let go.
  if (equation->num_switches() > 0) simulate_options.max_step_s = 1.0 / motion.sample_rate_hz;
  const sim::Simulation run =
      sim::simulate(switched_system(equation, position_scale, speed_scale), initial, simulate_options);
  for (const sim::Event& event : run.events) {
    const Signs signs = signs_of(event.mode_after, equation->num_switches());
    result.sticks = result.sticks || std::find(signs.begin(), signs.end(), 0.0) != signs.end();
  }
  if (run.status != sim::SimulationStatus::finished) {
    result.diverged_after_s = static_cast<double>(run.time_s.size()) / motion.sample_rate_hz;
    result.reason = fmt::format("{} {:.4g} s after its start at t = {:.6g} s ({})",
                                run.status == sim::SimulationStatus::diverged ? "diverged" : "came to a halt",
                                result.diverged_after_s, start_s, run.reason);
    return false;
  }
  for (Index i = 0; i < length; ++i) {
    const Index sample = stretch.first + i;
    if (course.scored[static_cast<std::size_t>(sample)] == 0) continue;
    const double measured = motion.at("x")(sample);
    const double x = equation->x_at(run.time_s(i), run.states(i, 0) * position_scale);
    tally.error += (x - measured) * (x - measured);
    tally.size += measured * measured;
  }
  return true;
}

}  // namespace

FreeRun free_run(const ident::Model& model, const std::vector<Course>& courses, const FreeRunOptions& options) {
  FreeRun result;
  result.nmse = std::numeric_limits<double>::quiet_NaN();
  if (model.terms.empty()) result.reason = "no term was selected";
  Tally tally;
  for (const Course& course : courses) {
    if (result.reason.empty()) result.reason = Equation(model, *course.signals).trouble();
    if (!result.reason.empty()) return result;
    for (const Course::Stretch& stretch : course.stretches) {
      check_interrupted();
      if (!long_enough(course, stretch, options.min_periods)) continue;
      ++result.num_stretches;
      if (!run_stretch(model, course, stretch, options, tally, result)) return result;
    }
  }
  if (result.num_stretches == 0) {
    result.reason = fmt::format("no test stretch without a gap is {:g} periods long", options.min_periods);
  } else if (!(tally.size > 0.0)) {
    result.reason = "x is zero over the test rows";
  } else {
    result.nmse = tally.error / tally.size;
  }
  return result;
}

}  // namespace apps
