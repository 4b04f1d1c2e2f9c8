#include "apps/paper/section4.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "apps/paper/paper_data.hpp"
#include "apps/process/interrupt.hpp"
#include "dsp/values/fault.hpp"
#include "ident/library/expression.hpp"
#include "ident/regression/posterior.hpp"
#include "sim/noise.hpp"

namespace apps {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

std::vector<Section4Case> read_cases() {
  const auto whole = [](double number) { return static_cast<int>(number); };
  std::vector<Section4Case> cases;
  for (const dsp::Settings& one : paper_cases().tables("case")) {
    const dsp::Settings otherwise = one.table("otherwise");
    cases.push_back({one.text("name").value(), one.text("system").value(), whole(one.number("table").value()),
                     whole(one.number("figure").value()), one.numbers("trained"), one.numbers("held_out"),
                     words_in(one, "states"), whole(one.number("order").value()), words_in(one, "terms"),
                     words_in(one, "split"), whole(one.number("no_truth").value_or(0.0)), words_in(one, "figure_x"),
                     words_in(one, "figure_y"), otherwise.number("without_ratio").value_or(0.0),
                     words_in(otherwise, "beside"), otherwise.text("origin").value_or(""),
                     one.text("inner").value_or("")});
  }
  return cases;
}

std::vector<Index> all_of(Index count) {
  std::vector<Index> all(static_cast<std::size_t>(count));
  std::iota(all.begin(), all.end(), Index{0});
  return all;
}

void append(dsp::Motion& whole, const dsp::Motion& record) {
  if (whole.signals.empty()) {
    whole = record;
    return;
  }
  for (std::size_t i = 0; i < whole.signals.size(); ++i) {
    VectorXd& values = whole.signals[i].values;
    values.conservativeResize(values.size() + record.num_samples());
    values.tail(record.num_samples()) = record.signals[i].values;
  }
  whole.excluded.insert(whole.excluded.end(), record.excluded.begin(), record.excluded.end());
}

double std_of(const VectorXd& values) {
  return std::sqrt((values.array() - values.mean()).square().mean());
}

Section4Row row_of(const Section4Study& study, const Section4Regression& regression, int row, std::string where) {
  static constexpr const char* targets[] = {"dx", "a", "dz"};
  const VectorXd& whole = study.training.at(targets[row - 1]);
  Section4Row added{row,
                    targets[row - 1],
                    std::move(where),
                    whole(regression.samples),
                    std_of(whole),
                    row != study.definition->row_without_truth,
                    VectorXd::Zero(regression.phi.cols())};
  for (const sim::TrueTerm& term : sim::make_experiment(study.definition->system).truth) {
    if (term.row != row || term.where != added.where || !added.truth_known) continue;
    const Index column = column_of(study, term.name);
    if (column == added.truth.size())
      throw std::logic_error("section4: " + study.definition->name + " lacks the true term " + term.name);
    added.truth(column) = term.value;
  }
  return added;
}

}  // namespace

const std::vector<Section4Case>& section4_cases() {
  static const std::vector<Section4Case> cases = read_cases();
  return cases;
}

const Section4Case* find_section4_case(std::string_view name) {
  for (const Section4Case& known : section4_cases())
    if (known.name == name) return &known;
  return nullptr;
}

double stated_noise() {
  return paper_cases().number("noise").value();
}

std::string Section4Row::label() const {
  return where.empty() ? fmt::format("{}", row) : fmt::format("{} ({})", row, where);
}

Section4Record section4_record(const Section4Case& definition, double ratio) {
  const sim::Experiment experiment = sim::make_experiment(definition.system, {{"ratio", ratio}});
  const double rate_hz = paper_cases().number("rate_hz").value(),
               duration_s = paper_cases().number("duration_s").value();
  Section4Record record{ratio,
                        sim::simulate(experiment.system, experiment.initial,
                                      {.duration_s = duration_s, .sample_rate_hz = rate_hz, .poll = check_interrupted}),
                        {.sample_rate_hz = rate_hz}};
  const sim::Simulation& run = record.simulation;
  if (run.status != sim::SimulationStatus::finished)
    throw dsp::Fault(dsp::FaultKind::numerics, "replicate.simulation", run.reason);
  const char *state_units[] = {"m", "m/s", "N"}, *rates[] = {"dx", "a", "dz"}, *rate_units[] = {"m/s", "m/s^2", "N/s"};
  record.motion.signals = {{"t", "s", run.time_s}, {"f", "1", run.time_s.unaryExpr(experiment.system.forcing)}};
  for (Index j = 0; j < run.states.cols(); ++j) {
    record.motion.signals.push_back({experiment.system.states[j], state_units[j], run.states.col(j)});
    record.motion.signals.push_back({rates[j], rate_units[j], run.derivatives.col(j)});
  }
  record.motion.excluded.assign(static_cast<std::size_t>(run.time_s.size()), 0);
  return record;
}

