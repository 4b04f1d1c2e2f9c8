#include <complex>
#include <numbers>
#include <string>

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
void simulate_records(const std::string& system, double relative_tolerance) {
  for (int record = 0; record < 7; ++record) {
    const sim::Experiment experiment = sim::make_experiment(system, {{"ratio", 0.7 + 0.1 * record}});
    static_cast<void>(sim::simulate(experiment.system, experiment.initial,
                                    {.duration_s = 25.0,
                                     .sample_rate_hz = 100.0,
                                     .relative_tolerance = relative_tolerance,
                                     .absolute_tolerance = 0.01 * relative_tolerance}));
  }
}

}  // namespace

void bench::register_signals() {
  add("derivative/plan_kept", [] { derivative(num_samples); });
  add("simulate/duffing", [] { simulate_records("duffing", 1e-8); });
  add("simulate/coulomb", [] { simulate_records("coulomb", 1e-8); });
}
