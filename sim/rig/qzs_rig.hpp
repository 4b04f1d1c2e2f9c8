#pragma once
#include <array>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/ode/frequency_response.hpp"
#include "sim/rig/base_motion.hpp"
#include "sim/simulate.hpp"
#include "sim/systems.hpp"

// The quasi-zero-stiffness isolator of Section 5 of [QZS23] as a simulated rig, per unit of payload mass:
//   x'' = -r'' - c x' - k1 x - k2 x^2 - k3 x^3 - mu sgn(x') + h(t),   x = y - r,
// with a hand's force h and friction that holds the payload while less than the static level pulls at it.

namespace sim {

struct QzsParameters {
  double k1 = 50.0, k2 = 0.0, k3 = 9.5e4;       ///< 1/s^2, 1/(m s^2), 1/(m^2 s^2)
  double c = 0.8;                               ///< 1/s
  double mu_kinetic = 0.08, mu_static = 0.385;  ///< m/s^2
  double stribeck_m_per_s = 0.0;                ///< speed over which friction falls from static to kinetic; 0: at once
  double position_modulation = 0.0, position_period_m = 6e-3;  ///< friction times 1 + m sin(2 pi x / p)
  double time_modulation = 0.0, time_period_s = 37.0;          ///< and times 1 + m sin(2 pi t / p)
  double bounce_hz = 0.0, bounce_damping = 0.10;  ///< mount resonance between isolator and payload sensors; 0: rigid
  double second_highpass_hz = 0.0;                ///< of an AC-coupled input behind the accelerometers; 0: none
};

/// "T0": physics inside the candidate library. "T1": with effects outside it. Throws std::invalid_argument.
[[nodiscard]] QzsParameters qzs_twin(std::string_view name);
/// Sets one parameter by its field name. Throws std::invalid_argument that lists them.
void set_parameter(QzsParameters& parameters, std::string_view name, double value);
/// Sets several. What is no parameter may be a setting `of_what` that `known` lists, as the message then says.
void set_parameters(QzsParameters& parameters, const std::vector<std::pair<std::string, double>>& settings,
                    std::string_view of_what, std::string_view known);
[[nodiscard]] std::vector<std::pair<std::string, double>> parameter_values(const QzsParameters& parameters);
/// Of the slipping rig, friction at its kinetic level; effects outside the library have no term.
[[nodiscard]] std::vector<TrueTerm> true_terms(const QzsParameters& parameters);

enum QzsMode { qzs_slip_down = -1, qzs_stick = 0, qzs_slip_up = 1 };

class QzsRig {
 public:
  /// Throws std::invalid_argument for friction, periods or frequencies that no rig has.
  QzsRig(const QzsParameters& parameters, const Programme& programme);
  [[nodiscard]] const QzsParameters& parameters() const& { return parameters_; }
  void parameters() const&& = delete;
  [[nodiscard]] const Programme& programme() const& { return programme_; }
  void programme() const&& = delete;
  [[nodiscard]] const BaseMotion& base() const& { return base_; }
  void base() const&& = delete;
  /// x'' in a mode, the base's acceleration given.
  [[nodiscard]] double acceleration(double t, double x, double v, double ddr, int mode) const;
  /// States x, v; modes as QzsMode. The rig must outlive it.
  [[nodiscard]] System system() const;

 private:
  [[nodiscard]] double pull(double t, double x, double v, double ddr) const;  ///< all forces but damping and friction
  [[nodiscard]] double modulation(double t, double x) const;
  QzsParameters parameters_;
  Programme programme_;
  BaseMotion base_;
};

/// The payload runs away, or cannot be integrated further; what() says when.
struct Diverged : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct QzsState {
  double t_s = 0.0, x = 0.0, v = 0.0, a = 0.0;  ///< relative motion, SI
  BaseState base;
  int mode = qzs_stick;
};

/// The rig's motion from rest, at any times in order: integrated at 1e-10, between its steps (and no wider than 1/512
/// s) by the fifth-degree polynomial through x, v, a at both ends, with a from the equation itself. Events end such a
/// substep, so jumps of the acceleration are where they belong. Memory does not grow with time but for the list of
/// events.
class QzsTrajectory {
 public:
  /// `poll` is called now and then while it integrates; it may throw to stop.
  QzsTrajectory(std::shared_ptr<const QzsRig> rig, double duration_s, std::function<void()> poll = {});
  /// Rest before t = 0. Throws std::invalid_argument for a t before the substep of the last one, or past the end;
  /// Diverged where the motion has no end.
  [[nodiscard]] const QzsState& at(double t) &;
  [[nodiscard]] const QzsRig& rig() const& { return *rig_; }
  void rig() const&& = delete;
  [[nodiscard]] const std::vector<Event>& events() const& { return integrator_.events(); }
  void events() const&& = delete;
  [[nodiscard]] long num_steps() const { return integrator_.num_steps(); }

 private:
  void next_substep();
  std::shared_ptr<const QzsRig> rig_;
  Integrator integrator_;
  double duration_s_;
  int substep_ = 0, num_substeps_ = 0;                                ///< equal parts of an integrator's step
  double begin_s_ = 0.0, end_s_ = 0.0, x_ = 0.0, v_ = 0.0, a_ = 0.0;  ///< the substep; states at its end
  std::array<double, 6> x_powers_{};                                  ///< of (t - begin) / (end - begin)
  std::size_t near_ = 0;
  QzsState state_;
};

/// Its frequency response, by integrating through every dwell. Throws std::invalid_argument as sweep_frequencies and
/// sine_steps.
[[nodiscard]] FrequencyResponse frequency_response(const QzsParameters& parameters,
                                                   const FrequencyResponseOptions& options = {});

}  // namespace sim
