#pragma once
#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

#include "dsp/sensors/motion.hpp"
#include "sim/simulate.hpp"
#include "sim/systems.hpp"

namespace support {

/// t, x, v, a, f of a simulated oscillator, exact at every sample.
inline dsp::Motion motion_of(const sim::Experiment& experiment, double duration_s, double sample_rate_hz) {
  const sim::Simulation run = sim::simulate(experiment.system, experiment.initial,
                                            {.duration_s = duration_s, .sample_rate_hz = sample_rate_hz});
  Eigen::VectorXd force(run.time_s.size());
  for (Eigen::Index i = 0; i < force.size(); ++i) force(i) = experiment.system.forcing(run.time_s(i));
  dsp::Motion motion;
  motion.sample_rate_hz = sample_rate_hz;
  motion.signals = {{"t", "s", run.time_s},
                    {"x", "m", run.states.col(0)},
                    {"v", "m/s", run.states.col(1)},
                    {"a", "m/s^2", run.derivatives.col(1)},
                    {"f", "N", force}};
  return motion;
}

/// A mass whose dry friction acts against the ground while its spring pulls from a shaken base: the Coulomb oscillator
/// with its force read as k r(t). y'' = -k x - c y' - c_f sgn(y') per unit mass, x = y - r. It sticks in every cycle.
inline dsp::Motion friction_on_the_ground(const sim::Coulomb& p, double duration_s, double sample_rate_hz) {
  const sim::Experiment experiment = sim::make_experiment(p);
  const dsp::Motion coulomb = motion_of(experiment, duration_s, sample_rate_hz);
  const double omega = p.ratio * experiment.omega_n, amplitude = p.force_n / p.k;
  const Eigen::ArrayXd phase = omega * coulomb.at("t").array();
  const Eigen::VectorXd r = amplitude * phase.cos(), dr = -amplitude * omega * phase.sin(), ddr = -omega * omega * r;
  const Eigen::VectorXd &y = coulomb.at("x"), &dy = coulomb.at("v"), &ddy = coulomb.at("a");
  dsp::Motion motion;
  motion.sample_rate_hz = sample_rate_hz;
  motion.signals = {{"t", "s", coulomb.at("t")}, {"x", "m", y - r}, {"v", "m/s", dy - dr},
                    {"a", "m/s^2", ddy - ddr},   {"y", "m", y},     {"dy", "m/s", dy},
                    {"ddy", "m/s^2", ddy},       {"r", "m", r},     {"dr", "m/s", dr},
                    {"ddr", "m/s^2", ddr}};
  return motion;
}

}  // namespace support
