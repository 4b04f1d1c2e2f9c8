#include "ident/judgement/range_agreement.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "ident/validate/energy_terms.hpp"

namespace ident {
namespace {

constexpr double matters = 0.05, same = 0.1;

/// Terms that matter in one of two equations and are not the same in the other.
std::vector<std::string> unlike(const RangeResult& a, const RangeResult& b, std::size_t method) {
  std::vector<std::string> names;
  const auto one_way = [&](const RangeResult& one, const RangeResult& other) {
    const double bar = matters * one.target.cwiseAbs().maxCoeff();
    const auto [model, other_model] = comparable(one, other, method);
    const auto& others = other_model.terms;
    for (const ModelTerm& term : model.terms) {
      if (std::abs(term.mean) * term.scale < bar) continue;
      const auto twin = std::find_if(others.begin(), others.end(), [&](const auto& t) { return t.name == term.name; });
      const bool alike = twin != others.end() && std::abs(twin->mean - term.mean) <= same * std::abs(term.mean);
      if (!alike && std::find(names.begin(), names.end(), term.name) == names.end()) names.push_back(term.name);
    }
  };
  one_way(a, b);
  one_way(b, a);
  return names;
}

/// Ranges that share no samples are the ones whose agreement says something: mixed holds low and high, all recordings
/// hold each.
bool apart(const RangeResult& a, const RangeResult& b) {
  return (a.recording == 0) == (b.recording == 0) && a.regime != dsp::RegimeSet::mixed() &&
         b.regime != dsp::RegimeSet::mixed();
}

}  // namespace

std::pair<Model, Model> comparable(const RangeResult& a, const RangeResult& b, std::size_t method) {
  const Model &one = a.fits[method].model, &other = b.fits[method].model;
  if (own_coefficients(one).size() == own_coefficients(other).size() && a.recording == b.recording) return {one, other};
  const int recording = std::max(a.recording, b.recording);
  return {equation_of(one, recording), equation_of(other, recording)};
}

Agreement agreement(const std::vector<RangeResult>& ranges, std::size_t range, std::size_t method) {
  std::vector<std::string> agree, disagree;
  for (std::size_t other = 0; other < ranges.size(); ++other) {
    if (other == range || !apart(ranges[range], ranges[other]) || ranges[other].fits[method].model.terms.empty())
      continue;
    const auto names = unlike(ranges[range], ranges[other], method);
    if (names.empty())
      agree.push_back(ranges[other].spec.name);
    else
      disagree.push_back(fmt::format("{} has another {}", ranges[other].spec.name, fmt::join(names, ", ")));
  }
  if (!disagree.empty()) return {true, fmt::format("{}", fmt::join(disagree, ", "))};
  if (agree.empty()) return {};
  return {false, fmt::format("{} agree{} within 10 %", fmt::join(agree, " and "), agree.size() == 1 ? "s" : "")};
}

std::vector<OwnCoefficients> apart_by_recording(const RangeResult& range, const Model& model) {
  std::vector<OwnCoefficients> found = own_coefficients(model);
  if (found.empty()) return found;
  const double bar = matters * range.target.cwiseAbs().maxCoeff();
  std::erase_if(found, [&](const OwnCoefficients& one) {
    const auto [least, greatest] = one.extremes();
    const double larger = std::max(std::abs(least->mean), std::abs(greatest->mean));
    return is_dry_friction(one.name) || larger * greatest->scale < bar || greatest->mean - least->mean <= same * larger;
  });
  return found;
}

}  // namespace ident
