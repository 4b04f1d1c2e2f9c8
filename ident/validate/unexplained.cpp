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

std::vector<Probe> probes(const Model& model, const std::vector<std::string>& terms, const dsp::Motion& motion) {
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

}  // namespace

std::optional<Explanation> explanation(const Model& model, const std::vector<std::string>& terms, const RFactor& kept,
                                       const std::vector<Row>& rows, const std::vector<Columns>& recordings,
                                       const Eigen::Ref<const VectorXd>& residual, const IndependentRows& independence,
                                       const Poll& poll) {
  std::optional<Explanation> best;
  const auto n = static_cast<double>(residual.size());
  constexpr double rounding = 1e-10;  // of a probe that the kept columns make up
  constexpr double by_chance = 1e-3;  // that any of the probes explains as much of noise as independent as the residual
  const std::vector<Probe> tried = probes(model, terms, *recordings[rows.front().recording].signals);
  if (tried.empty()) return best;
  const VectorXd of_residual = part_in_kept(residual, model, kept, rows, recordings);
  for (const Probe& probe : tried) {
    if (poll) poll();
    VectorXd values = on_rows(probe.expression, rows, recordings);
    if (values.size() == 0 || !values.allFinite()) continue;
    values.array() -= values.mean();
    const VectorXd of_probe = part_in_kept(values, model, kept, rows, recordings);
    const double power = values.squaredNorm() - of_probe.squaredNorm();
    if (!(power > rounding * values.squaredNorm())) continue;
    const double product = values.dot(residual) - of_probe.dot(of_residual);
    const double fraction = product * product / (power * residual.squaredNorm());
    // Of noise a fraction R^2 is explained with probability (1 - R^2)^((n - 2) / 2), about.
    const double independent = n * independence.fraction_for(values, residual) - 2.0;
    const double chance = std::pow(std::max(0.0, 1.0 - fraction), 0.5 * std::max(0.0, independent));
    if (!(chance * static_cast<double>(tried.size()) < by_chance) || (best && best->fraction >= fraction)) continue;
    best = Explanation{probe.expression.text(), probe.cause, std::min(1.0, fraction)};
  }
  return best;
}

}  // namespace ident
