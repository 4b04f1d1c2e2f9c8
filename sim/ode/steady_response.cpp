#include "sim/ode/steady_response.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "dsp/constants.hpp"

namespace sim {
namespace {

using dsp::nan;
using dsp::two_pi;

/// One frequency: its answer and the state it ends in, at the crest of the drive.
struct Settled {
  ResponsePoint point;
  OscillatorState state;
  bool periodic = true, finite = true;
};

/// One oscillator at one frequency and amplitude.
class Shooting {
 public:
  Shooting(const DrivenOscillator& oscillator, double frequency_hz, double amplitude, const SteadyOptions& options)
      : oscillator_(oscillator), frequency_hz_(frequency_hz), amplitude_(amplitude), options_(options) {}

  [[nodiscard]] Settled settle(OscillatorState state) const {
    state.mode = starting_mode(oscillator_, frequency_hz_, amplitude_, state);
    DrivenPeriod period;
    for (int done = 0, batch = options_.num_natural_periods; done < options_.max_periods; done += batch, batch *= 2) {
      OscillatorState before = state;
      for (int i = 0; i < batch; ++i) {
        before = state;
        period = run(state);
        state = period.end;
        if (!std::isfinite(state.q) || !std::isfinite(state.v) || std::abs(state.q) > 1e6 * amplitude_)
          return {.point = point(period), .state = state, .periodic = false, .finite = false};
      }
      if (distance(before, state, period) <= options_.tolerance) return {.point = point(period), .state = state};
      if (const auto found = periodic_near(state, period)) {
        period = run(*found);
        return {.point = point(period), .state = period.end};
      }
    }
    return {.point = point(period), .state = state, .periodic = false};
  }

 private:
  [[nodiscard]] DrivenPeriod run(const OscillatorState& state) const {
    if (options_.poll) options_.poll();
    return run_period(oscillator_, frequency_hz_, amplitude_, state, options_.steps_per_period);
  }
  /// A state with the mode that belongs to it.
  [[nodiscard]] OscillatorState state_at(const Eigen::Vector2d& z, double scale) const {
    OscillatorState state{z[0] * scale, z[1] * scale * two_pi * frequency_hz_, 0};
    state.mode = starting_mode(oscillator_, frequency_hz_, amplitude_, state);
    return state;
  }
  [[nodiscard]] Eigen::Vector2d scaled(const OscillatorState& s, double scale) const {
    return {s.q / scale, s.v / (scale * two_pi * frequency_hz_)};
  }
  [[nodiscard]] static double scale_of(const DrivenPeriod& period) {
    return std::max(0.5 * (period.x_high - period.x_low), std::numeric_limits<double>::min());
  }
  [[nodiscard]] double distance(const OscillatorState& a, const OscillatorState& b, const DrivenPeriod& period) const {
    if (period.stuck_fraction >= 1.0) return 0.0;
    const double scale = scale_of(period);
    return (scaled(a, scale) - scaled(b, scale)).norm();
  }

  /// The stable periodic motion that Newton's method reaches from a state without leaving its neighbourhood.
  [[nodiscard]] std::optional<OscillatorState> periodic_near(const OscillatorState& from,
                                                             const DrivenPeriod& period) const {
    constexpr double step = 1e-6;
    constexpr int max_iterations = 6;
    const double scale = scale_of(period);
    const Eigen::Vector2d start = scaled(from, scale);
    Eigen::Vector2d z = start;
    for (int iteration = 0; iteration < max_iterations; ++iteration) {
      // The orbit itself rests where it rests: only a state off its neighbours says how it answers.
      const Eigen::Vector2d after = scaled(run(state_at(z, scale)).end, scale);
      Eigen::Matrix2d map;
      for (int k = 0; k < 2; ++k) {
        Eigen::Vector2d moved = z;
        moved[k] += step;
        map.col(k) = (scaled(run(state_at(moved, scale)).end, scale) - after) / step;
      }
      const Eigen::Matrix2d a = Eigen::Matrix2d::Identity() - map;
      const double determinant = a(0, 0) * a(1, 1) - a(0, 1) * a(1, 0);
      // Both multipliers of the period map inside the unit circle (Jury).
      const double trace = map.trace(), product = map(0, 0) * map(1, 1) - map(0, 1) * map(1, 0);
      const bool stable = std::abs(product) < 1.0 && std::abs(trace) < 1.0 + product;
      const Eigen::Vector2d gap = after - z;
      if (!stable || !(std::abs(determinant) > 1e-9)) return std::nullopt;
      const Eigen::Vector2d newton((a(1, 1) * gap[0] - a(0, 1) * gap[1]) / determinant,
                                   (-a(1, 0) * gap[0] + a(0, 0) * gap[1]) / determinant);
      if (gap.norm() <= options_.tolerance) return state_at(z, scale);
      z += newton;
      if (!((z - start).norm() <= options_.nearness)) return std::nullopt;
    }
    return std::nullopt;
  }

