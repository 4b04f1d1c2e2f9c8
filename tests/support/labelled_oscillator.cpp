#include "support/labelled_oscillator.hpp"

#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "sim/noise.hpp"
#include "sim/ode/friction.hpp"
#include "sim/simulate.hpp"

namespace support {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

sim::System system_of(const Oscillator& p) {
  sim::System system{.name = "labelled", .states = {"x", "v"}};
  system.scales = {p.amplitude, p.amplitude * p.omega};
  system.max_step_s = p.friction > 0.0 || p.has_z() ? 0.15 / p.omega : 0.0;
  if (p.has_z()) {
    system.states.push_back("z");
    system.scales.push_back(p.z_stiffness * p.amplitude);
    system.rhs = [p](double t, const double* y, int mode, double* dydt) {
      double side[2];
      sim::sides_of(mode, 2, side);
      const double abs_v = side[0] < 0.0 ? -y[1] : y[1], abs_z = side[1] < 0.0 ? -y[2] : y[2];
      dydt[0] = y[1];
      dydt[1] = p.acceleration(t, y);
      dydt[2] = p.z_stiffness * y[1] - p.z_bend * (p.z_share * y[2] * abs_v + (1.0 - p.z_share) * abs_z * y[1]);
    };
    sim::add_switches(system, {.count = 2,
                               .value = [](int i, double, const double* y) { return y[i + 1]; },
                               .rates_at_zero = [p](int i, double t, const double* y,
                                                    const double* sides) -> std::optional<sim::RatesAtZero> {
                                 const double rate = i == 1 ? sides[0] : p.acceleration(t, y);
                                 return sim::RatesAtZero{rate, rate};
                               },
                               .settle = [](int i, int, double, double* y) { y[i + 1] = 0.0; }});
    return system;
  }
  const bool dry = p.friction > 0.0;
  system.rhs = [p, dry](double t, const double* y, int mode, double* dydt) {
    const bool rests = dry && mode == 0;
    dydt[0] = rests ? 0.0 : y[1];
    dydt[1] = rests ? 0.0 : p.acceleration(t, y) - (dry ? mode * p.friction : 0.0);
  };
  if (dry)
    sim::add_switches(system, sim::velocity_switch([p](double t, const double* y) {
                        const double pull = p.acceleration(t, y);
                        return sim::RatesAtZero{pull - p.friction, pull + p.friction};
                      }));
  return system;
}

double rms(const VectorXd& values) {
  return std::sqrt(values.squaredNorm() / static_cast<double>(values.size()));
}

}  // namespace

DriveValue Drive::at(double t) const {
  DriveValue sum;
  for (const Tone& tone : tones) {
    const double angle = tone.phase + (tone.omega + 0.5 * tone.sweep * t) * t, omega = tone.omega + tone.sweep * t;
    const double s = scale * tone.amplitude * std::sin(angle), c = scale * tone.amplitude * std::cos(angle);
    sum.value += s;
    sum.rate += omega * c;
    sum.second += tone.sweep * c - omega * omega * s;
  }
  return sum;
}

double Oscillator::acceleration(double t, const double* y) const {
  const DriveValue d = drive.at(t);
  const double x = base ? y[0] - d.value : y[0], v = base ? y[1] - d.rate : y[1];
  return (base ? 0.0 : force_gain * d.value) - (k + k3 * x * x) * x - (c + xxv * x * x) * v -
         (has_z() ? z_gain * y[2] : 0.0);
}

dsp::Motion motion_of(const Oscillator& p, double duration_s, double rate_hz) {
  VectorXd initial = VectorXd::Zero(p.has_z() ? 3 : 2);
  initial.head(2) << p.x0, p.v0;
  const sim::Simulation run = sim::simulate(
      system_of(p), initial, {.duration_s = duration_s, .sample_rate_hz = rate_hz, .relative_tolerance = 1e-11});
  if (run.status != sim::SimulationStatus::finished) throw std::runtime_error("labelled record: " + run.reason);
  const Index n = run.time_s.size();
  Eigen::MatrixX3d d(n, 3);
  for (Index i = 0; i < n; ++i) {
    const DriveValue value = p.drive.at(run.time_s(i));
    d.row(i) << value.value, value.rate, value.second;
  }
  const VectorXd y = run.states.col(0), dy = run.states.col(1), ddy = run.derivatives.col(1);
  dsp::Motion motion{.sample_rate_hz = rate_hz};
  motion.signals = {{"t", "s", run.time_s}};
  if (p.base)
    for (auto& signal : std::vector<dsp::Signal>{{"x", "m", y - d.col(0)},
                                                 {"v", "m/s", dy - d.col(1)},
                                                 {"a", "m/s^2", ddy - d.col(2)},
                                                 {"y", "m", y},
                                                 {"dy", "m/s", dy},
                                                 {"ddy", "m/s^2", ddy},
                                                 {"r", "m", d.col(0)},
                                                 {"dr", "m/s", d.col(1)},
                                                 {"ddr", "m/s^2", d.col(2)}})
      motion.signals.push_back(std::move(signal));
  else
    for (auto& signal :
         std::vector<dsp::Signal>{{"x", "m", y}, {"v", "m/s", dy}, {"a", "m/s^2", ddy}, {"f", "N", d.col(0)}})
      motion.signals.push_back(std::move(signal));
  if (p.has_z()) motion.signals.push_back({"z", "N", run.states.col(2)});
  return motion;
}

dsp::Recording recorded(const dsp::Motion& motion, const std::vector<std::string>& names, double noise,
                        std::uint32_t seed) {
  dsp::Recording recording{.name = "labelled", .sample_rate_hz = motion.sample_rate_hz};
  recording.samples.resize(motion.num_samples(), static_cast<Index>(names.size()));
  for (std::size_t c = 0; c < names.size(); ++c) {
    const dsp::Signal& signal = *motion.find(names[c]);
    recording.channels.push_back({.name = names[c], .role = dsp::role_from_string(names[c]), .unit = signal.unit});
    const sim::Noise generator(seed, c);
    const double std = noise * rms(signal.values);
    for (Index i = 0; i < signal.values.size(); ++i)
      recording.samples(i, static_cast<Index>(c)) =
          signal.values(i) + std * generator.normal(static_cast<std::uint64_t>(i));
  }
  return recording;
}

}  // namespace support
