#pragma once
#include <string>
#include <vector>

#include "ident/state_space/select.hpp"
#include "sim/noise.hpp"
#include "sim/simulate.hpp"
#include "sim/systems.hpp"

namespace support {

/// Records of a simulated oscillator from rest, driven at these ratios of its natural frequency: the motion without
/// noise, and the force.
struct Runs {
  std::vector<sim::Simulation> motions;
  std::vector<Eigen::MatrixXd> forces;
  double sample_rate_hz = 0.0;
};
template <class Parameters>
Runs runs_of(Parameters parameters, const std::vector<double>& ratios, double duration_s, double sample_rate_hz) {
  Runs runs{.sample_rate_hz = sample_rate_hz};
  for (const double ratio : ratios) {
    parameters.ratio = ratio;
    const sim::Experiment experiment = sim::make_experiment(parameters);
    runs.motions.push_back(sim::simulate(experiment.system, experiment.initial,
                                         {.duration_s = duration_s, .sample_rate_hz = sample_rate_hz}));
    runs.forces.emplace_back(runs.motions.back().time_s.unaryExpr(experiment.system.forcing));
  }
  return runs;
}
inline const std::vector<double> seven_ratios{0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3};

/// x, v or a of these with white noise of `noise` times its root mean square, candidates `terms`.
inline ident::state_space::Problem problem_of(const Runs& runs, const std::vector<std::string>& terms,
                                              const std::string& channels, double noise, std::uint64_t seed) {
  using namespace ident::state_space;
  Problem problem{.equations = oscillator(terms, {"f"}), .sample_rate_hz = runs.sample_rate_hz};
  for (const char name : channels)
    problem.channels.push_back({.name = std::string(1, name), .state = name == 'x' ? 0 : 1, .rate = name == 'a'});
  const auto m = static_cast<Eigen::Index>(channels.size());
  const auto column = [&](std::size_t r, Eigen::Index j) -> Eigen::VectorXd {
    const Channel& channel = problem.channels[static_cast<std::size_t>(j)];
    return (channel.rate ? runs.motions[r].derivatives : runs.motions[r].states).col(channel.state);
  };
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(m);
  double samples = 0.0;
  for (std::size_t r = 0; r < runs.motions.size(); ++r) {
    for (Eigen::Index j = 0; j < m; ++j) squares(j) += column(r, j).squaredNorm();
    samples += static_cast<double>(runs.forces[r].rows());
  }
  for (std::size_t r = 0; r < runs.motions.size(); ++r) {
    Record record{Eigen::MatrixXd(runs.forces[r].rows(), m), runs.forces[r]};
    for (Eigen::Index j = 0; j < m; ++j) {
      const sim::Noise draw(seed, 10 * r + static_cast<std::uint64_t>(j));
      record.channels.col(j) = column(r, j);
      for (Eigen::Index k = 0; k < record.channels.rows(); ++k)
        record.channels(k, j) += noise * std::sqrt(squares(j) / samples) * draw.normal(static_cast<std::uint64_t>(k));
    }
    problem.records.push_back(record);
  }
  return problem;
}

/// Coefficient `term` of a fit and its standard deviation; that is 0 where it was not sought.
struct Estimate {
  double value = 0.0, std = 0.0;
};
inline Estimate estimate_of(const ident::state_space::Fit& fit, int parameter) {
  for (std::size_t i = 0; i < fit.parameters.size(); ++i)
    if (fit.parameters[i] == parameter) return {fit.point.parameters[static_cast<std::size_t>(parameter)], fit.std(i)};
  return {};
}

/// How a selection stands to the true coefficients, of all candidates.
struct Comparison {
  bool exact = true;        ///< the terms are those that are not zero
  double worst = 0.0;       ///< largest relative error of a true term
  int covered = 0, of = 0;  ///< true values within 1.96 standard deviations
};
inline Comparison compare(const ident::state_space::Fit& fit, const std::vector<double>& truth) {
  Comparison result;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const auto [value, std] = estimate_of(fit, static_cast<int>(i));
    result.exact = result.exact && (std > 0.0) == (truth[i] != 0.0);
    if (truth[i] == 0.0) continue;
    const double error = std::abs(value - truth[i]);
    result.worst = std::max(result.worst, error / std::abs(truth[i]));
    result.covered += error <= 1.96 * std ? 1 : 0;
    ++result.of;
  }
  return result;
}

inline const std::vector<std::string> duffing_library{"1",   "x",     "v",     "x^2", "x*v", "v^2",
                                                      "x^3", "x^2*v", "x*v^2", "v^3", "f"};
inline const std::vector<double> duffing_truth{0, -25, -1, 0, 0, 0, -2500, 0, 0, 0, 100};
inline const std::vector<std::string> coulomb_library{"1", "x", "v", "x^2", "x*v", "v^2", "sgn(v)", "f"};
inline const std::vector<double> coulomb_truth{0, -1000, -2, 0, 0, 0, -1, 100};

}  // namespace support