  [[nodiscard]] ResponsePoint point(const DrivenPeriod& period) const {
    const bool locked = period.stuck_fraction >= 1.0 - 1e-9;
    return {.frequency_hz = frequency_hz_,
            .x_m = locked ? 0.0 : 0.5 * (period.x_high - period.x_low),
            .y_m = 0.5 * (period.y_high - period.y_low),
            .phase_rad = locked ? nan : std::arg(period.x_fundamental),
            .stuck_fraction = std::min(period.stuck_fraction, 1.0),
            .locked = locked};
  }

  const DrivenOscillator& oscillator_;
  double frequency_hz_, amplitude_;
  const SteadyOptions& options_;
};

/// A sweep with the states its points ended in.
struct Sweep {
  std::vector<ResponsePoint> points;
  std::vector<OscillatorState> states;
  int num_unsettled = 0;
  double diverged_hz = nan;
};

Sweep sweep(const DrivenOscillator& oscillator, const std::vector<double>& frequencies_hz, double amplitude,
            const SteadyOptions& options) {
  Sweep result;
  OscillatorState state;
  for (const double f : frequencies_hz) {
    const Settled settled = Shooting(oscillator, f, amplitude, options).settle(state);
    if (!settled.finite) {
      result.diverged_hz = f;
      break;
    }
    state = settled.state;
    result.points.push_back(settled.point);
    result.states.push_back(state);
    result.num_unsettled += !settled.periodic;
  }
  return result;
}

/// A change between two points of a sweep.
struct Located {
  double point_hz = nan, exact_hz = nan;  ///< the point after it, and where it is
};

/// The first change of a kind. What changes steeply but without a jump between two points is none.
Located locate(const DrivenOscillator& oscillator, const Sweep& swept, SweepChange wanted, double amplitude,
               double jump_factor, const SteadyOptions& options) {
  for (std::size_t k = 1; k < swept.points.size(); ++k) {
    const ResponsePoint& before = swept.points[k - 1];
    if (change_between(before, swept.points[k], jump_factor) != wanted) continue;
    ResponsePoint here = before, beyond = swept.points[k];
    OscillatorState state = swept.states[k - 1];
    while (std::abs(beyond.frequency_hz - here.frequency_hz) > options.locate_hz) {
      const double middle_hz = 0.5 * (here.frequency_hz + beyond.frequency_hz);
      const Settled settled = Shooting(oscillator, middle_hz, amplitude, options).settle(state);
      const bool passed = before.locked != swept.points[k].locked
                              ? settled.point.locked == swept.points[k].locked
                              : change_between(before, settled.point, jump_factor) != SweepChange::none;
      if (!passed) {
        here = settled.point;
        state = settled.state;
      } else {
        beyond = settled.point;
      }
    }
    if (change_between(here, beyond, std::sqrt(jump_factor)) == wanted)
      return {swept.points[k].frequency_hz, beyond.frequency_hz};
  }
  return {};
}

}  // namespace

SteadyResponse steady_response(const DrivenOscillator& oscillator, const FrequencyResponseOptions& options,
                               const SteadyOptions& steady) {
  std::vector<double> frequencies_hz = sweep_frequencies(options);
  const double amplitude = options.amplitude_m, factor = options.jump_factor;
  const Sweep up = sweep(oscillator, frequencies_hz, amplitude, steady);
  std::reverse(frequencies_hz.begin(), frequencies_hz.end());
  const Sweep down = sweep(oscillator, frequencies_hz, amplitude, steady);
  SteadyResponse result{.response = {up.points, down.points, find_jumps(up.points, down.points, factor)},
                        .located = {nan, nan, nan, nan, nan, nan},
                        .num_unsettled = up.num_unsettled + down.num_unsettled,
                        .diverged_hz = std::isnan(up.diverged_hz) ? down.diverged_hz : up.diverged_hz};
  if (!(steady.locate_hz > 0.0)) return result;
  const auto find = [&](const Sweep& swept, SweepChange wanted, double ResponseJumps::*which) {
    const Located located = locate(oscillator, swept, wanted, amplitude, factor, steady);
    result.response.jumps.*which = located.point_hz;
    result.located.*which = located.exact_hz;
  };
  find(up, SweepChange::unlock, &ResponseJumps::unlock_rising_hz);
  find(up, SweepChange::jump_up, &ResponseJumps::jump_up_rising_hz);
  find(up, SweepChange::jump_down, &ResponseJumps::jump_down_rising_hz);
  find(down, SweepChange::jump_up, &ResponseJumps::jump_up_falling_hz);
  find(down, SweepChange::jump_down, &ResponseJumps::jump_down_falling_hz);
  find(down, SweepChange::lock, &ResponseJumps::lock_falling_hz);
  return result;
}

}  // namespace sim
