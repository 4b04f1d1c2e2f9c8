#include "apps/paper/replicate_case.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>

#include "apps/paper/paper_data.hpp"
#include "apps/process/interrupt.hpp"
#include "apps/text/json_number.hpp"
#include "ident/regression/methods.hpp"
#include "ident/regression/multi_rvm.hpp"
#include "ident/validate/metrics.hpp"

namespace apps {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

std::vector<std::pair<std::string, ident::MethodOptions>> methods(const ReplicateOptions& options) {
  const double raw = paper_cases().number("raw_threshold").value();
  return {{"fast_rvm", ident::FastRvmOptions{.selection = options.selection, .tau = options.tau}},
          {"slow_rvm", ident::SlowRvmOptions{.selection = options.selection, .tau = options.tau}},
          {"sindy", ident::StlsqOptions{}},
          {"sindy_raw", ident::StlsqOptions{.threshold = raw, .unit_norm = false}},
          {"lasso", ident::LassoOptions{}},
          {"ols", ident::OlsOptions{}}};
}

Json steps_json(const Section4Study& study, const ident::Fit& fit) {
  const auto name_of = [&](Index term) { return term < 0 ? Json() : Json(names_of(study, {term}).front()); };
  Json steps = Json::array();
  for (const ident::FitStep& step : fit.steps) {
    steps.push_back({{"action", ident::to_string(step.action)},
                     {"term", name_of(step.term)},
                     {"log_evidence", number_or_null(step.log_evidence)},
                     {"noise_variance", number_or_null(step.noise_variance)}});
    if (step.action == ident::FitAction::start) steps.back()["terms"] = names_of(study, step.terms);
    if (step.action == ident::FitAction::exchange) steps.back()["leaving"] = name_of(step.leaving);
    if (std::isfinite(step.penalty)) steps.back()["lambda"] = step.penalty;
  }
  return steps;
}

/// What `fit` found of a row; case, seed and method in front, seconds behind are put there by the caller.
void put_fit(Json& into, const Section4Study& study, const Section4Row& row, const ident::Fit& fit) {
  const SupportError error = row.truth_known ? support_error(fit, row.truth) : SupportError{};
  Json terms = Json::array(), rejected = Json::array();
  for (Index i = 0, j = 0; i < row.truth.size(); ++i) {
    const std::string name = names_of(study, {i}).front();
    const Json inclusion = number_or_null(fit.inclusion_probability(i));
    if (std::binary_search(fit.relevant.begin(), fit.relevant.end(), i)) {
      terms.push_back({{"name", name},
                       {"true", number_or_null(row.truth_known ? row.truth(i) : missing)},
                       {"mean", fit.mean(j)},
                       {"std", number_or_null(std::sqrt(fit.interval_covariance()(j, j)))},
                       {"std_noise", number_or_null(std::sqrt(fit.covariance(j, j)))},
                       {"inclusion_probability", inclusion}});
      ++j;
    } else if (i < fit.evidence_gain.size()) {
      rejected.push_back({{"name", name}, {"inclusion_probability", inclusion}});
    }
  }
  into["selection"] = fit.selection ? Json(ident::to_string(*fit.selection)) : Json();
  into["tau"] = fit.selection ? Json(fit.tau) : Json();
  into["status"] = ident::to_string(fit.status);
  into["iterations"] = fit.iterations;
  into["discarded_iterations"] = fit.discarded_iterations;
  into["support_exact"] = row.truth_known ? Json(error.exact()) : Json();
  into["false_terms"] = names_of(study, error.false_terms);
  into["missing_terms"] = names_of(study, error.missing_terms);
  into["terms"] = std::move(terms);
  into["rejected"] = std::move(rejected);
  into["noise_std"] = number_or_null(std::sqrt(fit.noise_variance));
  into["log_evidence"] = number_or_null(fit.log_evidence);
  into["condition_number"] = number_or_null(fit.condition_number);
  into["steps"] = steps_json(study, fit);
}

/// An equation found, until it has been run.
struct FoundEquation {
  const Section4Row* row;
  std::string method;
  ident::Fit fit;
};

std::vector<FoundEquation> fit_seed(CaseReplication& result, const ReplicateOptions& options, std::uint64_t seed) {
  std::vector<FoundEquation> found;
  for (const Section4Regression& regression : result.study.regressions) {
    double begun = cpu_seconds();
    const auto data = section4_factor(result.study, regression, options.noise, seed);
    Json& accumulated = result.document["accumulate"].front()["seconds"];
    accumulated = accumulated.get<double>() + (cpu_seconds() - begun) / options.num_seeds;
    const auto add = [&](const Section4Row& row, const std::string& method, ident::Fit fit, double seconds) {
      Json entry{{"case", result.study.definition->name},
                 {"row", row.label()},
                 {"seed", seed},
                 {"noise", options.noise},
                 {"method", method}};
      put_fit(entry, result.study, row, fit);
      entry["seconds"] = seconds;
      result.document["fits"].push_back(std::move(entry));
      found.push_back({&row, method, std::move(fit)});
    };
    for (std::size_t j = 0; j < regression.rows.size(); ++j)
      for (const auto& [name, method] : methods(options)) {
        const auto own = row_factor(data, j);
        begun = cpu_seconds();
        ident::Fit fit = ident::fit(own, method);
        add(regression.rows[j], name, std::move(fit), cpu_seconds() - begun);
      }
    begun = cpu_seconds();
    ident::MultiFit multi = ident::fit_multi_rvm(data, {.selection = options.selection, .tau = options.tau});
    const double seconds = (cpu_seconds() - begun) / static_cast<double>(regression.rows.size());
    for (std::size_t j = 0; j < multi.rows.size(); ++j)
      add(regression.rows[j], "multi_rvm", std::move(multi.rows[j]), seconds);
  }
  return found;
}

void add_score(CaseReplication& result, const char* kind, std::uint64_t seed, const std::string& method, double ratio,
               const std::string& signal, double nmse, const std::string& status = "finished") {
  result.document[kind].push_back({{"case", result.study.definition->name},
                                   {"seed", seed},
                                   {"method", method},
                                   {"ratio", ratio},
                                   {"signal", signal},
                                   {"nmse", number_or_null(nmse)},
                                   {"status", status}});
}

sim::Simulation run_identified(CaseReplication& result, const std::vector<FoundEquation>& found,
                               const Section4Record& record, std::uint64_t seed, const std::string& method) {
  const Section4Case& definition = *result.study.definition;
  std::vector<ident::StateEquation> equations;
  for (const FoundEquation& one : found)
    if (one.method == method)
      equations.push_back(state_equation(result.study, *one.row, one.fit.relevant, one.fit.mean));
  auto run = free_response(definition, equations, record);
  for (int state = 0; state < definition.num_rows(); ++state)
    add_score(result, "free_run", seed, method, record.ratio, definition.variables[static_cast<std::size_t>(state)],
              state_error(run, record, state), run.reason.empty() ? "finished" : "diverged: " + run.reason);
  return run;
}

/// Rates predicted from the true states, and how well their bands hold noisy ones.
void score_rates(CaseReplication& result, const std::vector<FoundEquation>& found, const ReplicateOptions& options,
                 const Section4Record& record, std::uint64_t seed) {
  constexpr long first_sequence = 5000;  // of noise, apart from the training's
  for (const auto& [row, method, fit] : found) {
    if (method != "fast_rvm") continue;
    const auto samples = samples_where(row->where.empty() ? "1" : row->where, record.motion);
    const MatrixXd phi = columns_on(result.study, fit.relevant, record.motion)(samples, Eigen::all);
    const VectorXd predicted = phi * fit.mean, actual = record.motion.at(row->target)(samples);
    add_score(result, "one_step", seed, method, record.ratio, row->target, ident::nmse(predicted, actual));
    if (!(options.noise > 0.0)) continue;
    const auto sequence =
        static_cast<std::uint64_t>(first_sequence + 10 * std::lround(100.0 * record.ratio) + row->row);
    const auto bands =
        ident::band_fractions(predicted, ident::predictive_variance(phi, fit.covariance, fit.noise_variance),
                              noisy(actual, samples, options.noise * row->std, seed, sequence));
    result.document["bands"].push_back({{"case", result.study.definition->name},
                                        {"row", row->label()},
                                        {"seed", seed},
                                        {"ratio", record.ratio},
                                        {"within_50", bands.within_50},
                                        {"within_90", bands.within_90},
                                        {"within_95", bands.within_95}});
  }
}

}  // namespace

