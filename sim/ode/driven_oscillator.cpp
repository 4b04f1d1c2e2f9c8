#include "sim/ode/driven_oscillator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "dsp/values/constants.hpp"
#include "sim/ode/dormand_prince.hpp"
#include "sim/ode/friction.hpp"
#include "sim/ode/runge_kutta.hpp"
#include "sim/ode/zero_of.hpp"

namespace sim {
namespace {

using dsp::two_pi;

class Stepper {
 public:
  Stepper(const DrivenOscillator& oscillator, double frequency_hz, double amplitude)
      : oscillator_(oscillator), w_(two_pi * frequency_hz), amplitude_(amplitude) {}

  [[nodiscard]] DrivenOscillator::Drive drive(double t) const {
    const double u = amplitude_ * std::cos(w_ * t);
    return {u, -amplitude_ * w_ * std::sin(w_ * t), -w_ * w_ * u};
  }

  /// Friction can hold a resting q against half of what its sign changes, or up to static_friction.
  [[nodiscard]] RatesAtZero at_rest(double t, double q) const {
    const auto u = drive(t);
    const double up = oscillator_.acceleration(u, q, 0.0, 1.0), down = oscillator_.acceleration(u, q, 0.0, -1.0);
    const double pull = 0.5 * (up + down), limit = std::max(0.5 * (down - up), oscillator_.static_friction);
    return {pull - limit, pull + limit};
  }
  [[nodiscard]] int mode_at_rest(double t, double q) const { return side_from_zero(at_rest(t, q), 1); }

  /// Goes on from t by at most h, to the next event or the end; returns by how much.
  double advance(double t, OscillatorState& s, double h) {
    if (s.mode == 0) {
      goes_on_ = false;
      return held(t, s, h);
    }
    slip(t, s, h);
    const OscillatorState end = after(1.0, s.mode);
    goes_on_ = !oscillator_.switches || !(s.mode * end.v < 0.0);
    if (goes_on_) {
      s = end;
      return h;
    }
    if (s.v == 0.0 && s.mode * after(just_after, s.mode).v <= 0.0) {  // let go by rounding only: nothing moves yet
      s.mode = 0;
      return h;
    }
    // From a start at rest the velocity leaves zero first: look for the zero beyond.
    const double begin = s.v == 0.0 ? just_after : 0.0;
    const auto speed = [&](double u) { return after(u, s.mode).v; };
    const double u = zero_of(speed, {begin, 1.0, speed(begin), end.v}, located).high;
    s = after(u, s.mode);
    s.v = 0.0;
    s.mode = mode_at_rest(t + u * h, s.q);
    return u * h;
  }

 private:
  static constexpr double just_after = 1e-3, located = 1e-13;  // of a step

  [[nodiscard]] auto rates_in(int mode) const {
    return [this, mode](double t, const double* y, double* dydt) {
      dydt[0] = y[1];
      dydt[1] = oscillator_.acceleration(drive(t), y[0], y[1], mode);
    };
  }

  /// Takes a step of h in the mode of `s`, whatever its velocity does meanwhile.
  void slip(double t, const OscillatorState& s, double h) {
    const auto rates = rates_in(s.mode);
    if (goes_on_)
      formula_.go_on();
    else
      formula_.start(rates, t, {s.q, s.v});
    formula_.step(rates, h);
  }
  /// The state at a fraction of that step.
  OscillatorState after(double u, int mode) {
    double y[2];
    formula_.between(rates_in(mode), u, y);
    return {y[0], y[1], mode};
  }

  double held(double t, OscillatorState& s, double h) const {
    const int leaves = mode_at_rest(t + h, s.q);
    if (leaves == 0) return h;
    s.mode = leaves;
    const auto excess = [&](double d) {
      const RatesAtZero rates = at_rest(t + d, s.q);
      return leaves > 0 ? rates.above : -rates.below;
    };
    const double at_begin = excess(0.0);
    return at_begin < 0.0 ? zero_of(excess, {0.0, h, at_begin, excess(h)}, located * h).high : 0.0;
  }

  const DrivenOscillator& oscillator_;
  double w_, amplitude_;
  RungeKutta<DormandPrince5, 2> formula_{2};
  bool goes_on_ = false;  ///< the next step starts where and how the last one ended
};

/// The mode a state at the crest starts in.
int starting_mode(const DrivenOscillator& oscillator, double frequency_hz, double amplitude, double q, double v) {
  if (!oscillator.switches) return 1;
  if (v != 0.0) return v > 0.0 ? 1 : -1;
  return Stepper(oscillator, frequency_hz, amplitude).mode_at_rest(0.0, q);
}

}  // namespace

OscillatorPeriod run_period(const DrivenOscillator& oscillator, double frequency_hz, double amplitude,
                            const OscillatorState& start, int num_steps) {
  Stepper stepper(oscillator, frequency_hz, amplitude);
  OscillatorPeriod period{.end = start, .motion = {}};
  DrivenMotion& motion = period.motion;
  const double step_s = 1.0 / (frequency_hz * num_steps), tiny_s = 1e-12 * step_s;
  OscillatorState& s = period.end;
  double stuck_s = 0.0;
  for (int i = 0; i < num_steps; ++i) {
    const double begin_s = i * step_s;
    motion.x_fundamental +=
        (s.q + oscillator.x_per_drive * stepper.drive(begin_s)[0]) * std::polar(1.0, -two_pi * i / num_steps);
    for (double done_s = 0.0; step_s - done_s > tiny_s;) {
      const OscillatorState before = s;
      const auto drive = stepper.drive(begin_s + done_s);
      const double passed_s = stepper.advance(begin_s + done_s, s, step_s - done_s);
      done_s += passed_s;
      if (before.mode == 0) stuck_s += passed_s;
      const auto after = stepper.drive(begin_s + done_s);
      const double px = oscillator.x_per_drive, py = oscillator.y_per_drive;
      motion.x.extend(before.q + px * drive[0], before.v + px * drive[1], s.q + px * after[0], s.v + px * after[1],
                      passed_s);
      motion.y.extend(before.q + py * drive[0], before.v + py * drive[1], s.q + py * after[0], s.v + py * after[1],
                      passed_s);
    }
  }
  motion.stuck_fraction = stuck_s * frequency_hz;
  motion.locked = motion.stuck_fraction >= 1.0 - 1e-9;
  return period;
}

DrivenSystem driven_system(DrivenOscillator oscillator) {
  const double x_per_drive = oscillator.x_per_drive;
  const auto period = [oscillator = std::move(oscillator)](double frequency_hz, double amplitude,
                                                           const Eigen::VectorXd& start) {
    constexpr int num_steps = 40;
    constexpr double away = 1e6;  // of the drive's amplitude
    const int mode = starting_mode(oscillator, frequency_hz, amplitude, start[0], start[1]);
    const auto [end, motion] = run_period(oscillator, frequency_hz, amplitude, {start[0], start[1], mode}, num_steps);
    const double scale = std::max(motion.x.half(), std::numeric_limits<double>::min());
    return DrivenPeriod{.motion = motion,
                        .end = Eigen::Vector2d(end.q, end.v),
                        .scale = Eigen::Vector2d(scale, scale * two_pi * frequency_hz),
                        .finite = std::isfinite(end.v) && std::abs(end.q) <= away * amplitude};
  };
  return {.rest = Eigen::Vector2d(-x_per_drive, 0.0), .period = period};
}

}  // namespace sim
