#include "ident/validate/unexplained.hpp"

#include <algorithm>
#include <cmath>

#include "dsp/signals.hpp"
#include "ident/rows_of_terms.hpp"
#include "ident/validate/independent_rows.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Probe {
  Expression expression;
  Cause cause;
};

bool has_switch(const std::vector<std::string>& terms, const std::string& argument) {
  return std::any_of(terms.begin(), terms.end(), [&](const std::string& text) {
    const std::vector<Switch> own = Expression(text).all_switches();
    return std::any_of(own.begin(), own.end(), [&](const Switch& one) { return one.argument.text() == argument; });
  });
}

std::vector<Probe> recorded_probes(const Model& model, const std::vector<std::string>& terms,
                                   const dsp::Motion& motion) {
  std::vector<Probe> result;
  for (const dsp::SignalInfo& info : dsp::signal_table()) {
    const std::string name(info.name);
    if (!info.in_default_library || name == model.target || motion.find(name) == nullptr) continue;
    const bool used = std::any_of(model.terms.begin(), model.terms.end(), [&](const ModelTerm& term) {
      const Expression expression(term.name);
      const auto& own = expression.signals();
      return std::find(own.begin(), own.end(), name) != own.end();
    });
    // A hysteretic force is a state of the system's own.
    if (!used)
      result.push_back({Expression(name), info.role == dsp::Role::z ? Cause::missing_term : Cause::missing_input});
  }
  for (const auto& [one, other] : {std::pair("v", "dy"), std::pair("dy", "v")})
    if (motion.find(one) != nullptr && motion.find("r") != nullptr && !has_switch(terms, one) &&
        has_switch(terms, other))
      result.push_back({Expression(std::string("sgn(") + one + ")"), Cause::switch_variable});
  return result;
}

std::vector<Probe> form_probes(const std::vector<std::string>& terms, const dsp::Motion& motion) {
  std::vector<Probe> result;
  if (motion.find("x") == nullptr || motion.find("v") == nullptr) return result;
  if (!has_switch(terms, "v") && !has_switch(terms, "dy"))
    result.push_back({Expression("sgn(v)"), Cause::missing_term});
  for (const char* text : {"x", "v", "x^2", "x*v", "v^2", "x^3", "x^2*v", "x*v^2", "v^3"})
    if (std::find(terms.begin(), terms.end(), text) == terms.end())
      result.push_back({Expression(text), Cause::missing_term});
  return result;
}

/// Empty where a recording lacks one of its signals.
VectorXd on_rows(const Expression& expression, const std::vector<Row>& rows, const std::vector<Columns>& recordings) {
  VectorXd result(std::ssize(rows));
  VectorXd values;
  for (Index i = 0; i < result.size(); ++i) {
    const Row& row = rows[static_cast<std::size_t>(i)];
    if (i == 0 || row.recording != rows[static_cast<std::size_t>(i - 1)].recording) {
      const dsp::Motion& motion = *recordings[row.recording].signals;
      for (const std::string& name : expression.signals())
        if (motion.find(name) == nullptr) return {};
      values = expression.evaluate(motion);
    }
    result(i) = values(row.sample);
  }
  return result;
}

/// What the kept columns have of a series: its products with an orthonormal basis of them.
VectorXd part_in_kept(const Eigen::Ref<const VectorXd>& values, const Model& model, const RFactor& kept,
                      const std::vector<Row>& rows, const std::vector<Columns>& recordings) {
  const Index k = std::ssize(model.terms);
  std::vector<Index> columns;
  for (const ModelTerm& term : model.terms) columns.push_back(term.column);
  VectorXd products = VectorXd::Zero(k);
  RowsOfTerms(rows, recordings, columns).for_each_block([&](Index first, const MatrixXd& phi) {
    products += phi.transpose() * values.segment(first, phi.rows());
  });
  return kept.R.topLeftCorner(k, k).triangularView<Eigen::Upper>().transpose().solve(products);
}

/// A residual beside the kept columns.
struct Residual {
  const Model& model;
  const std::vector<std::string>& terms;
  const RFactor& kept;
  const std::vector<Row>& rows;
  const std::vector<Columns>& recordings;
  Eigen::Ref<const VectorXd> values;
  const IndependentRows& independence;
  const Poll& poll;
  VectorXd in_kept = part_in_kept(values, model, kept, rows, recordings);

  [[nodiscard]] std::optional<Explanation> best_of(const std::vector<Probe>& probes) const {
    constexpr double by_chance = 1e-3;  // that any of the probes explains as much of noise as independent as this
    std::optional<Explanation> best;
    for (const Probe& probe : probes) {
      if (poll) poll();
      const auto [fraction, chance] = explained_by(probe.expression);
      if (!(chance * static_cast<double>(probes.size()) < by_chance) || (best && best->fraction >= fraction)) continue;
      const std::string what = probe.expression.text();
      best = Explanation{what, probe.cause, std::min(1.0, fraction),
                         std::find(terms.begin(), terms.end(), what) != terms.end()};
    }
    return best;
  }

 private:
  struct Explained {
    double fraction = 0.0, chance = 1.0;
  };
  [[nodiscard]] Explained explained_by(const Expression& expression) const {
    constexpr double rounding = 1e-10;  // of a probe that the kept columns make up
    VectorXd probe = on_rows(expression, rows, recordings);
    if (probe.size() == 0 || !probe.allFinite()) return {};
    probe.array() -= probe.mean();
    const VectorXd probe_in_kept = part_in_kept(probe, model, kept, rows, recordings);
    const double power = probe.squaredNorm() - probe_in_kept.squaredNorm();
    if (!(power > rounding * probe.squaredNorm())) return {};
    const double product = probe.dot(values) - probe_in_kept.dot(in_kept);
    const double fraction = product * product / (power * values.squaredNorm());
    // Of noise a fraction R^2 is explained with probability (1 - R^2)^((n - 2) / 2), about.
    const double independent = static_cast<double>(values.size()) * independence.fraction_for(probe, values) - 2.0;
    return {fraction, std::pow(std::max(0.0, 1.0 - fraction), 0.5 * std::max(0.0, independent))};
  }
};

}  // namespace

Explanations explanations(const Model& model, const std::vector<std::string>& terms, const RFactor& kept,
                          const std::vector<Row>& rows, const std::vector<Columns>& recordings,
                          const Eigen::Ref<const VectorXd>& residual, const IndependentRows& independence,
                          const Poll& poll) {
  const dsp::Motion& motion = *recordings[rows.front().recording].signals;
  const std::vector<Probe> recorded = recorded_probes(model, terms, motion), forms = form_probes(terms, motion);
  if (recorded.empty() && forms.empty()) return {};
  const Residual left{model, terms, kept, rows, recordings, residual, independence, poll};
  return {left.best_of(recorded), left.best_of(forms)};
}

}  // namespace ident
