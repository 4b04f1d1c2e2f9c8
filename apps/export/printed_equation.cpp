#include "apps/export/printed_equation.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "apps/text/csv_table.hpp"

namespace apps {
namespace {

using ident::Notation;

/// What programs differ in: formats.
struct Language {
  Notation notation;
  std::string_view comment, list, nan;  ///< list: {0} the name, {1} the numbers
  std::string_view begin, end;          ///< of a function; {0} its name, {1} how many values it has
  std::string_view local, result;       ///< {0} the name or the index, {1} the value
  std::string_view element;             ///< {0} of what, {1} the index
  int first;                            ///< the index of the first
};
constexpr Language python{Notation::python,
                          "# {}",
                          "{} = np.array([{}], float)\n",
                          "np.nan",
                          "\n\ndef {}(p, t, state, inputs, sides):\n    value = np.zeros({})\n",
                          "    return value\n",
                          "    {} = {}\n",
                          "    value[{}] = {}\n",
                          "{}[{}]",
                          0};
constexpr Language matlab{Notation::matlab,
                          "% {}",
                          "  data.{} = [{}].';\n",
                          "NaN",
                          "\nfunction value = {}(p, t, state, inputs, sides)\n  value = zeros({}, 1);\n",
                          "end\n",
                          "  {} = {};\n",
                          "  value({}) = {};\n",
                          "{}({})",
                          1};
constexpr Language c{
    Notation::c,
    "// {}",
    "const double {}[] = {{{}}};\n",
    "NAN",
    "\nstatic void {}(const double *p, double t, const double *state, const double *inputs, const double "
    "*sides,\n                 double *value) {{ /* {} */\n  (void)p, (void)t, (void)state, "
    "(void)inputs, (void)sides, (void)value;\n",
    "}\n",
    "  const double {} = {};\n",
    "  value[{}] = {};\n",
    "{}[{}]",
    0};

using Eigen::Index;

template <class... Parts>
std::string put(std::string_view format, const Parts&... parts) {
  return fmt::format(fmt::runtime(format), parts...);
}

std::string in_program(double value, std::string_view nan) {
  return std::isfinite(value) ? fmt::format("{}", value) : std::string(nan);
}

template <class Numbers>
std::string listed(const Numbers& numbers, std::string_view nan) {
  std::vector<std::string> texts;
  for (const double number : numbers) texts.push_back(in_program(number, nan));
  return fmt::format("{}", fmt::join(texts, ", "));
}

std::string function_of(const ExportedEquation& equation, const Language& language, const std::string& name,
                        const std::vector<ident::Tree>& trees, const std::vector<std::string>& values) {
  std::string text = put(language.begin, name, values.size());
  const auto local = [&](const std::string& signal, const char* of, std::size_t i) {
    if (looks_at(equation, trees, signal))
      text += put(language.local, signal, put(language.element, of, static_cast<int>(i) + language.first));
  };
  for (std::size_t i = 0; i < equation.states.size(); ++i) local(equation.states[i], "state", i);
  for (std::size_t i = 0; i < equation.inputs.size(); ++i) local(program_name(equation.inputs[i]), "inputs", i);
  for (std::size_t i = 0; i < equation.switches.size(); ++i) local(fmt::format("s{}", i + 1), "sides", i);
  for (const auto& derived : equation.derived)
    if (looks_at(equation, trees, derived.name))
      text += put(language.local, derived.name, ident::print_tree(*derived.value, language.notation));
  for (std::size_t i = 0; i < values.size(); ++i)
    text += put(language.result, static_cast<int>(i) + language.first, values[i]);
  return text + std::string(language.end);
}

/// rates, switches, slopes, displacements.
std::string functions(const ExportedEquation& equation, const Language& language) {
  const auto of_trees = [&](const std::string& name, const std::vector<ident::Tree>& trees) {
    std::vector<std::string> values;
    for (const ident::Tree& tree : trees)
      values.push_back(tree == nullptr ? std::string(language.nan) : ident::print_tree(*tree, language.notation));
    return function_of(equation, language, name, trees, values);
  };
  std::vector<ident::Tree> rates = equation.terms, slopes, displacements;
  std::vector<std::string> of_states;
  for (std::size_t state = 0; state < equation.states.size(); ++state) {
    const auto model = std::find(equation.driven.begin(), equation.driven.end(), state) - equation.driven.begin();
    const bool is_driven = model < std::ssize(equation.driven);
    if (!is_driven) rates.push_back(ident::signal_node(equation.states[state + 1]));
    of_states.push_back(is_driven ? sum_of_terms(equation, static_cast<std::size_t>(model), language.notation,
                                                 language.element, language.first)
                                  : equation.states[state + 1]);
  }
  for (const std::vector<ident::Tree>& one : equation.slopes) slopes.insert(slopes.end(), one.begin(), one.end());
  for (const std::string& name : equation.displacements) displacements.push_back(ident::signal_node(name));
  return function_of(equation, language, "rates", rates, of_states) + of_trees("switches", equation.switch_values) +
         of_trees("slopes", slopes) + of_trees("displacements", displacements);
}

std::string constants(const ExportedEquation& equation, const Language& language, bool upper) {
  std::vector<double> parameters, deviations, covariance;
  for (std::size_t i = 0; i < equation.terms.size(); ++i)
    parameters.push_back(equation.parameter(i).mean), deviations.push_back(equation.parameter(i).std);
  const Eigen::MatrixXd& matrix = equation.covariance;
  for (Index i = 0; i < matrix.rows(); ++i)
    for (Index j = 0; j < matrix.cols(); ++j) covariance.push_back(matrix(i, j));
  const std::vector<double> run{equation.run ? equation.run->start_s : 0.0, equation.run ? equation.run->rate_hz : 0.0,
                                equation.run ? ExportedRun::steps_per_sample : 0.0};
  std::string text;
  const auto add = [&](std::string name, const auto& numbers, const char* what) {
    if (upper) std::transform(name.begin(), name.end(), name.begin(), [](char one) { return std::toupper(one); });
    text += put(language.comment, what) + "\n" + put(language.list, name, listed(numbers, language.nan));
  };
  std::vector<double> driven;  // by 1, which no language counts from elsewhere
  for (std::size_t state = 0; state < equation.states.size(); ++state)
    driven.push_back(std::find(equation.driven.begin(), equation.driven.end(), state) != equation.driven.end() ? 1.0
                                                                                                               : 0.0);
  add("parameters", parameters, "coefficients");
  add("deviations", deviations, "their standard deviations");
  add("covariance", covariance, "their covariance, row by row");
  add("driven", driven, "of each state: 1 where it has an equation, 0 where the next is its rate");
  add("begin", equation.start(), "the state at the start of the free run");
  add("run", run, "the free run: start (s), rows (Hz), rows from one x to the next");
  return text;
}

std::string header(const ExportedEquation& equation, std::string_view comment, int first) {
  std::string text;
  for (const std::string& line : described(equation, first)) text += put(comment, line) + "\n";
  return text;
}

}  // namespace

std::string printed_python(const ExportedEquation& equation) {
  return header(equation, python.comment, python.first) +
         fmt::format(
             "# python3 equation.py compares it with free_run.csv; it needs numpy and scipy.\nimport os\nimport "
             "sys\n\nimport numpy as np\nfrom scipy.integrate import solve_ivp\n\nNUM_STATES, NUM_INPUTS, "
             "NUM_SWITCHES = {}, {}, {}\n",
             equation.states.size(), equation.inputs.size(), equation.switches.size()) +
         constants(equation, python, true) + functions(equation, python) + std::string(python_free_run());
}

std::string printed_matlab(const ExportedEquation& equation) {
  return "function result = equation(rows, rate_hz, state, start_s, every, p)\n" +
         header(equation, matlab.comment, matlab.first) +
         "% equation() compares it with free_run.csv; else x of its free run with these inputs, see free_run below.\n"
         "  if nargin == 0, result = compare('free_run.csv'); return; end\n"
         "  if nargin < 6, p = equation_data().parameters; end\n"
         "  result = free_run(p, rows, rate_hz, state, start_s, every);\n"
         "end\n\nfunction data = equation_data()\n" +
         constants(equation, matlab, false) + "end\n" + functions(equation, matlab) + std::string(matlab_free_run());
}

std::string printed_c(const ExportedEquation& equation) {
  return header(equation, c.comment, c.first) +
         fmt::format(
             "// cc -O2 -DEQUATION_MAIN equation.c -o equation -lm && ./equation\n#include <math.h>\n#include "
             "<stdio.h>\n#include <stdlib.h>\n#include <string.h>\n\nenum {{ NUM_PARAMETERS = {}, NUM_STATES = {}, "
             "NUM_INPUTS = {}, NUM_SWITCHES = {}, NUM_X = {} }};\n",
             equation.terms.size(), equation.states.size(), equation.inputs.size(), equation.switches.size(),
             equation.displacements.size()) +
         constants(equation, c, false) + functions(equation, c) + std::string(c_free_run());
}

std::string printed_run(const ExportedEquation& equation, const ExportedRun& run) {
  RowWriter cells;
  for (Index i = 0; i < run.inputs.rows(); ++i) {
    cells.number(run.start_s + static_cast<double>(i) / run.rate_hz);
    for (Index k = 0; k < run.inputs.cols(); ++k) cells.number(run.inputs(i, k));
    const bool has_x = i % ExportedRun::steps_per_sample == 0;
    for (Index k = 0; k < run.x.cols(); ++k)
      has_x ? cells.number(run.x(i / ExportedRun::steps_per_sample, k)) : cells.empty();
    cells.end_row();
  }
  std::string head = "t";
  for (const std::string& input : equation.inputs) head += "," + input;
  for (const std::string& name : equation.displacements) head += "," + name;
  return head + "\n" + cells.rows();
}

}  // namespace apps
