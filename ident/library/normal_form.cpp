#include "ident/library/normal_form.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace ident {
namespace {

bool is_whole(double value) {
  return value == std::floor(value);
}

/// Twelve digits: what differs by the rounding of folded numbers is one number.
std::string key_of(double value) {
  return fmt::format("{:.12g}", value);
}

std::string joined(std::vector<std::string> parts, const char* by) {
  std::sort(parts.begin(), parts.end());
  return fmt::format("{}", fmt::join(parts, by));
}

double power_of(double base, double exponent) {
  return exponent == 1.0 ? base : std::pow(base, exponent);
}

Tree power_tree(const Tree& base, double exponent) {
  if (exponent == 1.0) return base;
  if (exponent == 0.5) return call_node(Function::sqrt, base);
  return binary_node(Operation::power, base, number_node(exponent));
}

/// `text` of a key for an operation that is not expressed by sums, products and powers of numbers.
std::string operation_key(Operation operation, std::string left, std::string right) {
  const bool commutes = operation == Operation::equal || operation == Operation::not_equal ||
                        operation == Operation::logical_and || operation == Operation::logical_or;
  if (commutes && right < left) std::swap(left, right);
  return fmt::format("[{} {} {}]", static_cast<int>(operation), left, right);
}

}  // namespace

NormalForm::NormalForm(double number) {
  if (number != 0.0) terms_.push_back({number, {}});
}

NormalForm NormalForm::signal(const std::string& name) {
  return of_factor({name, 1.0, signal_node(name), 1.0});
}

NormalForm NormalForm::of_factor(Factor factor) {
  return of_term({1.0, {std::move(factor)}});
}

NormalForm NormalForm::of_term(const Term& term) {
  NormalForm form(0.0);
  form.add(term);
  return form;
}

std::string NormalForm::Term::key() const {
  std::vector<std::string> parts;
  for (const Factor& factor : factors)
    parts.push_back(factor.exponent == 1.0 ? factor.key : fmt::format("{}^{}", factor.key, key_of(factor.exponent)));
  return joined(std::move(parts), "*");
}

double NormalForm::Term::scale() const {
  double product = 1.0;
  for (const Factor& factor : factors) product *= power_of(factor.scale, factor.exponent);
  return product;
}

void NormalForm::Term::multiply(const Factor& factor) {
  const auto same = std::find_if(factors.begin(), factors.end(), [&](const Factor& known) {
    return known.key == factor.key && (known.scale == factor.scale || is_whole(factor.exponent));
  });
  if (same == factors.end()) {
    factors.push_back(factor);
    return;
  }
  coefficient *= power_of(factor.scale / same->scale, factor.exponent);
  same->exponent += factor.exponent;
  if (same->exponent == 0.0) factors.erase(same);
}

void NormalForm::add(const Term& term) {
  const auto same =
      std::find_if(terms_.begin(), terms_.end(), [&](const Term& known) { return known.key() == term.key(); });
  if (same == terms_.end()) {
    if (term.coefficient != 0.0) terms_.push_back(term);
    return;
  }
  same->coefficient += term.coefficient * (term.scale() / same->scale());
  if (same->coefficient == 0.0) terms_.erase(same);
}

NormalForm operator+(NormalForm a, const NormalForm& b) {
  for (const NormalForm::Term& term : b.terms_) a.add(term);
  return a;
}

NormalForm operator*(double factor, NormalForm a) {
  if (factor == 0.0) return NormalForm(0.0);
  for (NormalForm::Term& term : a.terms_) term.coefficient *= factor;
  return a;
}

NormalForm operator*(const NormalForm& a, const NormalForm& b) {
  if (const auto number = a.number()) return *number * b;
  if (const auto number = b.number()) return *number * a;
  NormalForm::Term product;
  for (const NormalForm* form : {&a, &b}) {
    if (form->terms_.size() > 1) {
      product.multiply(form->as_factor());
      continue;
    }
    product.coefficient *= form->terms_.front().coefficient;
    for (const NormalForm::Factor& factor : form->terms_.front().factors) product.multiply(factor);
  }
  return NormalForm::of_term(product);
}

std::optional<double> NormalForm::number() const {
  if (terms_.empty()) return 0.0;
  if (terms_.size() > 1 || !terms_.front().factors.empty()) return std::nullopt;
  return terms_.front().coefficient;
}

NormalForm::Scaled NormalForm::scaled() const {
  std::vector<std::pair<std::string, double>> parts;
  for (const Term& term : terms_) parts.emplace_back(term.key(), term.coefficient * term.scale());
  if (parts.empty()) return {0.0, "0"};
  std::sort(parts.begin(), parts.end());
  const double scale = parts.front().second;
  std::string unit;
  for (const auto& [key, coefficient] : parts) unit += fmt::format("{:+.12g} {} ", coefficient / scale, key);
  return {scale, unit};
}

NormalForm::Factor NormalForm::as_factor() const {
  if (terms_.size() == 1 && terms_.front().factors.size() == 1 && terms_.front().factors.front().exponent == 1.0) {
    const Factor& only = terms_.front().factors.front();
    return {only.key, only.scale * terms_.front().coefficient, tree(), 1.0};
  }
  const Scaled own = scaled();
  return {fmt::format("({})", own.unit), own.scale, tree(), 1.0};
}

