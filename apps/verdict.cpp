#include "apps/verdict.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace apps {
namespace {

constexpr double follows = 0.02, follows_in_part = 0.1;   // free-run NMSE of x
constexpr double in_step = 0.02;                          // power balance: a degree between v and a
constexpr double explained = 0.1;                         // share of the target's power that may be left over
constexpr double carries_over = 10.0, negligible = 1e-3;  // test NMSE / training NMSE, where the former matters
constexpr double matters = 0.05, same = 0.1;

std::string percent(double share) {
  return fmt::format("{:.2g} %", 100.0 * share);
}

/// About the mean: of a force about its rest the mean is most of the power and none of the news.
const Figure& error_of(const JudgedFit& fit) {
  return fit.test_centred.reason.empty() ? fit.test_centred : fit.train_centred;
}

/// Where there is no motion to be left to, the error alone has to tell.
Describes by_error(const JudgedFit& fit) {
  const Figure& error = error_of(fit);
  if (!error.reason.empty()) return Describes::unknown;
  if (error.value > explained) return Describes::no;
  return error.value <= follows && fit.whiteness.tested && fit.whiteness.white ? Describes::yes : Describes::in_part;
}

Describes by_free_run(const ident::FreeRun& run) {
  if (run.diverged_after_s > 0.0) return Describes::no;
  if (!run.reason.empty()) return Describes::unknown;
  return run.nmse <= follows ? Describes::yes : run.nmse <= follows_in_part ? Describes::in_part : Describes::no;
}

std::string free_run_clause(const ident::FreeRun& run) {
  if (run.diverged_after_s > 0.0) return "left to itself it runs away (free run " + run.reason + ")";
  if (!run.applies) return {};
  if (!run.reason.empty()) return "it was not left to itself (no free run: " + run.reason + ")";
  const char* how = run.nmse <= follows           ? "it follows x"
                    : run.nmse <= follows_in_part ? "it follows x roughly"
                                                  : "it does not follow x";
  return fmt::format("left to itself {} (free run NMSE {:.2g})", how, run.nmse);
}

std::string residual_clause(const JudgedFit& fit) {
  const Figure& error = error_of(fit);
  std::string text = error.reason.empty() ? fmt::format("step by step it leaves {} of the variation of {} unexplained",
                                                        percent(error.value), fit.model.target)
                                          : std::string("its error step by step is not known");
  if (fit.whiteness.tested) text += fit.whiteness.white ? ", as noise" : ", and that is structure";
  return text;
}

std::string power_clause(double balance) {
  if (!std::isfinite(balance)) return {};
  return std::abs(balance) <= in_step
             ? fmt::format("the sensors are in step (power check {:.1g})", std::abs(balance))
             : fmt::format("velocity and acceleration are out of step (power check {:.2g}), which reads as damping",
                           std::abs(balance));
}

/// Terms that matter in one of two equations and are not the same in the other.
std::vector<std::string> unlike(const RangeResult& a, const RangeResult& b, std::size_t method) {
  std::vector<std::string> names;
  const auto one_way = [&](const RangeResult& one, const RangeResult& other) {
    const double bar = matters * one.target.cwiseAbs().maxCoeff();
    const auto& others = other.fits[method].model.terms;
    for (const ident::ModelTerm& term : one.fits[method].model.terms) {
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

/// Ranges that share no samples are the ones whose agreement says something: mixed holds low and high.
bool apart(const RangeResult& a, const RangeResult& b) {
  return a.regime != dsp::RegimeSet::mixed() && b.regime != dsp::RegimeSet::mixed();
}

struct Agreement {
  bool other = false;  // some range has another equation
  std::string clause;
};

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
  return {false, fmt::format("{} agree{} to a tenth", fmt::join(agree, " and "), agree.size() == 1 ? "s" : "")};
}

const char* opening(Describes describes) {
  switch (describes) {
    case Describes::yes:
      return "This equation describes the record";
    case Describes::in_part:
      return "This equation describes the record in part";
    case Describes::no:
      return "This equation does not describe the record";
    case Describes::unknown:
      break;
  }
  return "Whether this equation describes the record is not known";
}

}  // namespace

std::string_view to_string(Describes describes) {
  if (describes == Describes::yes) return "yes";
  if (describes == Describes::in_part) return "in part";
  return describes == Describes::no ? "no" : "unknown";
}

Verdict verdict(const std::vector<RangeResult>& ranges, std::size_t range, std::size_t method) {
  const JudgedFit& fit = ranges[range].fits[method];
  if (fit.model.terms.empty()) return {Describes::no, "No equation was found: no candidate term earned its place."};
  Verdict result{fit.free_run.applies ? by_free_run(fit.free_run) : by_error(fit), {}};
  const Figure& error = error_of(fit);
  const bool left_over = error.reason.empty() && error.value > explained;
  const bool own_rows_only = fit.train.reason.empty() && fit.test.reason.empty() && fit.test.value > negligible &&
                             fit.test.value > carries_over * fit.train.value;
  const double balance = ranges[range].power_balance;
  const bool out_of_step = std::isfinite(balance) && std::abs(balance) > in_step;
  if (result.describes == Describes::unknown && left_over) result.describes = Describes::no;
  const Agreement others = agreement(ranges, range, method);
  if (result.describes == Describes::yes && (left_over || own_rows_only || out_of_step || others.other))
    result.describes = Describes::in_part;
  std::vector<std::string> clauses{free_run_clause(fit.free_run), residual_clause(fit), power_clause(balance),
                                   others.clause};
  if (result.describes == Describes::no && left_over && fit.whiteness.tested && !fit.whiteness.white)
    clauses.emplace_back("no equation from this library can: a term or an inner state is missing");
  std::erase_if(clauses, [](const std::string& clause) { return clause.empty(); });
  result.sentence = fmt::format("{}: {}.", opening(result.describes), fmt::join(clauses, "; "));
  return result;
}

}  // namespace apps
