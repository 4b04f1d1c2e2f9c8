#include "ident/candidate_library.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <functional>
#include <map>
#include <optional>

namespace ident {
namespace {

using Dimension = std::map<std::string, int>;  // base unit -> exponent; zero exponents left out

void multiply(Dimension& into, const Dimension& factor, int power) {
  for (const auto& [base, exponent] : factor)
    if ((into[base] += power * exponent) == 0) into.erase(base);
}

// "m/s^2", "1/(m*s)", "N": products and quotients of names with whole powers.
Dimension dimension_of(std::string_view unit) {
  Dimension dimension;
  int sign = 1;
  bool in_brackets = false;
  for (std::size_t i = 0; i < unit.size();) {
    const char c = unit[i];
    if (std::isalpha(static_cast<unsigned char>(c))) {
      std::size_t end = i;
      while (end < unit.size() && std::isalpha(static_cast<unsigned char>(unit[end]))) ++end;
      const std::string base(unit.substr(i, end - i));
      int power = 1;
      if (end < unit.size() && unit[end] == '^')
        end = std::from_chars(&unit[end + 1], unit.data() + unit.size(), power).ptr - unit.data();
      if (base != "rad") multiply(dimension, {{base, 1}}, sign * power);
      if (!in_brackets) sign = 1;
      i = end;
      continue;
    }
    if (c == '/') sign = -1;
    if (c == '(') in_brackets = true;
    if (c == ')') in_brackets = false, sign = 1;
    ++i;
  }
  return dimension;
}

std::string text_of(const Dimension& dimension) {
  std::string above, below;
  int num_below = 0;
  for (const auto& [base, exponent] : dimension) {
    std::string& side = exponent > 0 ? above : below;
    num_below += exponent < 0;
    side += (side.empty() ? "" : "*") + base + (std::abs(exponent) > 1 ? fmt::format("^{}", std::abs(exponent)) : "");
  }
  if (below.empty()) return above.empty() ? "1" : above;
  return (above.empty() ? "1" : above) + "/" + (num_below > 1 ? "(" + below + ")" : below);
}

// Unit of a product of signals, their whole powers, abs() of one, sgn() and plain numbers; empty for anything else.
std::optional<Dimension> product_dimension(std::string_view text, const dsp::Motion& signals) {
  Dimension dimension;
  int sign = 1;
  for (std::size_t i = 0; i < text.size();) {
    std::size_t end = i;
    for (int depth = 0; end < text.size() && (depth > 0 || (text[end] != '*' && text[end] != '/')); ++end)
      depth += text[end] == '(' ? 1 : text[end] == ')' ? -1 : 0;
    std::string_view factor = text.substr(i, end - i);
    int power = 1;
    if (const auto caret = factor.rfind('^'); caret != std::string_view::npos) {
      const auto [rest, error] = std::from_chars(factor.data() + caret + 1, factor.data() + factor.size(), power);
      if (error != std::errc() || rest != factor.data() + factor.size()) return std::nullopt;
      factor = factor.substr(0, caret);
    }
    if (factor.starts_with("abs(") && factor.ends_with(")")) factor = factor.substr(4, factor.size() - 5);
    double number = 0.0;
    const bool is_number =
        std::from_chars(factor.data(), factor.data() + factor.size(), number).ptr == factor.data() + factor.size();
    const bool is_sign = factor.starts_with("sgn(") && factor.find(')') == factor.size() - 1;
    if (!is_number && !is_sign) {
      const dsp::Signal* signal = signals.find(factor);
      if (signal == nullptr || signal->unit.empty()) return std::nullopt;
      multiply(dimension, dimension_of(signal->unit), sign * power);
    }
    if (end < text.size()) sign = text[end] == '/' ? -1 : 1;
    i = end + 1;
  }
  return dimension;
}

/// Whether the term is the target times a constant, however it is written: their ratio is one number at all points.
bool is_target(const Expression& term, const std::string& target) {
  const auto& signals = term.signals();
  const auto place = std::find(signals.begin(), signals.end(), target);
  if (place == signals.end()) return false;
  constexpr int num_points = 8;
  constexpr double rounding = 1e-12;  // of a few dozen operations
  std::vector<double> values(signals.size());
  double ratio = 0.0;
  for (int point = 0; point < num_points; ++point) {
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = (point % 2 == 0 ? 1.0 : -1.0) * (1.5 + std::sin(7.0 * point + 3.0 * static_cast<double>(i)));
    const std::vector<double> signs(term.switches().size(), point % 2 == 0 ? 1.0 : -1.0);
    const double here =
        term.evaluate(values.data(), signs.data()) / values[static_cast<std::size_t>(place - signals.begin())];
    if (point == 0) ratio = here;
    if (!(std::abs(here - ratio) <= rounding * std::abs(ratio)) || here == 0.0) return false;
  }
  return true;
}

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
  const std::function<void(std::size_t, int)> place = [&](std::size_t variable, int left) {
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
      place(variable + 1, left - power);
    }
  };
  place(0, degree);
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

}  // namespace

CandidateLibrary make_library(const LibraryOptions& options, const std::string& target, const dsp::Motion& signals) {
  std::vector<std::string> names;
  for (const dsp::Signal& signal : signals.signals) names.push_back(signal.name);
  CandidateLibrary library;
  std::vector<std::string> seen;
  for (const std::string& as_written : term_texts(options)) {
    const std::string text = without_spaces(as_written);
    if (std::find(seen.begin(), seen.end(), text) != seen.end())
      throw dsp::Fault(dsp::FaultKind::usage, "library.duplicate",
                       "library: the term '" + text + "' stands twice; remove one");
    seen.push_back(text);
    Term term{text, Expression(as_written, names), {}};
    if (is_target(term.expression, target))
      throw dsp::Fault(
          dsp::FaultKind::usage, "library.target",
          "library: the term '" + text + "' is the target '" + target + "' and would explain it by itself; remove it");
    if (const auto dimension = product_dimension(text, signals)) term.unit = text_of(*dimension);
    library.terms.push_back(std::move(term));
  }
  if (library.terms.empty())
    throw dsp::Fault(dsp::FaultKind::usage, "library.empty",
                     "library: no terms; give an order above 0 or a list of terms");
  return library;
}

std::string coefficient_unit(const std::string& target_unit, const std::string& term_unit) {
  if (target_unit.empty() || term_unit.empty()) return {};
  Dimension dimension = dimension_of(target_unit);
  multiply(dimension, dimension_of(term_unit), -1);
  return text_of(dimension);
}

}  // namespace ident
