#include "ident/bodies/driven_bodies.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <set>
#include <utility>

#include "dsp/values/constants.hpp"
#include "dsp/values/fault.hpp"
#include "ident/bodies/system.hpp"
#include "ident/library/expression.hpp"
#include "sim/ode/friction.hpp"
#include "sim/simulate.hpp"

namespace ident {
namespace {

using dsp::two_pi;
using Eigen::VectorXd;

constexpr const char* base = "r";

/// Which derivative of the base's displacement an input is; -1: it is a force.
int order_of(const std::string& input) {
  return input == "r" ? 0 : input == "dr" ? 1 : input == "ddr" ? 2 : -1;
}

[[noreturn]] void refuse(const std::string& why) {
  throw dsp::Fault(dsp::FaultKind::usage, "frc.equation", "frc: " + why);
}

void check(const BodiesModel& model, const std::string& drive) {
  if (model.layout.imposed) refuse("the equation is of the force on an imposed motion: nothing in it is driven");
  std::set<std::string, std::less<>> signals;
  for (const BodyTerm& term : model.terms) {
    const Expression expression(term.name);
    signals.insert(expression.signals().begin(), expression.signals().end());
  }
  if (signals.count("t") > 0) refuse("a term goes with t: the response to a sine does not have its period");
  const bool acts = std::any_of(signals.begin(), signals.end(), [&](const std::string& signal) {
    return signal == drive || (drive == base && order_of(signal) >= 0);
  });
  if (!acts) refuse(fmt::format("no term looks at {}", drive == base ? "the base's motion" : drive));
}

/// amplitude cos(w t) with its first three derivatives.
struct Sine {
  double amplitude = 0.0, w = 0.0;
  [[nodiscard]] std::array<double, 4> at(double t) const {
    const double cosine = amplitude * std::cos(w * t), sine = amplitude * std::sin(w * t);
    return {cosine, -w * sine, -w * w * cosine, w * w * w * sine};
  }
};

class DrivenBodies {
 public:
  DrivenBodies(const BodiesModel& model, const std::string& drive, int body)
      : layout_(model.layout),
        body_(body - 1),
        x_per_drive_(drive == base && layout_.frame == Frame::absolute ? -1.0 : 0.0),
        y_per_drive_(drive == base && layout_.frame == Frame::base ? 1.0 : 0.0) {
    for (const std::string& input : layout_.inputs)
      orders_.push_back(drive == base ? order_of(input) : input == drive ? 0 : -1);
    drives_through_lag_ =
        layout_.lagging == drive || (drive == base && order_of(layout_.lagging) >= 0 && !layout_.sensor_lags());
    system_ = system_of(model, [this](double t, double* values, double* rates) {
      const std::array<double, 4> sine = sine_.at(t);
      for (std::size_t i = 0; i < orders_.size(); ++i) {
        const int order = orders_[i];
        values[i] = order < 0 ? 0.0 : sine[static_cast<std::size_t>(order)];
        rates[i] = order < 0 ? 0.0 : sine[static_cast<std::size_t>(order) + 1];
      }
    });
  }

  DrivenBodies(const DrivenBodies&) = delete;
  DrivenBodies& operator=(const DrivenBodies&) = delete;

  /// At the crest of a drive of 1: x at rest relative to what moves.
  [[nodiscard]] VectorXd rest() const {
    VectorXd state = VectorXd::Zero(layout_.num_states());
    for (int i = 0; i < layout_.num_bodies; ++i) state[2 * i] = -x_per_drive_;
    if (layout_.sensor_lags()) state.tail(1).setConstant(-x_per_drive_);
    return state;
  }

  sim::DrivenPeriod period(double frequency_hz, double amplitude, const VectorXd& start) {
    constexpr int num_points = 40;
    constexpr double away = 1e9;      // of what the drive moves a free body by
    constexpr double nothing = 1e-6;  // of the same: where friction holds, what an integration makes of rest
    sine_ = {amplitude, two_pi * frequency_hz};
    const double size = free_motion();
    const VectorXd sizes = scales(size);
    system_.scales.assign(sizes.begin(), sizes.end());
    sim::DrivenPeriod result{.motion = {}, .end = start, .scale = sizes};
    sim::Integrator integrator(system_, start,
                               {.duration_s = 1.0 / frequency_hz,
                                .sample_rate_hz = num_points * frequency_hz,
                                .relative_tolerance = 1e-10,
                                .absolute_tolerance = 1e-12,
                                .max_steps_per_output = 100.0,
                                .divergence_bound = std::numeric_limits<double>::max()});
    std::vector<sim::Range> relative(static_cast<std::size_t>(layout_.num_bodies));
    VectorXd before = start, here = start;
    double stuck_s = 0.0, from_s = 0.0;
    for (int k = 0; k < num_points; ++k) {
      const double to_s = (k + 1) / (frequency_hz * num_points);
      result.motion.x_fundamental +=
          moved(from_s, before, body_, x_per_drive_).first * std::polar(1.0, -two_pi * k / num_points);
      while (from_s < to_s) {  // a step ends where a rate jumps: no cubic goes across
        if (integrator.end_s() <= from_s && !integrator.step()) break;
        const double t = std::min(to_s, integrator.end_s());
        if (is_held(integrator.mode())) stuck_s += t - from_s;
        integrator.states(t, here.data());
        const auto extend = [&](sim::Range& range, int i, double per_drive) {
          const auto from = moved(from_s, before, i, per_drive), to = moved(t, here, i, per_drive);
          range.extend(from.first, from.second, to.first, to.second, t - from_s);
        };
        for (int i = 0; i < layout_.num_bodies; ++i) extend(relative[static_cast<std::size_t>(i)], i, x_per_drive_);
        extend(result.motion.y, body_, y_per_drive_);
        std::swap(before, here);
        from_s = t;
      }
      result.finite = integrator.status() == sim::SimulationStatus::finished &&
                      before.cwiseQuotient(sizes).cwiseAbs().maxCoeff() <= away;
      if (!result.finite) return result;
    }
    const auto largest = std::max_element(relative.begin(), relative.end(),
                                          [](const auto& a, const auto& b) { return a.half() < b.half(); });
    result.end = before;
    result.scale = scales(std::max(largest->half(), nothing * size));
    result.motion.x = relative[static_cast<std::size_t>(body_)];
    result.motion.stuck_fraction = stuck_s * frequency_hz;
    result.motion.locked = largest->half() <= nothing * size;
    return result;
  }

