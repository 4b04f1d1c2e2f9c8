#include "ident/library/expression_parser.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <utility>

#include "dsp/values/fault.hpp"
#include "dsp/values/names.hpp"

namespace ident {
namespace {

constexpr std::size_t longest_text = 2000;
constexpr int deepest_nesting = 50;

struct Infix {
  std::string_view text;
  Operation operation;
  int level;  ///< as in precedence()
};
// Where one begins another, the longer first.
constexpr std::array<Infix, 12> infixes{{{"||", Operation::logical_or, 1},
                                         {"&&", Operation::logical_and, 2},
                                         {"<=", Operation::less_equal, 3},
                                         {">=", Operation::greater_equal, 3},
                                         {"==", Operation::equal, 3},
                                         {"!=", Operation::not_equal, 3},
                                         {"<", Operation::less, 3},
                                         {">", Operation::greater, 3},
                                         {"+", Operation::add, 4},
                                         {"-", Operation::subtract, 4},
                                         {"*", Operation::multiply, 5},
                                         {"/", Operation::divide, 5}}};
constexpr int tightest_infix = 5;

bool name_character(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}
bool digit(char c) {
  return c >= '0' && c <= '9';
}

// Cuts a text from a file down to something fit for a message.
std::string quoted(std::string_view text) {
  std::string shown;
  for (const char c : text.substr(0, 60))
    shown += std::isprint(static_cast<unsigned char>(c)) ? std::string(1, c)
                                                         : fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
  return fmt::format("'{}{}'", shown, text.size() > 60 ? "..." : "");
}

[[noreturn]] void refuse(const std::string& fault, std::string_view text, const std::string& why) {
  throw dsp::Fault(dsp::FaultKind::usage, fault, "expression " + quoted(text) + ": " + why);
}

// What could be taken for something else, and texts made to exhaust the reader.
void check_characters(std::string_view text) {
  if (text.size() > longest_text)
    refuse("term.too_long", text, fmt::format("{} characters, at most {} are read", text.size(), longest_text));
  int depth = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i], before = i > 0 ? text[i - 1] : ' ', after = i + 1 < text.size() ? text[i + 1] : ' ';
    if (c == '(' && ++depth > deepest_nesting)
      refuse("term.too_long", text, fmt::format("brackets nested deeper than {}", deepest_nesting));
    if (c == ')') --depth;
    const bool comparison = after == '=' || before == '=' || before == '<' || before == '>' || before == '!';
    if (c == '=' && !comparison)
      refuse("term.assignment", text, fmt::format("position {}: '=' assigns; to compare, write '=='", i + 1));
    if (!std::isprint(static_cast<unsigned char>(c)))
      refuse("term.syntax", text, fmt::format("position {}: a character that cannot be printed", i + 1));
    if (c == ',' || c == ';' || c == '"' || c == '?' || c == ':')
      refuse("term.syntax", text, fmt::format("position {}: '{}' has no meaning here; one value is wanted", i + 1, c));
  }
  if (text.find_first_not_of(' ') == std::string_view::npos)
    refuse("term.syntax", text, "empty; want an expression such as x^2*v");
}

/// Recursive descent: a function a level of precedence.
class Parser {
 public:
  Parser(std::string_view text, const std::function<bool(std::string_view)>& is_signal, const std::string& known)
      : text_(text), is_signal_(is_signal), known_(known) {}

  Tree whole() {
    Tree tree = infix(1);
    if (!at_end()) unexpected("an operator");
    return tree;
  }

 private:
  // Operators of one level, from left to right.
  Tree infix(int level) {
    if (level > tightest_infix) return signed_power();
    Tree left = infix(level + 1);
    while (const Infix* found = infix_here(level)) {
      position_ += found->text.size();
      left = binary_node(found->operation, std::move(left), infix(level + 1));
    }
    return left;
  }

  Tree signed_power() {
    if (take('-')) return negate_node(power());
    take('+');
    return power();
  }

