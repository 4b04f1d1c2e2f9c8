#include "apps/paper/section4.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "apps/process/interrupt.hpp"
#include "dsp/fault.hpp"
#include "ident/library/expression.hpp"
#include "ident/regression/posterior.hpp"
#include "sim/noise.hpp"

namespace apps {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double duration_s = 25.0, sample_rate_hz = 100.0;

std::vector<Section4Case> make_cases() {
  const std::vector<double> seven{0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3}, five{0.8, 0.9, 1.0, 1.1, 1.2};
  const std::vector<double> beside{0.65, 1.05, 1.25, 1.4};
  const std::vector<std::string> two{"x", "v"}, three{"x", "v", "z"};
  return {
      {"duffing", "duffing", 1, 2, seven, {0.6, 0.85, 1.25, 1.4}, 2, two, 3, {"f"}},
      {"coulomb", "coulomb", 2, 3, seven, beside, 2, two, 2, {"sgn(v)", "f"}},
      {"bouc-wen", "bouc-wen", 3, 4, five, {0.7, 0.75, 1.3}, 3, three, 2, {"z*abs(v)", "abs(z)*v", "f"}},
      {"bouc-wen-2",
       "bouc-wen",
       4,
       5,
       five,
       {0.75, 1.25, 1.3},
       2,
       two,
       2,
       {"abs(x)", "abs(v)", "x*abs(v)", "abs(x)*v", "abs(x)*abs(v)", "f"}},
      {"valanis-1", "valanis-1", 5, 6, seven, beside, 3, three, 2, {"abs(v)*x", "abs(v)*z", "f"}},
      {"valanis-2", "valanis-2", 6, 7, seven, beside, 3, three, 2, {"abs(v)*x", "abs(v)*z", "x^2*v^2", "f"}},
      {"valanis-3", "valanis-3", 7, 8, seven, beside, 3, three, 2, {"abs(v)*x", "abs(v)*z", "exp(x)*v*abs(v)", "f"}},
      {"valanis-4", "valanis-4", 8, 9, seven, beside, 3, three, 2, {"v*sin(x)", "f"}, {"v >= 0", "v < 0"}},
  };
}

dsp::Motion motion_of(const sim::Experiment& experiment, const sim::Simulation& simulation) {
  dsp::Motion motion;
  motion.sample_rate_hz = sample_rate_hz;
  const char *state_units[] = {"m", "m/s", "N"}, *rates[] = {"dx", "a", "dz"}, *rate_units[] = {"m/s", "m/s^2", "N/s"};
  motion.signals.push_back({"t", "s", simulation.time_s});
  for (Index j = 0; j < simulation.states.cols(); ++j)
    motion.signals.push_back({experiment.system.states[j], state_units[j], simulation.states.col(j)});
  motion.signals.push_back({"f", "1", simulation.time_s.unaryExpr(experiment.system.forcing)});
  for (Index j = 0; j < simulation.states.cols(); ++j)
    motion.signals.push_back({rates[j], rate_units[j], simulation.derivatives.col(j)});
  motion.excluded.assign(static_cast<std::size_t>(simulation.time_s.size()), 0);
  return motion;
}

void append(dsp::Motion& whole, const dsp::Motion& record) {
  if (whole.signals.empty()) {
    whole = record;
    return;
  }
  for (std::size_t i = 0; i < whole.signals.size(); ++i) {
    VectorXd& values = whole.signals[i].values;
    const Index before = values.size();
    values.conservativeResize(before + record.num_samples());
    values.tail(record.num_samples()) = record.signals[i].values;
  }
  whole.excluded.insert(whole.excluded.end(), record.excluded.begin(), record.excluded.end());
}

double std_of(const VectorXd& values) {
  return std::sqrt((values.array() - values.mean()).square().mean());
}

Section4Regression regression_on(std::vector<Index> samples, const MatrixXd& columns) {
  Section4Regression regression;
  regression.phi = columns(samples, Eigen::all);
  regression.samples = std::move(samples);
  return regression;
}

void add_row(Section4Regression& regression, const Section4Study& study, const std::vector<sim::TrueTerm>& truth,
             int row, std::string where) {
  static constexpr const char* targets[] = {"dx", "a", "dz"};
  Section4Row added{row, targets[row - 1], std::move(where), {}, 0.0, false, {}};
  const VectorXd& whole = study.training.at(added.target);
  added.std = std_of(whole);
  added.values = whole(regression.samples);
  added.truth = VectorXd::Zero(regression.phi.cols());
  added.truth_known = row != 2 || study.definition->name != "bouc-wen-2";
  for (const sim::TrueTerm& term : truth) {
    if (term.row != row || term.where != added.where || !added.truth_known) continue;
    const auto& terms = study.library.terms;
    const auto found = std::find_if(terms.begin(), terms.end(),
                                    [&](const ident::Term& candidate) { return candidate.name == term.name; });
    if (found == terms.end())
      throw std::logic_error("section4: " + study.definition->name + " lacks the true term " + term.name);
    added.truth(found - terms.begin()) = term.value;
  }
  regression.rows.push_back(std::move(added));
}

}  // namespace

