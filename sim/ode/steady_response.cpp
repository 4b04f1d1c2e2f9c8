#include "sim/ode/steady_response.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "dsp/values/constants.hpp"
#include "dsp/values/linear.hpp"

namespace sim {
namespace {

using dsp::nan;

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// One frequency: its answer and the state it ends in, at the crest of the drive.
struct Settled {
  ResponsePoint point;
  VectorXd state;
  bool periodic = true, finite = true;
};

/// Whether all powers of a matrix stay small: its eigenvalues are inside the unit circle, to one part in 1e9.
bool is_contracting(MatrixXd map) {
  for (int doublings = 0; doublings < 30; ++doublings) {
    const double size = map.norm();
    if (size < 1.0) return true;
    if (!(size < 1e9)) return false;  // NaN, too
    map = MatrixXd(map * map);
  }
  return false;
}

/// What is driven at one frequency and amplitude.
class Shooting {
 public:
  Shooting(const DrivenSystem& driven, double frequency_hz, double amplitude, const SteadyOptions& options)
      : driven_(driven), frequency_hz_(frequency_hz), amplitude_(amplitude), options_(options) {}

  [[nodiscard]] Settled settle(VectorXd state) const {
    DrivenPeriod period;
    for (int done = 0, batch = options_.num_natural_periods; done < options_.max_periods; done += batch, batch *= 2) {
      VectorXd before;
      for (int i = 0; i < batch; ++i) {
        before = std::exchange(state, {});
        period = run(before);
        state = period.end;
        if (!period.finite) return {.point = point(period), .state = state, .periodic = false, .finite = false};
      }
      if (period.motion.locked || (state - before).cwiseQuotient(period.scale).norm() <= options_.tolerance)
        return {.point = point(period), .state = state};
      if (const auto found = periodic_near(state, period.scale)) {
        period = run(*found);
        return {.point = point(period), .state = period.end};
      }
    }
    return {.point = point(period), .state = state, .periodic = false};
  }

 private:
  [[nodiscard]] DrivenPeriod run(const VectorXd& state) const {
    if (options_.poll) options_.poll();
    return driven_.period(frequency_hz_, amplitude_, state);
  }

  /// The periodic motion that Newton's method reaches from a state without leaving its neighbourhood, where it is
  /// stable.
  [[nodiscard]] std::optional<VectorXd> periodic_near(const VectorXd& from, const VectorXd& scale) const {
    constexpr int max_iterations = 6;
    constexpr double straight = 1e-3;
    const double step = driven_.step;
    const auto mapped = [&](const VectorXd& z) -> VectorXd {
      return run(z.cwiseProduct(scale)).end.cwiseQuotient(scale);
    };
    const VectorXd start = from.cwiseQuotient(scale);
    const Eigen::Index n = start.size();
    VectorXd z = start;
    double first_gap = 0.0;
    for (int iteration = 0; iteration < max_iterations; ++iteration) {
      // The orbit itself rests where it rests: only a state off its neighbours says how it answers.
      const VectorXd after = mapped(z), gap = after - z;
      if (iteration == 0) first_gap = gap.norm();
      // Where one step ends the gap the way is straight: a transient, however slowly it fades, fades to that orbit.
      const bool is_straight = gap.norm() <= straight * first_gap;
      if (iteration > 0 && !is_straight && !((z - start).norm() <= options_.nearness)) return std::nullopt;
      MatrixXd map(n, n);
      for (Eigen::Index k = 0; k < n; ++k) {
        VectorXd moved = z;
        moved[k] += step;
        map.col(k) = (mapped(moved) - after) / step;
      }
      if (gap.norm() <= options_.tolerance) {
        if (!is_contracting(map)) return std::nullopt;
        return z.cwiseProduct(scale);
      }
      z += dsp::least_squares(MatrixXd::Identity(n, n) - map, gap);
    }
    return std::nullopt;
  }

  [[nodiscard]] ResponsePoint point(const DrivenPeriod& period) const {
    const DrivenMotion& motion = period.motion;
    return {.frequency_hz = frequency_hz_,
            .x_m = motion.locked ? 0.0 : motion.x.half(),
            .y_m = motion.y.half(),
            .phase_rad = motion.locked ? nan : std::arg(motion.x_fundamental),
            .stuck_fraction = std::min(motion.stuck_fraction, 1.0),
            .locked = motion.locked};
  }

  const DrivenSystem& driven_;
  double frequency_hz_, amplitude_;
  const SteadyOptions& options_;
};

/// A sweep with the states its points ended in.
struct Sweep {
  std::vector<ResponsePoint> points;
  std::vector<VectorXd> states;
  int num_unsettled = 0;
  double diverged_hz = nan;
};

Sweep sweep(const DrivenSystem& driven, const std::vector<double>& frequencies_hz, double amplitude,
            const SteadyOptions& options) {
  Sweep result;
  VectorXd state = amplitude * driven.rest;
  for (const double f : frequencies_hz) {
    const Settled settled = Shooting(driven, f, amplitude, options).settle(state);
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
Located locate(const DrivenSystem& driven, const Sweep& swept, SweepChange wanted, double amplitude, double jump_factor,
               const SteadyOptions& options) {
  for (std::size_t k = 1; k < swept.points.size(); ++k) {
    const ResponsePoint& before = swept.points[k - 1];
    if (change_between(before, swept.points[k], jump_factor) != wanted) continue;
    ResponsePoint here = before, beyond = swept.points[k];
    VectorXd state = swept.states[k - 1];
    while (std::abs(beyond.frequency_hz - here.frequency_hz) > options.locate_hz) {
      const double middle_hz = 0.5 * (here.frequency_hz + beyond.frequency_hz);
      const Settled settled = Shooting(driven, middle_hz, amplitude, options).settle(state);
      if (!settled.finite) return {};
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

SteadyResponse steady_response(const DrivenSystem& driven, const FrequencyResponseOptions& options,
                               const SteadyOptions& steady) {
  std::vector<double> frequencies_hz = sweep_frequencies(options);
  const double amplitude = options.amplitude_m, factor = options.jump_factor;
  const Sweep up = sweep(driven, frequencies_hz, amplitude, steady);
  std::reverse(frequencies_hz.begin(), frequencies_hz.end());
  const Sweep down = sweep(driven, frequencies_hz, amplitude, steady);
  SteadyResponse result{.response = {up.points, down.points, find_jumps(up.points, down.points, factor)},
                        .located = {nan, nan, nan, nan, nan, nan},
                        .num_unsettled = up.num_unsettled + down.num_unsettled,
                        .diverged_hz = std::isnan(up.diverged_hz) ? down.diverged_hz : up.diverged_hz};
  if (!(steady.locate_hz > 0.0)) return result;
  const auto find = [&](const Sweep& swept, SweepChange wanted, double ResponseJumps::*which) {
    const Located located = locate(driven, swept, wanted, amplitude, factor, steady);
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
