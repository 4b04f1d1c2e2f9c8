#include "ident/library/library.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <functional>

#include "dsp/values/faults.hpp"
#include "dsp/values/signals.hpp"
#include "ident/library/dimension.hpp"

namespace ident {
namespace {

std::string without_spaces(std::string_view text) {
  std::string bare(text);
  bare.erase(
      std::remove_if(bare.begin(), bare.end(), [](char c) { return std::isspace(static_cast<unsigned char>(c)); }),
      bare.end());
  return bare;
}

// All products of the variables of exactly this degree, in the order x^2, x*v, v^2.
void products_of_degree(const std::vector<std::string>& variables, int degree, std::vector<std::string>& into) {
  std::vector<int> powers(variables.size(), 0);
  const std::function<void(std::size_t, int)> extend = [&](std::size_t variable, int left) {
    if (variable + 1 == variables.size()) {
      powers[variable] = left;
      std::string name;
      for (std::size_t i = 0; i < variables.size(); ++i)
        if (powers[i] > 0)
          name += (name.empty() ? "" : "*") + variables[i] + (powers[i] > 1 ? fmt::format("^{}", powers[i]) : "");
      into.push_back(name);
      return;
    }
    for (int power = left; power >= 0; --power) {
      powers[variable] = power;
      extend(variable + 1, left - power);
    }
  };
  extend(0, degree);
}

// (order + number of variables) choose order, as a double: it may be astronomically large.
double polynomial_count(int order, std::size_t num_variables) {
  double count = 1.0;
  for (std::size_t i = 1; i <= num_variables; ++i) count *= (order + static_cast<double>(i)) / static_cast<double>(i);
  return count;
}

std::vector<std::string> term_texts(const LibraryOptions& options) {
  if (options.order < 0)
    throw dsp::Fault(dsp::FaultKind::usage, "library.order",
                     fmt::format("library.order: got {}, want 0 or more", options.order));
  const double count = (options.order > 0 ? polynomial_count(options.order, options.variables.size()) : 0.0) +
                       static_cast<double>(options.terms.size());
  if (count > options.max_terms)
    throw dsp::Fault(
        dsp::FaultKind::usage, "library.too_large",
        fmt::format("library: order {} in {} variables and {} further terms make {:.0f} terms ({:.3g} MB of factors), "
                    "at most {} are allowed. Try a lower order or fewer terms",
                    options.order, options.variables.size(), options.terms.size(), count, 8e-6 * count * count * 3.0,
                    options.max_terms));
  std::vector<std::string> texts;
  if (options.order > 0) {
    if (options.variables.empty())
      throw dsp::Fault(dsp::FaultKind::usage, "library.variables",
                       "library.variables: empty; want signals such as [\"x\", \"v\"]");
    if (options.constant) texts.emplace_back("1");
    for (int degree = 1; degree <= options.order; ++degree) products_of_degree(options.variables, degree, texts);
  }
  texts.insert(texts.end(), options.terms.begin(), options.terms.end());
  return texts;
}

/// Relative, payload's and base's motion of one order are one identity, relative = payload - base: with its other
/// members among the terms the target explains itself. Without a base the first two are the same signal; a base's
/// motion beside the relative motion alone determines nothing.
void refuse_identity(const CandidateLibrary& library, const std::string& target, const dsp::Motion& signals) {
  const dsp::SignalInfo* known = dsp::find_signal(target);
  if (known == nullptr || known->order < 0) return;
  const auto among_terms = [&](const std::string& name) {
    const Expression signal(name);
    return std::any_of(library.terms.begin(), library.terms.end(),
                       [&](const auto& term) { return term.expression.ratio_to(signal).has_value(); });
  };
  std::vector<std::string> others;
  bool of_base = known->body == dsp::Body::base;
  for (const dsp::Body body : {dsp::Body::relative, dsp::Body::payload, dsp::Body::base})
    if (const std::string name(dsp::motion_signal(body, known->order).name);
        name != target && signals.find(name) != nullptr) {
      others.push_back(name);
      of_base = of_base || body == dsp::Body::base;
    }
  if (others.size() > (of_base ? 1U : 0U) && std::all_of(others.begin(), others.end(), among_terms))
    throw dsp::Fault(
        dsp::FaultKind::usage, "library.target",
        fmt::format("library: the target {} is {} by definition and would explain itself. Remove {}.", target,
                    others.size() == 1 ? "the term " + others.front() + " here, where no base moves,"
                                       : fmt::format("made of the terms {}", fmt::join(others, " and ")),
                    others.size() == 1 ? "it" : "one of them"));
}

void refuse_known(const Term& term, const CandidateLibrary& library, const std::string& target) {
  for (const Term& known : library.terms)
    if (term.expression.ratio_to(known.expression) == 1.0)
      throw dsp::Fault(dsp::FaultKind::usage, "library.duplicate",
                       fmt::format("library: the term '{}' occurs twice{}; remove one", term.name,
                                   term.name == known.name ? "" : fmt::format(", also as '{}'", known.name)));
  const std::vector<std::string>& looked_at = term.expression.signals();
  const bool holds_target = std::find(looked_at.begin(), looked_at.end(), target) != looked_at.end();
  const bool is_target = term.expression.ratio_to(Expression(target)).has_value();
  if (holds_target || is_target)
    throw dsp::Fault(dsp::FaultKind::usage, "library.target",
                     fmt::format("library: the term '{}' {} the target '{}' and would explain it by itself; remove it",
                                 term.name, is_target ? "is" : "contains", target));
}

}  // namespace

CandidateLibrary make_library(const LibraryOptions& options, const std::string& target, const dsp::Motion& signals) {
  std::vector<std::string> names;
  for (const dsp::Signal& signal : signals.signals) names.push_back(signal.name);
  CandidateLibrary library;
  dsp::Faults faults;
  for (const std::string& as_written : term_texts(options))
    faults.attempt([&] {
      Term term{without_spaces(as_written), Expression(as_written, names), {}};
      refuse_known(term, library, target);
      term.unit = term.expression.unit(signals);
      library.terms.push_back(std::move(term));
    });
  faults.raise();
  if (library.terms.empty())
    throw dsp::Fault(dsp::FaultKind::usage, "library.empty",
                     "library: no terms; give an order above 0 or a list of terms");
  return library;
}

CandidateLibrary record_library(const LibraryOptions& options, const std::string& target,
                                const dsp::Prepared& prepared) {
  const dsp::Motion& signals = prepared.signals;
  dsp::Faults faults;
  if (signals.find(target) == nullptr) {
    std::string known;
    for (const dsp::Signal& signal : signals.signals) known += (known.empty() ? "" : ", ") + signal.name;
    faults.add(dsp::Fault(dsp::FaultKind::usage, "target.unknown",
                          fmt::format("target: {} has no signal '{}', want one of {}.", prepared.name, target, known)));
  }
  CandidateLibrary library;
  faults.attempt([&] { library = make_library(options, target, signals); });
  faults.raise();
  refuse_identity(library, target, signals);
  return library;
}

std::string coefficient_unit(const std::string& target_unit, const std::string& term_unit) {
  if (target_unit.empty() || term_unit.empty()) return {};
  const auto target = Dimension::of_unit(target_unit), term = Dimension::of_unit(term_unit);
  const auto quotient = target && term ? target->times(*term, -1.0) : std::nullopt;
  return quotient ? quotient->unit() : std::string();
}

Eigen::VectorXd degrees(const CandidateLibrary& library, const std::vector<Eigen::Index>& terms) {
  Eigen::VectorXd result(std::ssize(terms));
  for (Eigen::Index i = 0; i < result.size(); ++i) {
    const Term& term = library.terms[static_cast<std::size_t>(terms[static_cast<std::size_t>(i)])];
    result(i) = term.name == "1" ? 0.0 : std::max(1.0, term.expression.band_factor());
  }
  return result;
}

}  // namespace ident
