#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "apps/cli/simulate_jobs.hpp"
#include "apps/config/parameter_settings.hpp"
#include "apps/output/truth_json.hpp"
#include "dsp/values/memory_limit.hpp"
#include "sim/chain.hpp"
#include "sim/simulate.hpp"

namespace apps {
namespace {

using nlohmann::ordered_json;
using Settings = std::vector<std::pair<std::string, double>>;

constexpr double chain_rate_hz = 200.0, chain_duration_s = 60.0;
constexpr std::uint64_t chain_noise_id = 1000;

/// Takes a setting out of the list.
double taken(Settings& set, const std::string& name, double preset) {
  const auto found = std::find_if(set.begin(), set.end(), [&](const auto& one) { return one.first == name; });
  if (found == set.end()) return preset;
  const double value = found->second;
  set.erase(found);
  return value;
}

std::string response_of(const sim::Simulation& run, const sim::Chain& chain, const sim::Drive& drive, double noise,
                        std::uint64_t seed) {
  const auto n = static_cast<Eigen::Index>(chain.masses.size());
  Eigen::MatrixXd values(run.states.rows(), n + 2);
  values << run.time_s, run.states.leftCols(n), run.time_s.unaryExpr(drive.value);
  std::vector<std::string> names{"time_s"};
  for (Eigen::Index body = 1; body <= n; ++body) {
    names.push_back(fmt::format("x{}", body));
    if (noise > 0.0) add_noise(values.col(body), noise, seed, chain_noise_id + static_cast<std::uint64_t>(body - 1));
  }
  names.emplace_back(chain.base_driven ? "r" : "f");
  return csv_of(names, values);
}

}  // namespace

std::vector<std::string> simulate_chain(const SimulateArguments& arguments, const OutputFolder& folder,
                                        Console& console, ordered_json& truth) {
  refuse_options_of_rig(arguments);
  double duration_s = arguments.duration_s.value_or(0.0);
  sim::Chain chain;
  sim::Drive drive;
  sim::Experiment experiment;
  try {
    Settings set = parse_settings(arguments.set);
    const double from_hz = taken(set, "from_hz", 0.3), to_hz = taken(set, "to_hz", 4.0), rms = taken(set, "rms", 0.0);
    chain = sim::make_chain(set);
    constexpr double force_n = 10.0, base_m = 0.03;  // of which the cubic coupling is felt
    if (!(from_hz >= 0.0 && to_hz > from_hz && to_hz < 0.25 * chain_rate_hz && rms >= 0.0))
      throw std::invalid_argument(
          fmt::format("chain: from_hz = {}, to_hz = {}, rms = {}: want 0 <= from_hz < to_hz < {} and rms above 0",
                      from_hz, to_hz, rms, 0.25 * chain_rate_hz));
    drive = arguments.drive.empty() ? sim::random_drive(arguments.seed, from_hz, to_hz,
                                                        rms > 0.0           ? rms
                                                        : chain.base_driven ? base_m
                                                                            : force_n)
                                    : recorded_drive(arguments.drive, chain.base_driven, duration_s);
    experiment = sim::make_experiment(chain, drive);
  } catch (const std::invalid_argument& error) {
    throw dsp::Fault(dsp::FaultKind::usage, "sim.option", fmt::format("sim {}", error.what()));
  }
  if (duration_s == 0.0) duration_s = chain_duration_s;
  constexpr double bytes_per_value = 40.0;
  dsp::require_machine_memory(
      "sim chain", duration_s * chain_rate_hz * 4.0 * static_cast<double>(experiment.initial.size()) * bytes_per_value,
      "Shorten --duration");
  const sim::SimulateOptions options{
      .duration_s = duration_s, .sample_rate_hz = chain_rate_hz, .poll = shown_poll(console, "simulating")};
  const sim::Simulation run = sim::simulate(experiment.system, experiment.initial, options);
  if (run.status != sim::SimulationStatus::finished)
    throw dsp::Fault(dsp::FaultKind::numerics, "sim.diverged",
                     fmt::format("sim {}. Try other parameters or a shorter --duration", run.reason));
  const double noise = arguments.noise.value_or(0.0);
  folder.write("response.csv", response_of(run, chain, drive, noise, arguments.seed));
  truth["noise"] = noise;
  truth["duration_s"] = duration_s;
  put_equation(truth, experiment.parameters, experiment.truth);
  truth["num_events"] = run.events.size();
  return {"response.csv"};
}

}  // namespace apps