 private:
  /// Of each state, where displacements are of this size.
  [[nodiscard]] VectorXd scales(double size) const {
    VectorXd result(layout_.num_states());
    for (int i = 0; i < layout_.num_bodies; ++i) result[2 * i] = size, result[2 * i + 1] = size * sine_.w;
    if (layout_.inner == Inner::hysteresis) result.tail(1).setConstant(size * sine_.w * sine_.w);
    if (layout_.sensor_lags()) result.tail(1).setConstant(size);
    if (layout_.inner == Inner::lag && !layout_.sensor_lags())
      result.tail(1).setConstant(sine_.amplitude * std::pow(sine_.w, std::max(0, order_of(layout_.lagging))));
    return result;
  }
  /// By how far the drive alone moves bodies that are at rest and free.
  [[nodiscard]] double free_motion() {
    const VectorXd rest = VectorXd::Zero(layout_.num_states());
    VectorXd acted_on = rest, driven = rest, alone = rest;
    if (drives_through_lag_) acted_on.tail(1) = scales(0.0).tail(1);
    int all_above = 0;
    for (int i = 0; i < system_.num_switches / 2; ++i) all_above = 3 * all_above + 1;
    double largest = 0.0;
    for (const double quarters : {0.0, 1.0}) {
      const double t = 0.25 * quarters * two_pi / sine_.w;
      system_.rhs(t, acted_on.data(), all_above, driven.data());
      const Sine sine = std::exchange(sine_, {0.0, sine_.w});
      system_.rhs(t, rest.data(), all_above, alone.data());
      sine_ = sine;
      for (int i = 0; i < layout_.num_bodies; ++i)
        largest = std::max(largest, std::abs(driven[2 * i + 1] - alone[2 * i + 1]));
    }
    return std::max(largest / (sine_.w * sine_.w), std::numeric_limits<double>::min());
  }
  [[nodiscard]] bool is_held(int mode) const {
    std::array<double, sim::max_switches> sides;
    const int count = system_.num_switches / 2;
    sim::sides_of(mode, count, sides.data());
    return std::find(sides.begin(), sides.begin() + count, 0.0) != sides.begin() + count;
  }
  /// Displacement and speed of a body and so much of the drive's.
  [[nodiscard]] std::pair<double, double> moved(double t, const VectorXd& states, int body, double per_drive) const {
    const std::array<double, 4> sine = sine_.at(t);
    return {states[2 * body] + per_drive * sine[0], states[2 * body + 1] + per_drive * sine[1]};
  }

  BodiesLayout layout_;
  int body_;
  double x_per_drive_, y_per_drive_;
  bool drives_through_lag_ = false;
  std::vector<int> orders_;  ///< which derivative of the drive each input is; -1: none, and zero
  Sine sine_ = {};
  sim::System system_ = {};
};

}  // namespace

std::vector<std::string> drives_of(const BodiesLayout& layout) {
  std::vector<std::string> drives;
  for (const std::string& input : layout.inputs) {
    const std::string drive = order_of(input) < 0 ? input : base;
    if (std::find(drives.begin(), drives.end(), drive) == drives.end()) drives.push_back(drive);
  }
  return drives;
}

DriveKind kind_of_drive(const std::string& drive) {
  return drive == base ? DriveKind::base : DriveKind::force;
}

sim::DrivenSystem driven_bodies(const BodiesModel& model, const std::string& drive, int body) {
  check(model, drive);
  const auto bodies = std::make_shared<DrivenBodies>(model, drive, body);
  constexpr double step = 1e-4;  // the integration's 1e-10 is a millionth of it
  return {.rest = bodies->rest(),
          .step = step,
          .period = [bodies](double frequency_hz, double amplitude, const VectorXd& start) {
            return bodies->period(frequency_hz, amplitude, start);
          }};
}

}  // namespace ident
