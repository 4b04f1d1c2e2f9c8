#include "apps/paper/replicate_case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>

#include "apps/paper/free_response.hpp"
#include "ident/methods.hpp"
#include "ident/regression/multi_rvm.hpp"
#include "sim/noise.hpp"

namespace apps {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::uint64_t first_held_out_id = 5000;  // of noise sequences, apart from the training's

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// What is compared row by row, with the name of each way.
std::vector<std::pair<std::string, ident::MethodOptions>> methods(const ReplicateOptions& options) {
  std::vector<std::pair<std::string, ident::MethodOptions>> result;
  const std::vector<ident::MethodOptions> each{
      ident::FastRvmOptions{.selection = options.selection, .tau = options.tau},
      ident::SlowRvmOptions{.selection = options.selection, .tau = options.tau},
      ident::StlsqOptions{},
      ident::StlsqOptions{.threshold = raw_threshold, .unit_norm = false},
      ident::LassoOptions{},
      ident::OlsOptions{}};
  for (const ident::MethodOptions& one : each) {
    const auto* stlsq = std::get_if<ident::StlsqOptions>(&one);
    const bool raw = stlsq != nullptr && !stlsq->unit_norm;
    result.emplace_back(std::string(ident::description(one).name) + (raw ? "_raw" : ""), one);
  }
  return result;
}

SupportError error_of(const ident::Fit& fit, const Section4Row& row) {
  return row.truth_known ? support_error(fit, row.truth) : SupportError{};
}

void fit_seed(CaseReplication& result, const ReplicateOptions& options, std::uint64_t seed) {
  for (std::size_t g = 0; g < result.study.regressions.size(); ++g) {
    const Section4Regression& regression = result.study.regressions[g];
    double begun = cpu_seconds();
    const auto data = section4_factor(result.study, regression, options.noise, seed);
    result.accumulate_seconds += (cpu_seconds() - begun) / options.num_seeds;
    const auto add = [&](std::size_t row, std::string method, ident::Fit fit, double seconds) {
      SupportError error = error_of(fit, regression.rows[row]);
      result.fits.push_back({seed, g, row, std::move(method), std::move(fit), std::move(error), seconds});
    };
    for (std::size_t j = 0; j < regression.rows.size(); ++j) {
      const auto own = row_factor(data, j);
      for (const auto& [name, method] : methods(options)) {
        begun = cpu_seconds();
        ident::Fit fit = ident::fit(own, method);
        add(j, name, std::move(fit), cpu_seconds() - begun);
      }
    }
    begun = cpu_seconds();
    ident::MultiFit multi = ident::fit_multi_rvm(data, {.selection = options.selection, .tau = options.tau});
    const double seconds = (cpu_seconds() - begun) / static_cast<double>(regression.rows.size());
    for (std::size_t j = 0; j < multi.rows.size(); ++j) add(j, "multi_rvm", std::move(multi.rows[j]), seconds);
  }
}

/// The identified equations of all states.
std::vector<ident::StateEquation> identified_equations(const CaseReplication& result, std::uint64_t seed,
                                                       const std::string& method) {
  std::vector<ident::StateEquation> equations;
  for (const CaseFit& fit : result.fits) {
    if (fit.seed != seed || fit.method != method) continue;
    const Section4Row& row = result.row_of(fit);
    equations.push_back(
        {static_cast<std::size_t>(row.row - 1), {}, {fit.fit.mean.begin(), fit.fit.mean.end()}, row.where});
    for (const Index term : fit.fit.relevant)
      equations.back().terms.push_back(result.study.library.terms[static_cast<std::size_t>(term)].name);
  }
  return equations;
}

// The columns of these library terms on a record.
MatrixXd columns_on(const Section4Study& study, const std::vector<Index>& terms, const dsp::Motion& motion) {
  MatrixXd phi(motion.num_samples(), static_cast<Index>(terms.size()));
  for (std::size_t k = 0; k < terms.size(); ++k)
    phi.col(static_cast<Index>(k)) =
        study.library.terms[static_cast<std::size_t>(terms[k])].expression.evaluate(motion);
  return phi;
}

sim::Simulation run_identified(CaseReplication& result, const Section4Record& record, std::uint64_t seed,
                               const std::string& method) {
  const Section4Case& definition = *result.study.definition;
  auto run = free_response(definition, identified_equations(result, seed, method), record);
  for (StateError& error : state_errors(run, definition, record))
    result.scores.push_back(
        {seed, method, "free_run", record.ratio, std::move(error.signal), error.nmse, std::move(error.status)});
  return run;
}

// Rates predicted from the true states, and how well their bands hold noisy ones.
void score_rates(CaseReplication& result, const ReplicateOptions& options, const Section4Record& record,
                 std::uint64_t seed) {
  std::vector<std::string> names;
  for (const dsp::Signal& signal : record.motion.signals) names.push_back(signal.name);
  for (const CaseFit& fit : result.fits) {
    if (fit.seed != seed || fit.method != "fast_rvm") continue;
    const Section4Row& row = result.row_of(fit);
    std::vector<Index> samples;
    const auto holds = ident::rows_where(ident::Expression(row.where.empty() ? "1" : row.where, names), record.motion);
    for (std::size_t i = 0; i < holds.size(); ++i)
      if (holds[i] != 0) samples.push_back(static_cast<Index>(i));
    const MatrixXd phi = columns_on(result.study, fit.fit.relevant, record.motion)(samples, Eigen::all);
    const VectorXd predicted = phi * fit.fit.mean, actual = record.motion.at(row.target)(samples);
    result.scores.push_back(
        {seed, fit.method, "one_step", record.ratio, row.target, ident::nmse(predicted, actual), "finished"});
    if (!(options.noise > 0.0)) continue;
    const sim::Noise draw(seed, first_held_out_id + 10 * static_cast<std::uint64_t>(std::lround(100.0 * record.ratio)) +
                                    static_cast<std::uint64_t>(row.row));
    VectorXd noisy = actual;
    for (Index i = 0; i < noisy.size(); ++i)
      noisy(i) +=
          options.noise * row.std * draw.normal(static_cast<std::uint64_t>(samples[static_cast<std::size_t>(i)]));
    const VectorXd variance = ident::predictive_variance(phi, fit.fit.covariance, fit.fit.noise_variance);
    result.bands.push_back({seed, row.label(), record.ratio, ident::band_fractions(predicted, variance, noisy)});
  }
}

}  // namespace

CaseReplication replicate_case(const Section4Case& definition, const ReplicateOptions& options,
                               const std::function<void(double)>& between) {
  const auto done = [&](double fraction) {
    if (between) between(fraction);
  };
  CaseReplication result;
  result.study = section4_study(definition);
  for (const double ratio : definition.held_out_ratios) result.runs.push_back({section4_record(definition, ratio), {}});
  for (int k = 0; k < options.num_seeds; ++k) {
    done(static_cast<double>(k) / options.num_seeds);
    const std::uint64_t seed = options.first_seed + static_cast<std::uint64_t>(k);
    fit_seed(result, options, seed);
    for (HeldOutRun& run : result.runs) {
      auto simulated = run_identified(result, run.record, seed, "fast_rvm");
      score_rates(result, options, run.record, seed);
      if (k > 0) continue;
      run.identified = std::move(simulated);
      for (const char* method : {"slow_rvm", "sindy"}) (void)run_identified(result, run.record, seed, method);
    }
  }
  done(1.0);
  return result;
}

}  // namespace apps
