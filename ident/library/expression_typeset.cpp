// LaTeX and MathML: fractions and exponents need no brackets, signals have the letters of the field.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <string_view>

#include "ident/library/expression_printers.hpp"

namespace ident {
namespace {

/// A signal that is a derivative with respect to time: dots over the letter.
struct Letter {
  std::string_view name, letter;
  int dots;
};
constexpr std::array<Letter, 6> letters{
    {{"v", "x", 1}, {"a", "x", 2}, {"dr", "r", 1}, {"ddr", "r", 2}, {"dy", "y", 1}, {"ddy", "y", 2}}};

const Letter* letter_of(const std::string& name) {
  const auto found =
      std::find_if(letters.begin(), letters.end(), [&](const Letter& letter) { return letter.name == name; });
  return found == letters.end() ? nullptr : &*found;
}

/// "1e-05" as digits and the power of ten behind it, if any.
std::pair<std::string, std::string> split_number(double value) {
  const std::string text = fmt::format("{}", value);
  const std::size_t e = text.find('e');
  if (e == std::string::npos) return {text, {}};
  return {text.substr(0, e), fmt::format("{}", std::stoi(text.substr(e + 1)))};
}

/// How one language writes what both have.
struct Markup {
  std::string_view dot, double_dot, letter, word;     ///< {0}: the letter or the name
  std::string_view number, power_of_ten;              ///< {0}: the digits; {0} and {1}
  std::string_view fraction, power, root, magnitude;  ///< {0} and {1}
  std::string_view index;                             ///< {0}: a letter; {1}: its number
  std::string_view named;                             ///< {0}: the function; {1}: its argument
  std::string_view brackets, tall_brackets, negative;
  std::array<std::string_view, 12> infix;  ///< add, subtract, product of letters, of digits, < to ||
};

constexpr Markup latex{"\\dot{{{}}}",
                       "\\ddot{{{}}}",
                       "{}",
                       "\\mathrm{{{}}}",
                       "{}",
                       "{} \\cdot 10^{{{}}}",
                       "\\frac{{{}}}{{{}}}",
                       "{}^{{{}}}",
                       "\\sqrt{{{}}}",
                       "\\left|{}\\right|",
                       "{}_{{{}}}",
                       "{}({})",
                       "({})",
                       "\\left({}\\right)",
                       "-{}",
                       {"{}+{}", "{}-{}", "{} {}", "{} \\cdot {}", "{}<{}", "{} \\le {}", "{}>{}", "{} \\ge {}",
                        "{}={}", "{} \\ne {}", "{} \\land {}", "{} \\lor {}"}};
constexpr Markup mathml{
    "<mover><mi>{}</mi><mo>&#x2D9;</mo></mover>",
    "<mover><mi>{}</mi><mo>&#xA8;</mo></mover>",
    "<mi>{}</mi>",
    "<mi mathvariant=\"normal\">{}</mi>",
    "<mn>{}</mn>",
    "<mrow><mn>{}</mn><mo>&#xD7;</mo><msup><mn>10</mn><mn>{}</mn></msup></mrow>",
    "<mfrac>{}{}</mfrac>",
    "<msup>{}{}</msup>",
    "<msqrt>{}</msqrt>",
    "<mrow><mo>|</mo>{}<mo>|</mo></mrow>",
    "<msub>{}<mn>{}</mn></msub>",
    "<mrow><mi>{}</mi><mo>&#x2061;</mo><mo stretchy=\"false\">(</mo>{}<mo stretchy=\"false\">)</mo></mrow>",
    "<mrow><mo>(</mo>{}<mo>)</mo></mrow>",
    "<mrow><mo>(</mo>{}<mo>)</mo></mrow>",
    "<mrow><mo>-</mo>{}</mrow>",
    {"<mrow>{}<mo>+</mo>{}</mrow>", "<mrow>{}<mo>-</mo>{}</mrow>", "<mrow>{}<mo>&#x2062;</mo>{}</mrow>",
     "<mrow>{}<mo>&#xD7;</mo>{}</mrow>", "<mrow>{}<mo>&lt;</mo>{}</mrow>", "<mrow>{}<mo>&#x2264;</mo>{}</mrow>",
     "<mrow>{}<mo>&gt;</mo>{}</mrow>", "<mrow>{}<mo>&#x2265;</mo>{}</mrow>", "<mrow>{}<mo>=</mo>{}</mrow>",
     "<mrow>{}<mo>&#x2260;</mo>{}</mrow>", "<mrow>{}<mo>&#x2227;</mo>{}</mrow>", "<mrow>{}<mo>&#x2228;</mo>{}</mrow>"}};

class Typesetter {
 public:
  explicit Typesetter(const Markup& markup) : markup_(markup), is_latex_(&markup == &latex) {}