CaseReplication replicate_case(const Section4Case& definition, const ReplicateOptions& options,
                               const std::function<void(double)>& between) {
  const auto done = [&](double fraction) {
    if (between) between(fraction);
  };
  CaseReplication result{section4_study(definition), {}, {}};
  for (const char* list : {"fits", "free_run", "one_step", "bands"}) result.document[list] = Json::array();
  result.document["accumulate"] = {{{"case", definition.name}, {"seconds", 0.0}}};
  for (const double ratio : definition.held_out_ratios) result.runs.push_back({section4_record(definition, ratio), {}});
  for (int k = 0; k < options.num_seeds; ++k) {
    done(static_cast<double>(k) / options.num_seeds);
    const std::uint64_t seed = options.first_seed + static_cast<std::uint64_t>(k);
    const auto found = fit_seed(result, options, seed);
    for (HeldOutRun& run : result.runs) {
      auto simulated = run_identified(result, found, run.record, seed, "fast_rvm");
      score_rates(result, found, options, run.record, seed);
      if (k > 0) continue;
      run.identified = std::move(simulated);
      for (const char* method : {"slow_rvm", "sindy"}) (void)run_identified(result, found, run.record, seed, method);
    }
  }
  done(1.0);
  return result;
}

sim::Simulation free_response(const Section4Case& definition, const std::vector<ident::StateEquation>& equations,
                              const Section4Record& record) {
  constexpr double divergence_factor = 100.0;
  const sim::Experiment experiment = sim::make_experiment(definition.system, {{"ratio", record.ratio}});
  const ident::EquationFrame frame{.states = definition.variables, .inputs = {"f"}};
  const auto system = ident::system_of(std::make_shared<const ident::EquationOfMotion>(equations, frame),
                                       [forcing = experiment.system.forcing](double t, double* f) { *f = forcing(t); });
  const auto states = record.simulation.states.leftCols(definition.num_rows());
  const double rate_hz = record.motion.sample_rate_hz;
  return sim::simulate(system, experiment.initial.head(definition.num_rows()),
                       {.duration_s = static_cast<double>(states.rows() - 1) / rate_hz,
                        .sample_rate_hz = rate_hz,
                        .relative_tolerance = 1e-8,
                        .absolute_tolerance = 1e-10,
                        .divergence_bound = divergence_factor * states.cwiseAbs().maxCoeff(),
                        .poll = check_interrupted});
}

double state_error(const sim::Simulation& run, const Section4Record& record, Index state) {
  if (run.status != sim::SimulationStatus::finished) return missing;
  return ident::nmse(run.states.col(state), record.simulation.states.col(state));
}

ident::StateEquation state_equation(const Section4Study& study, const Section4Row& row, const std::vector<Index>& terms,
                                    const VectorXd& coefficients) {
  return {static_cast<std::size_t>(row.row - 1),
          names_of(study, terms),
          {coefficients.begin(), coefficients.end()},
          row.where};
}

}  // namespace apps
