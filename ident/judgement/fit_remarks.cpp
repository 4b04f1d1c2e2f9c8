#include "ident/judgement/fit_remarks.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <vector>

#include "ident/regression/collinearity.hpp"
#include "ident/selection/ranked_models.hpp"
#include "ident/sensors/sensor_fit.hpp"

namespace ident {

using Eigen::Index;

void name_dependent(Fit& fit, const CandidateLibrary& library) {
  const auto name = [&](Index term) { return library.terms[static_cast<std::size_t>(term)].label(); };
  for (const Dependent& dependent : fit.dependent) {
    std::vector<std::string> others;
    for (const Index term : dependent.of) others.push_back(name(term));
    fit.remarks.push_back(fmt::format("{} was left out: on the training rows it is a combination of {}",
                                      name(dependent.term), fmt::join(others, ", ")));
  }
}

void name_ties(JudgedFit& judged, const RFactor& data, const RangeData& range, const CandidateLibrary& library,
               const Poll& poll) {
  const auto name = [&](Index position) {
    return library.terms[static_cast<std::size_t>(range.terms[static_cast<std::size_t>(position)])].label();
  };
  for (const Rival& rival : rivals(data, judged.fit, judged.fit.tau, poll))
    judged.ties.emplace_back(name(rival.kept), name(rival.other));
  if (!range.sensors) return;
  for (const SensorTwin& twin : sensor_twins(range.joint, judged.fit.relevant)) {
    const std::string& sensor = range.sensors->parameters()[static_cast<std::size_t>(twin.sensor)].name;
    const auto& kept = judged.fit.relevant;
    const bool is_kept = std::find(kept.begin(), kept.end(), twin.candidate) != kept.end();
    judged.ties.emplace_back(name(twin.candidate), sensor);
    judged.fit.remarks.push_back(fmt::format(
        "{0} and the {1} have the same effect on these data and cannot be separated: {0} is {2}", name(twin.candidate),
        sensor,
        is_kept ? "more than the sensor is known to be off" : "left out and counted as an error of the sensor"));
  }
}

void name_undecided(Fit& fit, const CandidateLibrary& library) {
  if (!fit.ranking) return;
  std::vector<std::string> open;
  for (Index term = 0; term < fit.ranking->inclusion.size(); ++term)
    if (fit.ranking->is_undecided(term))
      open.push_back(fmt::format("{} (probability {:.2f})", library.terms[static_cast<std::size_t>(term)].label(),
                                 fit.ranking->inclusion(term)));
  if (!open.empty()) fit.remarks.push_back(fmt::format("undecided on these rows: {}", fmt::join(open, ", ")));
}

}  // namespace ident