Section4Study section4_study(const Section4Case& definition) {
  Section4Study study{&definition, {}, {}, {}};
  for (const double ratio : definition.training_ratios)
    append(study.training, section4_record(definition, ratio).motion);
  study.library = ident::make_library(
      {.order = definition.order, .variables = definition.variables, .terms = definition.further_terms}, "a",
      study.training);
  const auto all = all_of(study.training.num_samples());
  const MatrixXd columns = columns_on(study, all_of(std::ssize(study.library.terms)), study.training);

  study.regressions.push_back({columns, all, {}});
  const bool splits = !definition.last_row_where.empty();
  for (int row = 1; row <= definition.num_rows() - (splits ? 1 : 0); ++row)
    study.regressions.front().rows.push_back(row_of(study, study.regressions.front(), row, ""));
  for (const std::string& where : definition.last_row_where) {
    const auto samples = samples_where(where, study.training);
    Section4Regression apart{columns(samples, Eigen::all), samples, {}};
    apart.rows.push_back(row_of(study, apart, definition.num_rows(), where));
    study.regressions.push_back(std::move(apart));
  }
  return study;
}

std::vector<Index> samples_where(const std::string& condition, const dsp::Motion& motion) {
  std::vector<std::string> names;
  for (const dsp::Signal& signal : motion.signals) names.push_back(signal.name);
  const auto holds = ident::rows_where(ident::Expression(condition, names), motion);
  auto samples = all_of(motion.num_samples());
  std::erase_if(samples, [&](Index i) { return holds[static_cast<std::size_t>(i)] == 0; });
  return samples;
}

MatrixXd columns_on(const Section4Study& study, const std::vector<Index>& terms, const dsp::Motion& motion) {
  MatrixXd phi(motion.num_samples(), std::ssize(terms));
  for (Index k = 0; k < phi.cols(); ++k) {
    const Index term = terms[static_cast<std::size_t>(k)];
    phi.col(k) = study.library.terms[static_cast<std::size_t>(term)].expression.evaluate(motion);
  }
  return phi;
}

VectorXd noisy(const VectorXd& values, const std::vector<Index>& samples, double noise_std, std::uint64_t seed,
               std::uint64_t sequence) {
  const sim::Noise draw(seed, sequence);
  VectorXd result = values;
  for (Index i = 0; i < result.size(); ++i)
    result(i) += noise_std * draw.normal(static_cast<std::uint64_t>(samples[static_cast<std::size_t>(i)]));
  return result;
}

ident::RFactor section4_factor(const Section4Study& study, const Section4Regression& regression, double noise,
                               std::uint64_t seed) {
  const auto case_index = static_cast<std::uint64_t>(study.definition - section4_cases().data());
  MatrixXd targets(regression.phi.rows(), std::ssize(regression.rows));
  for (Index j = 0; j < targets.cols(); ++j) {
    const Section4Row& row = regression.rows[static_cast<std::size_t>(j)];
    const std::uint64_t sequence = 1000 + 10 * case_index + static_cast<std::uint64_t>(row.row);
    targets.col(j) = noisy(row.values, regression.samples, noise * row.std, seed, sequence);
  }
  ident::RFactor data = ident::r_factor(regression.phi, targets);
  data.degree = ident::degrees(study.library, ident::all_columns(data.num_terms));
  return data;
}

ident::RFactor row_factor(const ident::RFactor& data, std::size_t row) {
  return ident::select(data, all_of(data.num_terms), static_cast<Index>(row));
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
  const auto at =
      ident::posterior(unit, all_of(std::ssize(terms)), VectorXd::Constant(std::ssize(terms), ident::flat_lambda));
  return unit.column_norm.cwiseInverse().asDiagonal() * at.root;
}

Index column_of(const Section4Study& study, std::string_view term) {
  const auto& terms = study.library.terms;
  return std::find_if(terms.begin(), terms.end(), [&](const auto& known) { return known.name == term; }) -
         terms.begin();
}

std::vector<std::string> names_of(const Section4Study& study, const std::vector<Index>& terms) {
  std::vector<std::string> names;
  for (const Index term : terms) names.push_back(study.library.terms[static_cast<std::size_t>(term)].name);
  return names;
}

std::vector<WeakTerm> weak_terms(const Section4Study& study, double noise, double tau) {
  constexpr double weak = 5.0, largest_q = 40.0, step = 0.05;
  const auto normal = [](double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); };
  const auto passes = [&](double t, double q) { return normal(t - std::sqrt(q)) + normal(-t - std::sqrt(q)); };
  std::vector<WeakTerm> found;
  for (const Section4Regression& regression : study.regressions)
    for (const Section4Row& row : regression.rows) {
      if (!row.truth_known || !(noise > 0.0)) continue;
      std::vector<Index> kept = all_of(row.truth.size());
      std::erase_if(kept, [&](Index i) { return row.truth(i) == 0.0; });
      const VectorXd stds = unit_root(regression, kept).rowwise().norm() * noise * row.std;
      const auto num_false = static_cast<double>(row.truth.size() - std::ssize(kept));
      for (std::size_t j = 0; j < kept.size(); ++j) {
        const double t = std::abs(row.truth(kept[j])) / stds(static_cast<Index>(j));
        if (t >= weak) continue;
        WeakTerm term{row.label(), names_of(study, {kept[j]}).front(), t, 0.0, 0.0};
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