const std::vector<Section4Case>& section4_cases() {
  static const std::vector<Section4Case> cases = make_cases();
  return cases;
}

const Section4Case* find_section4_case(std::string_view name) {
  for (const Section4Case& known : section4_cases())
    if (known.name == name) return &known;
  return nullptr;
}

std::string Section4Row::label() const {
  return where.empty() ? fmt::format("{}", row) : fmt::format("{} ({})", row, where);
}

Section4Record section4_record(const Section4Case& definition, double ratio) {
  const sim::Experiment experiment = sim::make_experiment(definition.system, {{"ratio", ratio}});
  Section4Record record{
      ratio,
      sim::simulate(experiment.system, experiment.initial,
                    {.duration_s = duration_s, .sample_rate_hz = sample_rate_hz, .poll = check_interrupted}),
      {}};
  if (record.simulation.status != sim::SimulationStatus::finished)
    throw dsp::Fault(dsp::FaultKind::numerics, "replicate.simulation", record.simulation.reason);
  record.motion = motion_of(experiment, record.simulation);
  return record;
}

Section4Study section4_study(const Section4Case& definition) {
  Section4Study study;
  study.definition = &definition;
  for (const double ratio : definition.training_ratios)
    append(study.training, section4_record(definition, ratio).motion);
  study.library = ident::make_library(
      {.order = definition.order, .variables = definition.variables, .terms = definition.further_terms}, "a",
      study.training);
  const Index num_samples = study.training.num_samples();
  MatrixXd columns(num_samples, static_cast<Index>(study.library.terms.size()));
  for (std::size_t j = 0; j < study.library.terms.size(); ++j)
    columns.col(static_cast<Index>(j)) = study.library.terms[j].expression.evaluate(study.training);

  const auto truth = sim::make_experiment(definition.system).truth;
  std::vector<Index> all(static_cast<std::size_t>(num_samples));
  std::iota(all.begin(), all.end(), Index{0});
  study.regressions.push_back(regression_on(all, columns));
  const bool splits = !definition.third_row_where.empty();
  for (int row = 1; row <= definition.num_rows - (splits ? 1 : 0); ++row)
    add_row(study.regressions.front(), study, truth, row, "");

  std::vector<std::string> names;
  for (const dsp::Signal& signal : study.training.signals) names.push_back(signal.name);
  for (const std::string& where : definition.third_row_where) {
    const auto holds = ident::rows_where(ident::Expression(where, names), study.training);
    std::vector<Index> samples;
    std::copy_if(all.begin(), all.end(), std::back_inserter(samples),
                 [&](Index i) { return holds[static_cast<std::size_t>(i)] != 0; });
    study.regressions.push_back(regression_on(std::move(samples), columns));
    add_row(study.regressions.back(), study, truth, definition.num_rows, where);
  }
  return study;
}

