#include "ident/regression/fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "ident/regression/finish_fit.hpp"

namespace ident {
namespace {

template <class Enum, std::size_t n>
std::string_view name_of(const std::array<std::pair<Enum, std::string_view>, n>& names, Enum value) {
  return std::find_if(names.begin(), names.end(), [&](const auto& row) { return row.first == value; })->second;
}

constexpr std::array<std::pair<Selection, std::string_view>, 3> selection_names{
    {{Selection::evidence, "evidence"}, {Selection::evidence_white, "evidence-white"}, {Selection::type2, "type2"}}};
constexpr std::array<std::pair<FitStatus, std::string_view>, 6> status_names{
    {{FitStatus::converged, "converged"},
     {FitStatus::iteration_limit, "iteration_limit"},
     {FitStatus::no_relevant_term, "no_relevant_term"},
     {FitStatus::rank_deficient, "rank_deficient"},
     {FitStatus::too_few_rows, "too_few_rows"},
     {FitStatus::zero_target, "zero_target"}}};
constexpr std::array<std::pair<FitAction, std::string_view>, 5> action_names{{{FitAction::start, "start"},
                                                                              {FitAction::add, "add"},
                                                                              {FitAction::reestimate, "reestimate"},
                                                                              {FitAction::remove, "remove"},
                                                                              {FitAction::exchange, "exchange"}}};

}  // namespace

std::string_view to_string(Selection selection) {
  return name_of(selection_names, selection);
}
std::string_view to_string(FitStatus status) {
  return name_of(status_names, status);
}
std::string_view to_string(FitAction action) {
  return name_of(action_names, action);
}

double ModelRanking::odds() const {
  return best.size() > 1 ? best[0].probability / best[1].probability : std::numeric_limits<double>::infinity();
}

bool ModelRanking::is_undecided(Eigen::Index term) const {
  constexpr double sure = 0.8;
  return inclusion(term) > 1.0 - sure && inclusion(term) < sure;
}

double Fit::inclusion_probability(Eigen::Index term) const {
  if (ranking && std::isfinite(ranking->inclusion(term))) return ranking->inclusion(term);
  return evidence_gain.size() > term ? probability_of(evidence_gain(term), tau)
                                     : std::numeric_limits<double>::quiet_NaN();
}

void renumber(Fit& fit, const std::vector<Eigen::Index>& terms, Eigen::Index num_terms) {
  const auto move = [&](Eigen::Index& term) {
    if (term >= 0) term = terms[static_cast<std::size_t>(term)];
  };
  const auto old_gain = std::move(fit.evidence_gain);
  fit.evidence_gain = Eigen::VectorXd::Constant(num_terms, std::numeric_limits<double>::quiet_NaN());
  for (Eigen::Index i = 0; i < old_gain.size(); ++i)
    fit.evidence_gain(terms[static_cast<std::size_t>(i)]) = old_gain(i);
  for (Eigen::Index& term : fit.relevant) move(term);
  for (FitStep& step : fit.steps) {
    move(step.term);
    move(step.leaving);
    for (Eigen::Index& term : step.terms) move(term);
  }
  if (fit.ranking) {
    const auto old_inclusion = std::move(fit.ranking->inclusion);
    fit.ranking->inclusion = Eigen::VectorXd::Constant(num_terms, std::numeric_limits<double>::quiet_NaN());
    for (Eigen::Index i = 0; i < old_inclusion.size(); ++i)
      fit.ranking->inclusion(terms[static_cast<std::size_t>(i)]) = old_inclusion(i);
    for (RankedModel& model : fit.ranking->best)
      for (Eigen::Index& term : model.terms) move(term);
  }
  for (Dependent& dependent : fit.dependent) {
    move(dependent.term);
    for (Eigen::Index& term : dependent.of) move(term);
  }
}

}  // namespace ident
