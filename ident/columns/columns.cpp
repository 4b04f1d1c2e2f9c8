#include "ident/columns/columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "dsp/prepare/filtered_stretch.hpp"
#include "dsp/values/for_each_index.hpp"
#include "dsp/values/memory_limit.hpp"
#include "ident/columns/sensor_columns.hpp"
#include "ident/sensors/channel_noise.hpp"
#include "ident/switches/exact_switches.hpp"
#include "ident/switches/held_by_ground.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

Columns empty_columns(const CandidateLibrary& library, const dsp::Motion& signals, const std::string& name,
                      double band_hz, VectorXd target) {
  Columns result{.name = name, .signals = &signals, .band_hz = band_hz, .phi = {}, .target = std::move(target)};
  result.phi.resize(signals.num_samples(), static_cast<Index>(library.terms.size()));
  return result;
}

/// First sample that is not finite and may be used; -1: none. What excluded samples hold does not matter.
Index first_bad(const VectorXd& values, const dsp::Motion& motion) {
  for (Index i = 0; i < values.size(); ++i)
    if (!std::isfinite(values(i)) && (motion.excluded.empty() || motion.excluded[static_cast<std::size_t>(i)] == 0))
      return i;
  return -1;
}

/// Leaves a column out, and says why.
DroppedTerm drop(Columns& columns, Index column, const std::string& name, const dsp::Motion& motion,
                 const VectorXd& values, Index bad) {
  const std::string where =
      motion.find("t") != nullptr ? fmt::format("t = {:.9g} s", motion.at("t")(bad)) : fmt::format("row {}", bad + 1);
  columns.phi.col(column).setConstant(std::numeric_limits<double>::quiet_NaN());
  return {name, fmt::format("not finite: {} at {}", values(bad), where)};
}

/// What is left of a column that the filter takes away whole (a constant, by a high-pass) is rounding: zero.
VectorXd through_filter(const VectorXd& values, const ExactSwitches& switches) {
  constexpr double rounding = 1e-10;
  VectorXd filtered =
      dsp::filtered_within(switches.prepared(), switches.wanted(), 1,
                           [&](Index first, Index count) -> Eigen::MatrixXd { return values.segment(first, count); });
  if (filtered.cwiseAbs().maxCoeff() <= rounding * values.cwiseAbs().maxCoeff()) filtered.setZero();
  return filtered;
}

/// Keeps the means of a signal at the intermediate rate, where the column filter takes them away.
void keep_means(Columns& columns, Index signal, const VectorXd& samples) {
  if (columns.means.size == 0) return;
  columns.means.values.col(signal).setZero();
  columns.means.add(0, signal, samples);
}

void form_matched(Columns& columns, Index column, const Term& term) {
  const VectorXd samples = columns.switches->samples(term.expression);
  keep_means(columns, column, samples);
  columns.phi.col(column) = through_filter(samples, *columns.switches);
}

/// While the ground holds the payload nothing of the equation of ddy acts: ddy is zero, whatever x and v are, and so is
/// each of its terms. Formed so, what the filter carries from there into the slip is in target and columns alike.
std::shared_ptr<ExactSwitches> switches_of(const dsp::Prepared& prepared, const CandidateLibrary& library,
                                           const std::string& target) {
  auto switches = std::make_shared<ExactSwitches>(prepared, library);
  if (target == "ddy") switches->act_for(slipping_fraction(prepared));
  return switches;
}

/// A signal at the regression rate, behind the target's filter.
VectorXd signal_of(const dsp::Prepared& prepared, const dsp::Motion& accelerations, const std::string& name) {
  if (const dsp::Signal* known = accelerations.find(name)) return known->values;
  return dsp::regression_signal(prepared, name);
}

/// Why the column is of no use; none: it is.
std::optional<DroppedTerm> form_column(Columns& columns, Index column, const Term& term) {
  const dsp::Prepared& prepared = *columns.prepared;
  const bool matched = columns.switches != nullptr;
  const dsp::Motion& source = matched ? prepared.intermediate : prepared.signals;
  if (prepared.signals.find(term.name) != nullptr) {
    const bool acts = !matched || columns.switches->acting_fraction().size() == 0;
    const dsp::Signal* held = acts ? nullptr : source.find(term.name);
    columns.phi.col(column) = held == nullptr ? signal_of(prepared, *columns.accelerations, term.name)
                                              : prepared.filter.apply(columns.switches->acting(finite(held->values)));
    if (const dsp::Signal* signal = source.find(term.name)) {
      const VectorXd values = finite(signal->values);
      keep_means(columns, column, acts ? values : columns.switches->acting(values));
    }
    return std::nullopt;
  }
  VectorXd values = term.expression.evaluate(source);
  if (const Index bad = first_bad(values, source); bad >= 0)
    return drop(columns, column, term.name, source, values, bad);
  values = finite(std::move(values));  // excluded samples only; their margins cover the filter's reach
  if (!matched) {
    columns.phi.col(column) = values;
    return std::nullopt;
  }
  const bool is_zero = values.isZero(0.0);
  values.resize(0);  // its samples take as much
  form_matched(columns, column, term);
  if (columns.phi.col(column).isZero(0.0) && !is_zero)
    return DroppedTerm{term.name, "constant, and accelerometers pass no constant"};
  return std::nullopt;
}

}  // namespace