  std::string print(const Node& node) const {
    switch (node.operation) {
      case Operation::number:
        return number(node.value);
      case Operation::signal:
        return signal(node.name);
      case Operation::call:
        return call(node);
      case Operation::negate:
        return put(markup_.negative, operand(node, Side::left));
      case Operation::divide:
        return put(markup_.fraction, print(*node.left), print(*node.right));
      case Operation::power:
        return put(markup_.power, base(*node.left), print(*node.right));
      default:
        return put(infix(node), operand(node, Side::left), operand(node, Side::right));
    }
  }

 private:
  template <class... Parts>
  static std::string put(std::string_view format, const Parts&... parts) {
    return fmt::format(fmt::runtime(format), parts...);
  }

  std::string number(double value) const {
    const auto [digits, ten] = split_number(value);
    return ten.empty() ? put(markup_.number, digits) : put(markup_.power_of_ten, digits, ten);
  }

  std::string signal(const std::string& name) const {
    if (const Letter* known = letter_of(name))
      return put(known->dots == 1 ? markup_.dot : markup_.double_dot, known->letter);
    const std::size_t stem = name.find_last_not_of("0123456789") + 1;
    if (stem < name.size() && (stem == 1 || letter_of(name.substr(0, stem)) != nullptr))
      return put(markup_.index, signal(name.substr(0, stem)), name.substr(stem));
    std::string shown;
    for (const char c : name) shown += is_latex_ && c == '_' ? "\\_" : std::string(1, c);
    return put(name.size() == 1 ? markup_.letter : markup_.word, shown);
  }

  std::string call(const Node& node) const {
    const std::string argument = print(*node.left);
    if (node.function == Function::abs) return put(markup_.magnitude, argument);
    if (node.function == Function::sqrt) return put(markup_.root, argument);
    const KnownFunction& known = info_of(node.function);
    return put(markup_.named, is_latex_ ? known.latex : known.name, argument);
  }

  std::string_view infix(const Node& node) const {
    if (node.operation == Operation::add) return markup_.infix[0];
    if (node.operation == Operation::subtract) return markup_.infix[1];
    if (node.operation != Operation::multiply)
      return markup_.infix[static_cast<std::size_t>(node.operation) - static_cast<std::size_t>(Operation::less) + 4];
    const Node* first = node.right.get();  // two numbers side by side would be one
    while (first->operation == Operation::multiply || first->operation == Operation::power) first = first->left.get();
    return markup_.infix[first->operation == Operation::number ? 3 : 2];
  }

  std::string operand(const Node& parent, Side side) const {
    const Node& node = *(side == Side::left ? parent.left : parent.right);
    const bool ends_itself = node.operation == Operation::divide && parent.operation != Operation::negate;
    return !ends_itself && needs_brackets(parent, node, side) ? bracketed(node) : print(node);
  }

  std::string base(const Node& node) const {
    const bool two_parts = (node.operation == Operation::call && node.function == Function::sqrt) ||
                           (node.operation == Operation::number && !split_number(node.value).second.empty());
    const bool atom = precedence(node) == 7 && !two_parts;
    return atom ? print(node) : bracketed(node);
  }

  std::string bracketed(const Node& node) const {
    const std::string text = print(node);
    return put(text.find("\\frac") == std::string::npos ? markup_.brackets : markup_.tall_brackets, text);
  }

  const Markup& markup_;
  bool is_latex_;
};

}  // namespace

std::string print_latex(const Node& node) {
  return Typesetter(latex).print(node);
}
std::string print_mathml(const Node& node) {
  return Typesetter(mathml).print(node);
}

}  // namespace ident
