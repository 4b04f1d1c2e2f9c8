#include "apps/page/equation_display.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "apps/process/printable.hpp"
#include "apps/text/html_writer.hpp"
#include "apps/text/rounded.hpp"
#include "ident/library/expression.hpp"

namespace apps {
namespace {

using ident::Notation;

std::string in_notation(const Rounded& number, Notation notation) {
  const int power = number.power_of_ten;
  if (notation == Notation::text) return power == 0 ? number.digits : fmt::format("{}e{:+03d}", number.digits, power);
  if (notation == Notation::latex)
    return power == 0 ? number.digits : fmt::format("{} \\cdot 10^{{{}}}", number.digits, power);
  const std::string digits = fmt::format("<mn>{}</mn>", escaped_markup(number.digits));
  return power == 0 ? digits : fmt::format("{}<mo>&#xD7;</mo><msup><mn>10</mn><mn>{}</mn></msup>", digits, power);
}

std::string joined(Notation notation, bool first, bool negative) {
  if (first && !negative) return notation == Notation::mathml ? "" : " ";
  const char sign = negative ? '-' : '+';
  if (notation == Notation::mathml) return fmt::format("<mo form=\"infix\">{}</mo>", negative ? "&#x2212;" : "+");
  return first ? fmt::format(" {}", sign) : fmt::format(" {} ", sign);
}

/// "c1" with its number as an index.
std::string symbol_in(const std::string& symbol, Notation notation) {
  const std::string letter = symbol.substr(0, 1), index = symbol.substr(1);
  if (notation == Notation::text) return symbol;
  return notation == Notation::latex ? fmt::format("{}_{{{}}}", letter, index)
                                     : fmt::format("<msub><mi>{}</mi><mn>{}</mn></msub>", letter, index);
}

}  // namespace

std::string displayed_equation(const ident::Model& model, Notation notation) {
  const bool mathml = notation == Notation::mathml;
  const auto piece = [&](const std::string& content) {
    return mathml ? "<math><mrow>" + content + "</mrow></math> " : content;
  };
  std::string text = piece(ident::Expression(model.target).print(notation) + (mathml ? "<mo>=</mo>" : " ="));
  bool first = true;
  const auto add = [&](bool negative, const std::string& number, const std::string& name) {
    const std::string factor = name == "1" ? "" : ident::Expression(name).print_as_factor(notation);
    const char* between = factor.empty() || number.empty() ? ""
                          : mathml                         ? "<mspace width=\"0.2em\"/>"
                          : notation == Notation::latex    ? "\\,"
                                                           : " ";
    text += piece(joined(notation, first, negative) + number + between + factor);
    first = false;
  };
  for (const ident::ModelTerm& term : model.terms)
    if (term.recording == 0)
      add(term.mean < 0.0,
          std::abs(term.mean) == 1.0 && term.std == 0.0  // a scale, not an estimate
              ? ""
              : in_notation(rounded(std::abs(term.mean), term.std), notation),
          term.name);
  for (const ident::OwnCoefficients& own : own_coefficients(model))
    add(false, symbol_in(own.symbol, notation), own.name);
  if (model.terms.empty()) text += mathml ? piece("<mn>0</mn>") : " 0";
  return text;
}

std::vector<std::string> own_coefficient_sentences(const ident::Model& model) {
  std::vector<std::string> sentences;
  for (const ident::OwnCoefficients& own : own_coefficients(model)) {
    const std::string what = own.name == "1" ? "the constant" : own.name;
    if (own.are_many()) {
      const auto [least, greatest] = own.extremes();
      sentences.push_back(fmt::format(
          "{}, of {}, differs by recording: from {} in {} to {} in {}, {} recordings in all.", own.symbol, what,
          with_uncertainty(least->mean, least->std), printable(least->recording_name, 100),
          with_uncertainty(greatest->mean, greatest->std), printable(greatest->recording_name, 100), own.terms.size()));
      continue;
    }
    std::vector<std::string> values;
    for (const ident::ModelTerm* term : own.terms)
      values.push_back(
          fmt::format("{} in {}", with_uncertainty(term->mean, term->std), printable(term->recording_name, 100)));
    sentences.push_back(fmt::format("{}, of {}, differs by recording: {}.", own.symbol, what, fmt::join(values, ", ")));
  }
  return sentences;
}

}  // namespace apps
