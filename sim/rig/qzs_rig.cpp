#include "sim/rig/qzs_rig.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "dsp/values/constants.hpp"
#include "sim/ode/friction.hpp"

namespace sim {
namespace {

using dsp::two_pi;
constexpr double longest_substep_s = 1.0 / 512.0;
constexpr double fastest_recorder_hz = 25600.0, most_steps_per_sample = 8.0;  // no sensor shows what is faster

constexpr std::array<std::pair<const char*, double QzsParameters::*>, 14> fields{
    {{"k1", &QzsParameters::k1},
     {"k2", &QzsParameters::k2},
     {"k3", &QzsParameters::k3},
     {"c", &QzsParameters::c},
     {"mu_kinetic", &QzsParameters::mu_kinetic},
     {"mu_static", &QzsParameters::mu_static},
     {"stribeck_m_per_s", &QzsParameters::stribeck_m_per_s},
     {"position_modulation", &QzsParameters::position_modulation},
     {"position_period_m", &QzsParameters::position_period_m},
     {"time_modulation", &QzsParameters::time_modulation},
     {"time_period_s", &QzsParameters::time_period_s},
     {"bounce_hz", &QzsParameters::bounce_hz},
     {"bounce_damping", &QzsParameters::bounce_damping},
     {"second_highpass_hz", &QzsParameters::second_highpass_hz}}};

std::vector<ResponsePoint> sweep(const QzsParameters& parameters, std::vector<double> frequencies_hz,
                                 const FrequencyResponseOptions& options) {
  const Programme programme = sine_steps({.frequencies_hz = frequencies_hz,
                                          .amplitude_m = options.amplitude_m,
                                          .dwell_s = options.dwell_s,
                                          .transition_s = options.transition_s});
  const double duration_s = options.dwell_s * static_cast<double>(frequencies_hz.size());
  QzsTrajectory trajectory(std::make_shared<QzsRig>(parameters, programme), duration_s, options.poll);
  std::vector<ResponsePoint> points;
  for (std::size_t k = 0; k < frequencies_hz.size(); ++k) {
    // Whole periods, 200 samples each: a sine's peak is then met to 1.2e-4.
    const double f = frequencies_hz[k], end_s = options.dwell_s * static_cast<double>(k + 1);
    const double periods = std::max(1.0, std::floor(options.measured_fraction * options.dwell_s * f));
    const auto count = static_cast<int>(200.0 * periods);
    double x_low = std::numeric_limits<double>::infinity(), x_high = -x_low, y_low = x_low, y_high = -x_low;
    std::complex<double> x_turn, r_turn;  // fundamentals
    int stuck = 0;
    for (int i = 0; i < count; ++i) {
      const QzsState& state = trajectory.at(end_s - periods / f * (1.0 - static_cast<double>(i) / count));
      const double y = state.x + state.base.r_m;
      x_low = std::min(x_low, state.x), x_high = std::max(x_high, state.x);
      y_low = std::min(y_low, y), y_high = std::max(y_high, y);
      const auto turn = std::polar(1.0, -two_pi * periods * i / count);
      x_turn += state.x * turn, r_turn += state.base.r_m * turn;
      stuck += state.mode == qzs_stick;
    }
    points.push_back({.frequency_hz = f,
                      .x_m = 0.5 * (x_high - x_low),
                      .y_m = 0.5 * (y_high - y_low),
                      .phase_rad = stuck == count ? dsp::nan : std::arg(x_turn / r_turn),
                      .stuck_fraction = static_cast<double>(stuck) / count,
                      .locked = stuck == count});
  }
  return points;
}

}  // namespace

QzsParameters qzs_twin(std::string_view name) {
  if (name == "T0") return {};
  if (name == "T1")
    return {.k2 = -200.0,
            .mu_kinetic = 0.065,
            .stribeck_m_per_s = 0.01,
            .position_modulation = 0.2,
            .time_modulation = 0.1,
            .bounce_hz = 10.7,
            .second_highpass_hz = 0.30};
  throw std::invalid_argument(fmt::format("qzs: no twin \"{}\"; there are T0, T1", name));
}

void set_parameter(QzsParameters& parameters, std::string_view name, double value) {
  const auto* field = std::find_if(fields.begin(), fields.end(), [&](const auto& f) { return name == f.first; });
  if (field == fields.end()) {
    std::vector<std::string> names;
    for (const auto& [known, member] : fields) names.emplace_back(known);
    throw std::invalid_argument(fmt::format("qzs: no parameter \"{}\"; there are {}", name, fmt::join(names, ", ")));
  }
  parameters.*field->second = value;
}

void set_parameters(QzsParameters& parameters, const std::vector<std::pair<std::string, double>>& settings,
                    std::string_view of_what, std::string_view known) {
  for (const auto& [name, value] : settings) try {
      set_parameter(parameters, name, value);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(fmt::format("{}; {}: {}", error.what(), of_what, known));
    }
}

std::vector<std::pair<std::string, double>> parameter_values(const QzsParameters& parameters) {
  std::vector<std::pair<std::string, double>> values;
  for (const auto& [name, member] : fields) values.emplace_back(name, parameters.*member);
  return values;
}

std::vector<TrueTerm> true_terms(const QzsParameters& p) {
  std::vector<TrueTerm> terms{{1, "v", "v", 1.0},
                              {2, "a", "x", -p.k1},
                              {2, "a", "v", -p.c},
                              {2, "a", "x^3", -p.k3},
                              {2, "a", "sgn(v)", -p.mu_kinetic},
                              {2, "a", "ddr", -1.0}};
  if (p.k2 != 0.0) terms.push_back({2, "a", "x^2", -p.k2});
  return terms;
}

QzsRig::QzsRig(const QzsParameters& parameters, const Programme& programme)
    : parameters_(parameters), programme_(programme), base_(programme) {
  const auto need = [](bool met, std::string_view what, double got) {
    if (!met) throw std::invalid_argument(fmt::format("qzs: need {}, got {}", what, got));
  };
  need(parameters.stribeck_m_per_s >= 0.0, "stribeck_m_per_s >= 0", parameters.stribeck_m_per_s);
  need(std::abs(parameters.position_modulation) < 1.0, "|position_modulation| < 1", parameters.position_modulation);
  need(std::abs(parameters.time_modulation) < 1.0, "|time_modulation| < 1", parameters.time_modulation);
  need(parameters.position_period_m > 0.0, "position_period_m > 0", parameters.position_period_m);
  need(parameters.time_period_s > 0.0, "time_period_s > 0", parameters.time_period_s);
  need(parameters.bounce_hz >= 0.0, "bounce_hz >= 0", parameters.bounce_hz);
  need(parameters.bounce_damping >= 0.0, "bounce_damping >= 0", parameters.bounce_damping);
  need(parameters.second_highpass_hz >= 0.0, "second_highpass_hz >= 0", parameters.second_highpass_hz);
  // Otherwise a payload let go would be caught again at once, without end.
  if (!(parameters.mu_static >= parameters.mu_kinetic && parameters.mu_kinetic >= 0.0))
    throw std::invalid_argument(fmt::format("qzs: need 0 <= mu_kinetic <= mu_static, got {} and {}",
                                            parameters.mu_kinetic, parameters.mu_static));
}

double QzsRig::pull(double t, double x, double v, double ddr) const {
  const auto& p = parameters_;
  double force = -ddr - x * (p.k1 + x * (p.k2 + x * p.k3));
  if (!programme_.manual.empty()) {
    const double inside = t - std::floor(t / programme_.duration_s) * programme_.duration_s;
    for (const auto& hand : programme_.manual)
      if (const double window = hand.window(inside); window > 0.0)
        force +=
            window * (hand.by_base * ddr + hand.by_velocity_per_s * v + hand.stiffness_per_s2 * (hand.hold_at_m - x));
  }
  return force;
}

double QzsRig::modulation(double t, double x) const {
  const auto& p = parameters_;
  double factor = 1.0;
  if (p.position_modulation != 0.0) factor *= 1.0 + p.position_modulation * std::sin(two_pi * x / p.position_period_m);
  if (p.time_modulation != 0.0) factor *= 1.0 + p.time_modulation * std::sin(two_pi * t / p.time_period_s);
  return factor;
}

double QzsRig::acceleration(double t, double x, double v, double ddr, int mode) const {
  if (mode == qzs_stick) return 0.0;
  const auto& p = parameters_;
  double mu = p.mu_kinetic;
  // The sign of v is the mode's, also where an iterate strays across zero.
  if (p.stribeck_m_per_s > 0.0) mu += (p.mu_static - p.mu_kinetic) * std::exp(-mode * v / p.stribeck_m_per_s);
  return pull(t, x, v, ddr) - p.c * v - mode * mu * modulation(t, x);
}

System QzsRig::system() const {
  System s{.name = "qzs", .states = {"x", "v"}, .rhs = {}};
  s.rhs = [this, near = std::size_t{0}](double t, const double* y, int mode, double* dydt) mutable {
    dydt[0] = mode == qzs_stick ? 0.0 : y[1];
    dydt[1] = acceleration(t, y[0], y[1], base_.at(t, near).ddr_m_per_s2, mode);
  };
  add_switches(s, velocity_switch([this, near = std::size_t{0}](double t, const double* y) mutable {
                 const double force = pull(t, y[0], 0.0, base_.at(t, near).ddr_m_per_s2);
                 const double limit = parameters_.mu_static * modulation(t, y[0]);
                 return RatesAtZero{force - limit, force + limit};
               }));
  s.max_step_s = 0.02;
  s.scales = {1e-3, 1e-2};
  return s;
}

QzsTrajectory::QzsTrajectory(std::shared_ptr<const QzsRig> rig, double duration_s, std::function<void()> poll)
    : rig_(std::move(rig)),
      integrator_(rig_->system(), Eigen::Vector2d::Zero(),
                  {.duration_s = duration_s,
                   .sample_rate_hz = fastest_recorder_hz,
                   .relative_tolerance = 1e-10,
                   .absolute_tolerance = 1e-10,
                   .max_steps_per_output = most_steps_per_sample,
                   .poll = std::move(poll)}),
      duration_s_(duration_s) {}

void QzsTrajectory::next_substep() {
  const bool new_step = substep_ == num_substeps_;
  if (new_step) {
    if (!integrator_.step()) throw Diverged(integrator_.reason());
    substep_ = 0;
    num_substeps_ =
        std::max(1, static_cast<int>(std::ceil((integrator_.end_s() - integrator_.begin_s()) / longest_substep_s)));
    // A new mode or a new direction: the acceleration starts afresh, and v exactly at 0 after an event.
    double y[2];
    integrator_.states(integrator_.begin_s(), y);
    x_ = y[0], v_ = y[1], end_s_ = integrator_.begin_s();
    a_ = rig_->acceleration(end_s_, x_, v_, rig_->base().at(end_s_, near_).ddr_m_per_s2, integrator_.mode());
  }
  ++substep_;
  begin_s_ = end_s_;
  end_s_ = substep_ == num_substeps_
               ? integrator_.end_s()
               : integrator_.begin_s() + substep_ * (integrator_.end_s() - integrator_.begin_s()) / num_substeps_;
  double y[2];
  integrator_.states(end_s_, y);
  constexpr double far_m = 1e6;  // squares and cubes of what a sensor sees must stay numbers
  if (!(std::abs(y[0]) < far_m))
    throw Diverged(fmt::format("qzs: the payload runs away: x = {:.3g} m at {:.6g} s", y[0], end_s_));
  const double a1 =
      rig_->acceleration(end_s_, y[0], y[1], rig_->base().at(end_s_, near_).ddr_m_per_s2, integrator_.mode());
  const double h = end_s_ - begin_s_;
  const double c1 = h * v_, c2 = 0.5 * h * h * a_;
  const double dx = y[0] - x_ - c1 - c2, dv = h * y[1] - c1 - 2.0 * c2, da = h * h * a1 - 2.0 * c2;
  x_powers_ = {x_, c1, c2, 10.0 * dx - 4.0 * dv + 0.5 * da, -15.0 * dx + 7.0 * dv - da, 6.0 * dx - 3.0 * dv + 0.5 * da};
  x_ = y[0], v_ = y[1], a_ = a1;
}

const QzsState& QzsTrajectory::at(double t) & {
  state_.t_s = t;
  if (t <= 0.0 && end_s_ == 0.0) return state_;
  if (!(t >= begin_s_ && t <= duration_s_))
    throw std::invalid_argument(
        fmt::format("QzsTrajectory: times must increase up to {} s, got {} after {}", duration_s_, t, begin_s_));
  while (t > end_s_) next_substep();
  const auto& p = x_powers_;
  const double h = end_s_ - begin_s_, u = h > 0.0 ? (t - begin_s_) / h : 0.0;
  state_.x = p[0] + u * (p[1] + u * (p[2] + u * (p[3] + u * (p[4] + u * p[5]))));
  state_.v = h > 0.0 ? (p[1] + u * (2.0 * p[2] + u * (3.0 * p[3] + u * (4.0 * p[4] + u * 5.0 * p[5])))) / h : v_;
  state_.mode = integrator_.mode();
  state_.base = rig_->base().at(t, near_);
  state_.a = rig_->acceleration(t, state_.x, state_.v, state_.base.ddr_m_per_s2, state_.mode);
  return state_;
}

FrequencyResponse frequency_response(const QzsParameters& parameters, const FrequencyResponseOptions& options) {
  std::vector<double> frequencies_hz = sweep_frequencies(options);
  FrequencyResponse response;
  response.up = sweep(parameters, frequencies_hz, options);
  std::reverse(frequencies_hz.begin(), frequencies_hz.end());
  response.down = sweep(parameters, frequencies_hz, options);
  response.jumps = find_jumps(response.up, response.down, options.jump_factor);
  return response;
}

}  // namespace sim
