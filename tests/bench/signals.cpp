#include <algorithm>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#include "bench/bench.hpp"
#include "dsp/filter/fft.hpp"
#include "sim/simulate.hpp"
#include "sim/systems.hpp"

namespace {

using Eigen::Index;

constexpr Index num_samples = 44032;

// Forward, times i 2 pi f, back.
void derivative(Index length) {
  const Eigen::VectorXd signal = Eigen::VectorXd::LinSpaced(length, -1.0, 1.0).array().cube();
  const dsp::RealFft fft(length);
  Eigen::VectorXcd spectrum = fft.forward(signal);
  for (Index k = 0; k < spectrum.size(); ++k)
    spectrum(k) *= std::complex<double>(0.0, 2.0 * std::numbers::pi * static_cast<double>(k) / 25.6);
  static_cast<void>(fft.inverse(std::move(spectrum)));
}

// The seven training records of a case of the paper.
std::vector<sim::Simulation> simulate_records(const std::string& system, double relative_tolerance) {
  std::vector<sim::Simulation> records;
  for (int record = 0; record < 7; ++record) {
    const sim::Experiment experiment = sim::make_experiment(system, {{"ratio", 0.7 + 0.1 * record}});
    records.push_back(sim::simulate(experiment.system, experiment.initial,
                                    {.duration_s = 25.0,
                                     .sample_rate_hz = 100.0,
                                     .relative_tolerance = relative_tolerance,
                                     .absolute_tolerance = 0.01 * relative_tolerance}));
  }
  return records;
}

// The largest error of a state over its root mean square in all records, against much tighter tolerances.
double error_of(const std::vector<sim::Simulation>& records, const std::vector<sim::Simulation>& exact) {
  Eigen::RowVectorXd mean_square = Eigen::RowVectorXd::Zero(exact[0].states.cols());
  for (const sim::Simulation& record : exact)
    mean_square += record.states.array().square().matrix().colwise().mean() / static_cast<double>(exact.size());
  double worst = 0.0;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const Eigen::RowVectorXd largest = (records[i].states - exact[i].states).cwiseAbs().colwise().maxCoeff();
    worst = std::max(worst, (largest.array() / mean_square.array().sqrt()).maxCoeff());
  }
  return worst;
}

void add_simulation(const std::string& system) {
  constexpr double tolerance = 1e-9, exact = 1e-13;  // its error is below that of the peers, which are given 1e-8
  bench::add(
      "simulate/" + system, [=] { static_cast<void>(simulate_records(system, tolerance)); },
      [=]() -> bench::Figures {
        const auto records = simulate_records(system, tolerance);
        double num_events = 0.0;
        for (const sim::Simulation& record : records) num_events += static_cast<double>(record.events.size());
        return {{"error", error_of(records, simulate_records(system, exact))}, {"reversals", num_events}};
      });
}

}  // namespace

void bench::register_signals() {
  add("derivative/plan_kept", [] { derivative(num_samples); });
  add_simulation("duffing");
  add_simulation("coulomb");
}