ident::RFactor section4_factor(const Section4Study& study, const Section4Regression& regression, double noise,
                               std::uint64_t seed) {
  const auto case_index = static_cast<std::uint64_t>(study.definition - section4_cases().data());
  MatrixXd targets(regression.phi.rows(), static_cast<Index>(regression.rows.size()));
  for (std::size_t j = 0; j < regression.rows.size(); ++j) {
    const Section4Row& row = regression.rows[j];
    const sim::Noise draw(seed, 1000 + 10 * case_index + static_cast<std::uint64_t>(row.row));
    for (Index i = 0; i < targets.rows(); ++i)
      targets(i, static_cast<Index>(j)) =
          row.values(i) +
          noise * row.std * draw.normal(static_cast<std::uint64_t>(regression.samples[static_cast<std::size_t>(i)]));
  }
  ident::RFactor data = ident::r_factor(regression.phi, targets);
  data.degree = ident::degrees(study.library, ident::all_columns(data.num_terms));
  return data;
}

ident::RFactor row_factor(const ident::RFactor& data, std::size_t row) {
  std::vector<Index> all(static_cast<std::size_t>(data.num_terms));
  std::iota(all.begin(), all.end(), Index{0});
  return ident::select(data, all, static_cast<Index>(row));
}

SupportError support_error(const ident::Fit& fit, const VectorXd& truth) {
  SupportError error;
  for (Index i = 0; i < truth.size(); ++i) {
    const bool kept = std::binary_search(fit.relevant.begin(), fit.relevant.end(), i);
    if (kept && truth(i) == 0.0) error.false_terms.push_back(i);
    if (!kept && truth(i) != 0.0) error.missing_terms.push_back(i);
  }
  return error;
}

MatrixXd unit_root(const Section4Regression& regression, const std::vector<Index>& terms) {
  const auto unit =
      ident::unit_problem(ident::r_factor(regression.phi(Eigen::all, terms), regression.rows.front().values));
  std::vector<Index> all(terms.size());
  std::iota(all.begin(), all.end(), Index{0});
  const auto at = ident::posterior(unit, all, VectorXd::Constant(static_cast<Index>(all.size()), ident::flat_lambda));
  return unit.column_norm.cwiseInverse().asDiagonal() * at.root;
}

VectorXd unit_stds(const Section4Regression& regression, const std::vector<Index>& terms) {
  return unit_root(regression, terms).rowwise().norm();
}

std::vector<WeakTerm> weak_terms(const Section4Study& study, double noise, double tau) {
  constexpr double weak = 5.0, largest_q = 40.0, step = 0.05;
  const auto normal = [](double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); };
  const auto passes = [&](double t, double q) { return normal(t - std::sqrt(q)) + normal(-t - std::sqrt(q)); };
  std::vector<WeakTerm> found;
  for (const Section4Regression& regression : study.regressions)
    for (const Section4Row& row : regression.rows) {
      if (!row.truth_known || !(noise > 0.0)) continue;
      std::vector<Index> kept;
      for (Index i = 0; i < row.truth.size(); ++i)
        if (row.truth(i) != 0.0) kept.push_back(i);
      const VectorXd stds = unit_stds(regression, kept) * noise * row.std;
      const auto num_false = static_cast<double>(row.truth.size() - static_cast<Index>(kept.size()));
      for (std::size_t j = 0; j < kept.size(); ++j) {
        const double t = std::abs(row.truth(kept[j])) / stds(static_cast<Index>(j));
        if (t >= weak) continue;
        WeakTerm term{row.label(), study.library.terms[static_cast<std::size_t>(kept[j])].name, t, 0.0, 0.0};
        for (double q = 1.0; q <= largest_q; q += step) {
          if (ident::evidence_gain(q) <= tau) term.kept_fraction = passes(t, q);
          term.best_exact_fraction =
              std::max(term.best_exact_fraction, passes(t, q) * std::pow(1.0 - passes(0.0, q), num_false));
        }
        found.push_back(std::move(term));
      }
    }
  return found;
}

}  // namespace apps
