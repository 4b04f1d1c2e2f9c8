#include "ident/library/expression.hpp"

#include <fmt/format.h>
#include <muParser.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <utility>

namespace ident {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr std::size_t longest_text = 2000;
constexpr int deepest_nesting = 50;

double sign(double g) {
  return g > 0.0 ? 1.0 : g < 0.0 ? -1.0 : 0.0;
}

using Function = double (*)(double);
struct KnownFunction {
  const char* name;
  Function value;
  const char* meaning;
};
constexpr std::array<KnownFunction, 8> functions{{
    {"abs", [](double g) { return std::abs(g); }, "magnitude"},
    {"sgn", sign, "sign: -1, 0 or 1; a switch that simulations locate exactly"},
    {"sin", [](double g) { return std::sin(g); }, "sine of radians"},
    {"cos", [](double g) { return std::cos(g); }, "cosine of radians"},
    {"exp", [](double g) { return std::exp(g); }, "exponential"},
    {"log", [](double g) { return std::log(g); }, "natural logarithm; not finite at or below zero"},
    {"sqrt", [](double g) { return std::sqrt(g); }, "square root; not finite below zero"},
    {"tanh", [](double g) { return std::tanh(g); }, "hyperbolic tangent, a smooth sign"},
}};

// Cuts a text from a file down to something fit for a message.
std::string quoted(std::string_view text) {
  std::string shown;
  for (const char c : text.substr(0, 60))
    shown += std::isprint(static_cast<unsigned char>(c)) ? std::string(1, c)
                                                         : fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
  return "'" + shown + (text.size() > 60 ? "...'" : "'");
}

// muParser's words without the position at their end: it counts differently.
std::string reason_of(const mu::Parser::exception_type& error) {
  std::string message = error.GetMsg();
  for (const char* tail : {" found at position", " at position"})
    if (const auto at = message.rfind(tail); at != std::string::npos) message.erase(at);
  return message;
}

std::string trimmed(std::string text) {
  text.erase(text.find_last_not_of(" \t") + 1);
  return text;
}

[[noreturn]] void refuse(const std::string& fault, std::string_view text, const std::string& why) {
  throw dsp::Fault(dsp::FaultKind::usage, fault, "expression " + quoted(text) + ": " + why);
}

// What muParser would accept and a term must not hold: assignments, lists, and texts made to exhaust it.
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
  if (text.find_first_not_of(" \t") == std::string_view::npos)
    refuse("term.syntax", text, "empty; want an expression such as x^2*v");
}

mu::Parser bare_parser() {
  mu::Parser parser;
  parser.ClearFun();
  parser.ClearConst();
  for (const KnownFunction& f : functions) parser.DefineFun(f.name, f.value);
  return parser;
}

template <class Names>
std::string joined(const Names& names) {
  std::string all;
  for (const auto& name : names) all += (all.empty() ? "" : ", ") + std::string(name);
  return all;
}

bool name_character(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || c == '_';
}

// Replaces each sgn(g) by a variable of its own; `switches` receives the texts of the g.
std::string without_switches(std::string_view text, std::vector<std::string>& switches) {
  std::string plain;
  for (std::size_t i = 0; i < text.size();) {
    const bool starts = text.substr(i, 3) == "sgn" && (i == 0 || !name_character(text[i - 1]));
    const std::size_t open = starts ? text.find_first_not_of(" \t", i + 3) : std::string_view::npos;
    if (open == std::string_view::npos || text[open] != '(') {
      plain += text[i++];
      continue;
    }
    std::size_t close = open;
    for (int depth = 0; close < text.size(); ++close) {
      depth += text[close] == '(' ? 1 : text[close] == ')' ? -1 : 0;
      if (depth == 0) break;
    }
    std::string argument(text.substr(open + 1, close - open - 1));
    argument.erase(std::remove(argument.begin(), argument.end(), ' '), argument.end());
    const auto known = std::find(switches.begin(), switches.end(), argument);
    plain += fmt::format("switch_{}", known - switches.begin());
    if (known == switches.end()) switches.push_back(std::move(argument));
    i = close + 1;
  }
  return plain;
}

VectorXd sampled_sign(const VectorXd& g, const dsp::Signal* derivative, double sample_rate_hz) {
  if (derivative == nullptr) return g.unaryExpr(&sign);
  return g.binaryExpr(derivative->values, [&](double value, double slope) {
    const double reach = std::abs(slope) / (2.0 * sample_rate_hz);  // |g| within half a cell of its zero
    return reach > 0.0 ? std::clamp(value / reach, -1.0, 1.0) : sign(value);
  });
}

const dsp::Signal* known_derivative(const std::string& signal, const dsp::Motion& motion) {
  const dsp::SignalInfo* derivative = dsp::derivative_of(signal);
  return derivative == nullptr ? nullptr : motion.find(derivative->name);
}

}  // namespace

std::vector<FunctionHelp> expression_functions() {
  std::vector<FunctionHelp> help;
  for (const KnownFunction& f : functions) help.push_back({std::string(f.name) + "(g)", f.meaning});
  help.push_back(
      {"+ - * / ^", "arithmetic; ^ is a real power, -x^2 is -(x^2), a negative base wants a whole exponent"});
  help.push_back({"< <= > >= == != && ||", "comparisons, for conditions"});
  return help;
}