  // From right to left: 2^3^2 is 2^9.
  Tree power() {
    Tree base = value();
    if (!take('^')) return base;
    if (++num_powers_ > deepest_nesting)
      refuse("term.too_long", text_, fmt::format("powers of powers deeper than {}", deepest_nesting));
    Tree exponent = signed_power();
    --num_powers_;
    return binary_node(Operation::power, std::move(base), std::move(exponent));
  }

  Tree value() {
    if (at_end()) unexpected("a value");
    const char c = text_[position_];
    if (take('(')) return in_brackets();
    if (digit(c) || c == '.') return number();
    if (name_character(c)) return name();
    unexpected("a value");
  }

  Tree in_brackets() {
    Tree tree = infix(1);
    if (at_end()) fail(position_, "a closing bracket is missing");
    if (!take(')')) unexpected("an operator or a closing bracket");
    return tree;
  }

  Tree number() {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text_.data() + position_, text_.data() + text_.size(), value);
    if (error == std::errc::invalid_argument) unexpected("a value");
    if (error != std::errc()) fail(position_, "a number too large or too small to be held");
    position_ = static_cast<std::size_t>(end - text_.data());
    return number_node(value);
  }

  Tree name() {
    const std::size_t start = position_;
    while (position_ < text_.size() && name_character(text_[position_])) ++position_;
    const std::string_view word = text_.substr(start, position_ - start);
    const auto function = std::find_if(known_functions.begin(), known_functions.end(),
                                       [&](const KnownFunction& known) { return known.name == word; });
    if (function != known_functions.end() && take('(')) return call(function->function, start);
    if (is_signal_(word)) return signal_node(std::string(word));
    std::vector<std::string> functions;
    for (const KnownFunction& known : known_functions) functions.emplace_back(known.name);
    const std::string near = word.size() < 3 ? "" : dsp::nearest(word, functions);
    const std::string why = function != known_functions.end() ? "is a function and wants its argument in brackets"
                            : near.empty()                    ? "is not known here; " + known_
                                           : fmt::format("is not known here (did you mean {}?); {}", near, known_);
    refuse("term.unknown_name", text_, fmt::format("position {}: {} {}", start + 1, quoted(word), why));
  }

  Tree call(Function function, std::size_t start) {
    if (function != Function::sgn) return call_node(function, in_brackets());
    if (in_sgn_) fail(start, "sgn is inside sgn");
    in_sgn_ = true;
    Tree argument = in_brackets();
    in_sgn_ = false;
    return call_node(function, std::move(argument));
  }

  const Infix* infix_here(int level) {
    skip_blanks();
    const auto found = std::find_if(infixes.begin(), infixes.end(), [&](const Infix& known) {
      return text_.substr(position_).starts_with(known.text);
    });
    return found != infixes.end() && found->level == level ? &*found : nullptr;
  }

  bool take(char c) {
    skip_blanks();
    if (position_ == text_.size() || text_[position_] != c) return false;
    ++position_;
    return true;
  }
  bool at_end() {
    skip_blanks();
    return position_ == text_.size();
  }
  void skip_blanks() { position_ = std::min(text_.find_first_not_of(' ', position_), text_.size()); }

  [[noreturn]] void unexpected(const char* wanted) {
    if (at_end()) fail(position_, fmt::format("the expression ends where {} is wanted", wanted));
    std::size_t end = position_ + 1;
    while (name_character(text_[position_]) && end < text_.size() && name_character(text_[end])) ++end;
    fail(position_, fmt::format("{} where {} is wanted", quoted(text_.substr(position_, end - position_)), wanted));
  }
  [[noreturn]] void fail(std::size_t position, const std::string& why) const {
    refuse("term.syntax", text_, fmt::format("position {}: {}", position + 1, why));
  }

  std::string_view text_;
  const std::function<bool(std::string_view)>& is_signal_;
  const std::string& known_;
  std::size_t position_ = 0;
  int num_powers_ = 0;  ///< those whose exponent is being read
  bool in_sgn_ = false;
};

}  // namespace

Tree parse_expression(std::string_view text, const std::function<bool(std::string_view)>& is_signal,
                      const std::string& known) {
  check_characters(text);
  return Parser(text, is_signal, known).whole();
}

}  // namespace ident