NormalForm NormalForm::call(Function function, const NormalForm& argument) {
  if (function == Function::sqrt) return power(argument, NormalForm(0.5));
  const Scaled inner = argument.scaled();
  const KnownFunction& known = info_of(function);
  const double sign_of_it = inner.scale < 0.0 ? -1.0 : 1.0;
  double scale = 1.0, left = inner.scale;  // f(c u) = scale f(left u)
  if (known.parity == Parity::odd) scale = sign_of_it;
  if (known.parity != Parity::none) left = std::abs(inner.scale);
  if (function == Function::abs) scale = left;
  if (function == Function::abs || function == Function::sgn) left = 1.0;
  if (inner.scale == 0.0) scale = 1.0;
  return of_factor({fmt::format("{}({} {})", known.name, key_of(left), inner.unit), scale,
                    call_node(function, argument.tree()), 1.0});
}

NormalForm NormalForm::whole_power(const NormalForm& base, double exponent) {
  if (base.terms_.size() > 1) {
    Factor factor = base.as_factor();
    factor.exponent = exponent;
    return of_factor(std::move(factor));
  }
  Term term = base.terms_.front();
  term.coefficient = std::pow(term.coefficient, exponent);
  for (Factor& factor : term.factors) factor.exponent *= exponent;
  return of_term(term);
}

NormalForm NormalForm::power(const NormalForm& base, const NormalForm& exponent) {
  const auto number = exponent.number(), base_number = base.number();
  if (number && *number == 0.0) return NormalForm(1.0);
  if (number && *number == 1.0) return base;
  if (number && base_number) {
    const double value = std::pow(*base_number, *number);
    if (std::isfinite(value)) return NormalForm(value);
  } else if (number && is_whole(*number)) {
    return whole_power(base, *number);
  }
  Factor whole = base.as_factor();
  if (!(whole.scale > 0.0)) whole.key = fmt::format("({} {})", key_of(whole.scale), whole.key), whole.scale = 1.0;
  if (number) return of_factor({whole.key, whole.scale, whole.base, *number});
  const Scaled above = exponent.scaled();
  return of_factor({fmt::format("pow({} {} {} {})", key_of(whole.scale), whole.key, key_of(above.scale), above.unit),
                    1.0, binary_node(Operation::power, whole.base, exponent.tree()), 1.0});
}

NormalForm NormalForm::of(const Tree& tree) {
  const Node& node = *tree;
  switch (node.operation) {
    case Operation::number:
      return NormalForm(node.value);
    case Operation::signal:
      return signal(node.name);
    case Operation::call:
      return call(node.function, of(node.left));
    case Operation::negate:
      return -1.0 * of(node.left);
    case Operation::add:
      return of(node.left) + of(node.right);
    case Operation::subtract:
      return of(node.left) + -1.0 * of(node.right);
    case Operation::multiply:
      return of(node.left) * of(node.right);
    case Operation::divide:
      return of(node.left) * power(of(node.right), NormalForm(-1.0));
    case Operation::power:
      return power(of(node.left), of(node.right));
    default:
      break;
  }
  const NormalForm left = of(node.left), right = of(node.right);
  const auto key = [](const NormalForm& form) {
    const Scaled scaled = form.scaled();
    return fmt::format("{} {}", key_of(scaled.scale), scaled.unit);
  };
  const bool turned = node.operation == Operation::greater || node.operation == Operation::greater_equal;
  const Operation operation = node.operation == Operation::greater         ? Operation::less
                              : node.operation == Operation::greater_equal ? Operation::less_equal
                                                                           : node.operation;
  return of_factor({operation_key(operation, key(turned ? right : left), key(turned ? left : right)), 1.0,
                    binary_node(node.operation, left.tree(), right.tree()), 1.0});
}

/// c * a^2 * b / (d * e): the coefficient's magnitude, what is above, what is below.
Tree NormalForm::Term::tree() const {
  Tree above, below;
  const auto put = [](Tree& side, const Tree& factor) {
    side = side ? binary_node(Operation::multiply, side, factor) : factor;
  };
  if (std::abs(coefficient) != 1.0) put(above, number_node(std::abs(coefficient)));
  for (const Factor& factor : factors)
    put(factor.exponent > 0.0 ? above : below, power_tree(factor.base, std::abs(factor.exponent)));
  if (!above) above = number_node(1.0);
  return below ? binary_node(Operation::divide, above, below) : above;
}

namespace {

/// -(a*b/c) as the reader reads -a*b/c.
Tree negated(const Tree& tree) {
  const bool product = tree->operation == Operation::multiply || tree->operation == Operation::divide;
  return product ? binary_node(tree->operation, negated(tree->left), tree->right) : negate_node(tree);
}

}  // namespace

Tree NormalForm::tree() const {
  if (terms_.empty()) return number_node(0.0);
  Tree sum;
  for (const Term& term : terms_) {
    const Tree next = term.tree();
    const bool minus = term.coefficient < 0.0;
    sum = !sum    ? (minus ? negated(next) : next)
          : minus ? binary_node(Operation::subtract, sum, next)
                  : binary_node(Operation::add, sum, next);
  }
  return sum;
}

}  // namespace ident