struct Expression::Impl {
  std::string text, plain;
  std::vector<std::string> signals, switches;
  std::vector<Expression> switch_arguments;
  mu::Parser pointwise;
  std::vector<double> slots;  // what `pointwise` reads: signals, then signs
  [[nodiscard]] std::string slot_name(std::size_t k) const {
    return k < signals.size() ? signals[k] : fmt::format("switch_{}", k - signals.size());
  }
};

Expression::Expression(std::string_view text, const std::vector<std::string>& signal_names)
    : impl_(std::make_unique<Impl>()) {
  check_characters(text);
  impl_->text = std::string(text);
  std::vector<double> dummy(signal_names.size(), 1.0);
  try {
    mu::Parser parser = bare_parser();
    for (std::size_t i = 0; i < signal_names.size(); ++i) parser.DefineVar(signal_names[i], &dummy[i]);
    parser.SetExpr(impl_->text);
    int count = 0;
    parser.Eval(count);
    if (count != 1) refuse("term.syntax", text, fmt::format("gives {} values, one is wanted", count));
    std::vector<std::pair<std::size_t, std::string>> used;  // muParser lists names alphabetically; ours by appearance
    for (const auto& entry : parser.GetUsedVar()) {
      std::size_t place = 0;
      const std::string& name = entry.first;
      do place = impl_->text.find(name, place == 0 ? 0 : place + 1);
      while ((place > 0 && name_character(impl_->text[place - 1])) ||
             (place + name.size() < impl_->text.size() && name_character(impl_->text[place + name.size()])));
      used.emplace_back(place, name);
    }
    std::sort(used.begin(), used.end());
    for (auto& [place, name] : used) impl_->signals.push_back(std::move(name));
  } catch (const mu::Parser::exception_type& error) {
    // muParser counts from 0, and what is missing at the end two places beyond it.
    const std::size_t position = std::min(static_cast<std::size_t>(std::max(error.GetPos(), 0)), text.size()) + 1;
    if (error.GetCode() == mu::ecUNASSIGNABLE_TOKEN)
      refuse(
          "term.unknown_name", text,
          fmt::format("position {}: {} is not known here; signals are {}; functions abs sgn sin cos exp log sqrt tanh",
                      position, quoted(trimmed(error.GetToken())), joined(signal_names)));
    refuse("term.syntax", text, fmt::format("position {}: {}", position, reason_of(error)));
  }

  impl_->plain = without_switches(impl_->text, impl_->switches);
  for (const std::string& argument : impl_->switches) {
    impl_->switch_arguments.emplace_back(argument, signal_names);
    if (!impl_->switch_arguments.back().switches().empty()) refuse("term.syntax", text, "sgn stands inside sgn");
  }
  impl_->slots.assign(impl_->signals.size() + impl_->switches.size(), 1.0);
  impl_->pointwise = bare_parser();
  for (std::size_t k = 0; k < impl_->slots.size(); ++k)
    impl_->pointwise.DefineVar(impl_->slot_name(k), &impl_->slots[k]);
  impl_->pointwise.SetExpr(impl_->plain);
}

Expression::~Expression() = default;
Expression::Expression(Expression&&) noexcept = default;
Expression& Expression::operator=(Expression&&) noexcept = default;

const std::string& Expression::text() const {
  return impl_->text;
}
const std::vector<std::string>& Expression::signals() const {
  return impl_->signals;
}
const std::vector<std::string>& Expression::switches() const {
  return impl_->switches;
}

VectorXd Expression::evaluate(const dsp::Motion& motion, SwitchSampling sampling) const {
  const Index num_samples = motion.num_samples();
  std::vector<VectorXd> signs;
  for (std::size_t k = 0; k < impl_->switches.size(); ++k)
    signs.push_back(
        sampled_sign(impl_->switch_arguments[k].evaluate(motion, sampling),
                     sampling == SwitchSampling::cell_average ? known_derivative(impl_->switches[k], motion) : nullptr,
                     motion.sample_rate_hz));

  // Row by row: muParser's own loop over arrays starts threads, which nobody asked for and which spin when done.
  std::vector<const double*> columns;
  for (const std::string& name : impl_->signals) columns.push_back(motion.at(name).data());
  for (const VectorXd& sign : signs) columns.push_back(sign.data());
  std::vector<double> row(columns.size());
  mu::Parser parser = bare_parser();
  for (std::size_t k = 0; k < row.size(); ++k) parser.DefineVar(impl_->slot_name(k), &row[k]);
  parser.SetExpr(impl_->plain);
  if (row.empty()) return VectorXd::Constant(num_samples, parser.Eval());
  VectorXd values(num_samples);
  for (Index i = 0; i < num_samples; ++i) {
    for (std::size_t k = 0; k < row.size(); ++k) row[k] = columns[k][i];
    values(i) = parser.Eval();
  }
  return values;
}

double Expression::evaluate(const double* values, const double* signs) const {
  std::copy(values, values + impl_->signals.size(), impl_->slots.begin());
  std::copy(signs, signs + impl_->switches.size(),
            impl_->slots.begin() + static_cast<std::ptrdiff_t>(impl_->signals.size()));
  return impl_->pointwise.Eval();
}

std::vector<unsigned char> rows_where(const Expression& condition, const dsp::Motion& motion) {
  const VectorXd values = condition.evaluate(motion, SwitchSampling::point);
  std::vector<unsigned char> rows(static_cast<std::size_t>(values.size()));
  for (Index i = 0; i < values.size(); ++i)
    rows[static_cast<std::size_t>(i)] = std::isfinite(values(i)) && values(i) != 0.0;
  return rows;
}

}  // namespace ident
