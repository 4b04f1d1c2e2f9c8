#include "apps/page/equation_display.hpp"

#include <fmt/format.h>

#include <cmath>

#include "apps/output/html_writer.hpp"
#include "apps/page/rounded.hpp"
#include "ident/library/expression.hpp"

namespace apps {
namespace {

using ident::Notation;

std::string number_in(const Rounded& number, Notation notation) {
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

}  // namespace

double shown_std(const ident::ModelTerm& term) {
  return std::isfinite(term.std_si) ? term.std_si : term.std;
}

std::string displayed_equation(const ident::Model& model, Notation notation) {
  const bool mathml = notation == Notation::mathml;
  const auto piece = [&](const std::string& content) {
    return mathml ? "<math><mrow>" + content + "</mrow></math> " : content;
  };
  std::string text = piece(ident::Expression(model.target).print(notation) + (mathml ? "<mo>=</mo>" : " ="));
  for (const ident::ModelTerm& term : model.terms) {
    const std::string number = number_in(rounded(std::abs(term.mean), shown_std(term)), notation);
    const std::string factor = term.name == "1" ? "" : ident::Expression(term.name).print_as_factor(notation);
    const char* between = factor.empty()                ? ""
                          : mathml                      ? "<mspace width=\"0.2em\"/>"
                          : notation == Notation::latex ? "\\,"
                                                        : " ";
    text += piece(joined(notation, &term == &model.terms.front(), term.mean < 0.0) + number + between + factor);
  }
  if (model.terms.empty()) text += mathml ? piece("<mn>0</mn>") : " 0";
  return text;
}

}  // namespace apps