VectorXd finite(VectorXd values) {
  for (double& value : values)
    if (!std::isfinite(value)) value = 0.0;
  return values;
}

double column_bytes(const dsp::Motion& signals, std::size_t num_terms) {
  return sizeof(double) * static_cast<double>(signals.num_samples()) * static_cast<double>(num_terms);
}

Columns form_columns(const CandidateLibrary& library, const std::string& target, const dsp::Prepared& prepared,
                     const std::function<void()>& poll, int num_threads) {
  const bool matched = prepared.options.recipe == dsp::Recipe::matched;
  const dsp::Motion& source = matched ? prepared.intermediate : prepared.signals;
  const auto accelerations = std::make_shared<const dsp::Motion>(regression_accelerations(prepared));
  Columns result = empty_columns(library, prepared.signals, prepared.name, prepared.options.rolloff_hz,
                                 signal_of(prepared, *accelerations, target));
  result.prepared = &prepared;
  result.accelerations = accelerations;
  if (matched) result.switches = switches_of(prepared, library, target);
  if (matched && loses_known_means(prepared) && source.find(target) != nullptr) {
    result.means = BlockMeans(source.num_samples(), result.phi.cols() + 1, source.sample_rate_hz);
    keep_means(result, result.phi.cols(), finite(source.at(target)));
  }
  std::vector<std::optional<DroppedTerm>> dropped(library.terms.size());
  constexpr double columns_at_work = 6.0;  // at the intermediate rate: a term, its signals, its samples
  const int at_work = dsp::threads_within_memory(
      sizeof(double) * columns_at_work * static_cast<double>(source.num_samples()), num_threads);
  dsp::for_each_index(1 + library.terms.size(), at_work, [&](std::size_t i) {
    if (poll) poll();
    if (i == 0)
      result.noise = std::make_shared<const ChannelNoise>(prepared, target);
    else
      dropped[i - 1] = form_column(result, static_cast<Index>(i) - 1, library.terms[i - 1]);
  });
  for (std::optional<DroppedTerm>& one : dropped)
    if (one) result.dropped.push_back(std::move(*one));
  return result;
}

VectorXd column_beside(const Columns& columns, const std::string& term, const std::string& target) {
  return columns.beside->of(term, [&]() -> VectorXd {
    const CandidateLibrary library = make_library({.order = 0, .terms = {term}}, target, *columns.signals);
    const Term& one = library.terms.front();
    if (columns.switches == nullptr) return one.expression.evaluate(*columns.signals);
    ExactSwitches switches(*columns.prepared, library);
    switches.act_for(columns.switches->acting_fraction());
    return through_filter(switches.samples(one.expression), switches);
  });
}

void place_switches(Columns& columns, const CandidateLibrary& library, const WeightedTerms& equation,
                    const std::function<void()>& poll) {
  if (columns.switches == nullptr || !columns.switches->must_form(equation)) return;
  columns.switches->settle(equation);
  for (Index column = 0; column < columns.phi.cols(); ++column) {
    const Term& term = library.terms[static_cast<std::size_t>(column)];
    const bool dropped = std::any_of(columns.dropped.begin(), columns.dropped.end(),
                                     [&](const DroppedTerm& one) { return one.name == term.name; });
    if (dropped || columns.signals->find(term.name) != nullptr ||
        !columns.switches->depends_on_equation(term.expression))
      continue;
    if (poll) poll();
    form_matched(columns, column, term);
  }
}

Columns with_own_switches(Columns columns) {
  if (columns.switches != nullptr) columns.switches = std::make_shared<ExactSwitches>(*columns.switches);
  return columns;
}

Columns form_columns(const CandidateLibrary& library, const std::string& target, const dsp::Motion& table,
                     const std::string& name, const std::function<void()>& poll) {
  Columns result = empty_columns(library, table, name, 0.5 * table.sample_rate_hz, table.at(target));
  for (Index column = 0; column < result.phi.cols(); ++column) {
    if (poll) poll();
    const Term& term = library.terms[static_cast<std::size_t>(column)];
    const VectorXd values = term.expression.evaluate(table);
    if (const Index bad = first_bad(values, table); bad >= 0)
      result.dropped.push_back(drop(result, column, term.name, table, values, bad));
    else
      result.phi.col(column) = values;
  }
  return result;
}

}  // namespace ident
