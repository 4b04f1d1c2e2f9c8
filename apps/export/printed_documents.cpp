// Documents and models that are not run here: LaTeX, JSON, Modelica; and what all of them say of an equation.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "apps/export/printed_equation.hpp"
#include "apps/output/report_text.hpp"
#include "apps/page/equation_display.hpp"
#include "apps/process/printable.hpp"
#include "apps/process/version.hpp"
#include "apps/text/json_number.hpp"
#include "apps/text/json_parts.hpp"
#include "apps/text/rounded.hpp"
#include "ident/library/expression.hpp"

namespace apps {

using ident::Notation;
using Json = nlohmann::ordered_json;

std::vector<std::string> described(const ExportedEquation& equation, int first) {
  std::vector<std::string> lines{fmt::format("{} of motion identified by Ardent {}, {}.",
                                             equation.models.size() == 1 ? "Equation" : "Equations", version(),
                                             origin_of(equation))};
  for (const ident::Model& model : equation.models) lines.push_back(ident::to_text(model));
  lines.push_back("SI units. " + equation.coordinates_sentence);
  if (!equation.recording.empty()) lines.push_back("Recording: " + equation.recording);
  if (!equation.no_run.empty()) lines.push_back("No free run to compare with: " + equation.no_run);
  std::size_t number = 0;
  for (const ident::Model& model : equation.models)
    for (const ident::ModelTerm& term : model.terms)
      lines.push_back(fmt::format("p {}: coefficient of {}{}, {}{}", static_cast<int>(number++) + first, term.name,
                                  equation.models.size() == 1 ? "" : " in " + model.target,
                                  with_uncertainty(term.mean, term.std), (term.unit.empty() ? "" : " ") + term.unit));
  for (std::size_t i = 0; i < equation.states.size(); ++i)
    lines.push_back(fmt::format("state {}: {}, {}", static_cast<int>(i) + first, equation.states[i],
                                meaning_of(equation, equation.states[i])));
  for (std::size_t i = 0; i < equation.inputs.size(); ++i)
    lines.push_back(fmt::format("input {}: {}, {}", static_cast<int>(i) + first, equation.inputs[i],
                                meaning_of(equation, equation.inputs[i])));
  for (std::size_t i = 0; i < equation.switches.size(); ++i)
    lines.push_back(fmt::format("side {}: sgn({})", static_cast<int>(i) + first, equation.switches[i]));
  for (std::string& line : lines) {
    line = printable(line, 1000);
    std::replace(line.begin(), line.end(), '\\', '/');
  }
  return lines;
}

bool looks_at(const ExportedEquation& equation, const std::vector<ident::Tree>& trees, const std::string& name) {
  bool found = false;
  for (const ident::Tree& tree : trees) {
    if (tree == nullptr) continue;
    ident::for_each_node(tree, [&](const ident::Node& node) {
      if (node.operation != ident::Operation::signal) return;
      found = found || node.name == name;
      for (const auto& derived : equation.derived)
        if (derived.name == node.name) found = found || looks_at(equation, {derived.value}, name);
    });
  }
  return found;
}

std::string sum_of_terms(const ExportedEquation& equation, std::size_t model, Notation notation,
                         std::string_view element, int first) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < model; ++i) begin += equation.models[i].terms.size();
  for (std::size_t i = begin; i < begin + equation.models[model].terms.size(); ++i)
    parts.push_back(fmt::format(fmt::runtime(element), "p", static_cast<int>(i) + first) + "*" +
                    ident::print_factor(*equation.terms[i], notation));
  return parts.empty() ? "0.0" : fmt::format("{}", fmt::join(parts, " + "));
}

std::string printed_latex(const ExportedEquation& equation) {
  std::string text, rows;
  std::vector<std::string> equations;
  for (const std::string& line : described(equation, 1)) text += "% " + line + "\n";
  for (const ident::Model& model : equation.models) equations.push_back(displayed_equation(model, Notation::latex));
  for (std::size_t i = 0; i < equation.terms.size(); ++i) {
    const ident::ModelTerm& term = equation.parameter(i);
    rows += fmt::format("  ${}$ & \\verb|{}| & \\verb|{}| \\\\\n", ident::Expression(term.name).print(Notation::latex),
                        with_uncertainty(term.mean, term.std), term.unit.empty() ? "-" : term.unit);
  }
  return text +
         fmt::format(
             "\\documentclass{{article}}\n\\usepackage{{amsmath}}\n\\begin{{document}}\n\\begin{{equation}}\n  {}\n"
             "\\end{{equation}}\n\\begin{{tabular}}{{lll}}\n  term & coefficient & unit \\\\ "
             "\\hline\n{}\\end{{tabular}}\n"
             "\\end{{document}}\n",
             equations.size() == 1
                 ? equations.front()
                 : fmt::format("\\begin{{gathered}}\n  {}\n  \\end{{gathered}}", fmt::join(equations, " \\\\\n  ")),
             rows);
}

namespace {

Json model_json(const ident::Model& model) {
  return {{"target", model.target},
          {"target_unit", model.target_unit},
          {"text", ident::to_text(model)},
          {"latex", displayed_equation(model, Notation::latex)}};
}

}  // namespace

std::string printed_json(const ExportedEquation& equation) {
  Json document{{"program", "Ardent " + version()},
                {"range", printable(equation.range)},
                {"method", equation.method},
                {"verdict", equation.verdict},
                {"recording", printable(equation.recording)}};
  const bool are_several = equation.models.size() > 1;
  if (are_several)
    for (const ident::Model& model : equation.models) document["equations"].push_back(model_json(model));
  else
    document.update(model_json(equation.models.front()));
  document.update(Json{{"states", equation.states},
                       {"inputs", Json::array()},
                       {"switches", equation.switches},
                       {"parameters", Json::array()},
                       {"covariance", Json::array()},
                       {"coordinates", coordinates_json(equation.coordinates)},
                       {"extents", Json::object()}});
  for (const std::string& input : equation.inputs)
    document["inputs"].push_back({{"name", printable(input)}, {"meaning", meaning_of(equation, input)}});
  for (const ident::Model& model : equation.models)
    for (const ident::ModelTerm& term : model.terms) {
      Json one{{"term", term.name}, {"mean", term.mean}, {"std", number_or_null(term.std)}, {"unit", term.unit}};
      if (are_several) one["target"] = model.target;
      document["parameters"].push_back(std::move(one));
    }
  for (Eigen::Index i = 0; i < equation.covariance.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index j = 0; j < equation.covariance.cols(); ++j)
      row.push_back(number_or_null(equation.covariance(i, j)));
    document["covariance"].push_back(std::move(row));
  }
  for (const ident::Extent& extent : equation.models.front().extents)
    document["extents"][extent.signal] = {extent.lowest, extent.highest};
  if (equation.run) {
    Json& run = document["free_run"] = {{"start_s", equation.run->start_s}, {"rate_hz", equation.run->rate_hz}};
    for (std::size_t i = 0; i < equation.states.size(); ++i) run[equation.states[i]] = equation.run->state[i];
    run["file"] = "free_run.csv";
  }
  return text_of(document);
}

namespace {

/// Each line "name = value" as a line of a model.
std::string in_model(const std::string& text, const char* indent, const char* equals) {
  std::string result;
  for (std::size_t begin = 0, end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
    std::string line = text.substr(begin, end - begin);
    result += indent + line.replace(line.find(" = "), 3, equals) + "\n";
  }
  return result;
}

bool is_number(const ident::Tree& tree, double value) {
  return tree->operation == ident::Operation::number && tree->value == value;
}

/// Calls of the functions that give the rates of the driven states.
class ModelicaRates {
 public:
  ModelicaRates(const ExportedEquation& equation, std::vector<std::string> arguments)
      : equation_(equation), arguments_(std::move(arguments)) {}

  [[nodiscard]] std::string function_name(std::size_t model) const {
    return equation_.models.size() == 1 ? "acceleration" : "rate_of_" + equation_.states[equation_.driven[model]];
  }
  /// With switch `which` (from 1; 0: none) on this side, the others as they are.
  [[nodiscard]] std::string call(std::size_t model, std::size_t which, const char* side) const {
    std::vector<std::string> given = arguments_;
    for (std::size_t k = 1; k <= equation_.switches.size(); ++k)
      given.push_back(k == which ? side : fmt::format("s{}", k));
    return fmt::format("{}({})", function_name(model), fmt::join(given, ", "));
  }
  /// d(g)/dt of switch `k`, from 0, it being on this side; none: as it is.
  [[nodiscard]] std::string pace(std::size_t k, const char* side) const {
    const std::vector<ident::Tree>& slopes = equation_.slopes[k];
    std::vector<std::string> parts;
    for (std::size_t state = 0; state < equation_.states.size(); ++state) {
      if (is_number(slopes[state], 0.0)) continue;
      const auto model = std::find(equation_.driven.begin(), equation_.driven.end(), state) - equation_.driven.begin();
      const std::string rate = model == std::ssize(equation_.driven) ? equation_.states[state + 1]
                               : side == nullptr                     ? fmt::format("der({})", equation_.states[state])
                                                 : call(static_cast<std::size_t>(model), k + 1, side);
      parts.push_back(
          is_number(slopes[state], 1.0) ? rate : ident::print_factor(*slopes[state], Notation::modelica) + "*" + rate);
    }
    if (slopes.back() != nullptr && !is_number(slopes.back(), 0.0))
      parts.push_back(ident::print_factor(*slopes.back(), Notation::modelica));
    return fmt::format("{}", fmt::join(parts, " + "));
  }

 private:
  const ExportedEquation& equation_;
  std::vector<std::string> arguments_;
};

/// Every switch on a side, or held where no side leads away, its side in between then being what keeps it at zero.
struct ModelicaSwitches {
  std::string variables, equations, initial;
};

ModelicaSwitches modelica_switches(const ExportedEquation& equation, const ModelicaRates& rates) {
  ModelicaSwitches found;
  for (std::size_t k = 0; k < equation.switches.size(); ++k) {
    const std::string g = ident::print_tree(*equation.switch_values[k], Notation::modelica);
    found.initial += fmt::format("  side{0} = if g{0} < 0 then -1 else 1;\n", k + 1);
    found.variables += fmt::format("  Real g{0} \"{1}\", s{0};\n  Integer side{0}(start = 1) \"of {1}; 0: held\";\n",
                                   k + 1, equation.switches[k]);
    if (equation.slopes[k].back() == nullptr) {
      found.equations += fmt::format(
          "  g{0} = {1};\n  s{0} = side{0};\n  when g{0} < 0 then\n    side{0} = -1;\n  elsewhen g{0} > 0 then\n"
          "    side{0} = 1;\n  end when;\n",
          k + 1, g);
      continue;
    }
    found.variables += fmt::format("  Real above{0}, below{0};\n", k + 1);
    found.equations += fmt::format(
        "  g{0} = {1};\n  above{0} = {2};\n  below{0} = {3};\n"
        "  0 = if side{0} == 0 then {4} else s{0} - side{0};\n"
        "  when (g{0} < 0 and pre(side{0}) > 0) or (g{0} > 0 and pre(side{0}) < 0) then\n"
        "    side{0} = if above{0} <= 0 and below{0} >= 0 then 0 else -pre(side{0});\n"
        "  elsewhen pre(side{0}) == 0 and s{0} > 1 then\n    side{0} = 1;\n"
        "  elsewhen pre(side{0}) == 0 and s{0} < -1 then\n    side{0} = -1;\n  end when;\n",
        k + 1, g, rates.pace(k, "1.0"), rates.pace(k, "-1.0"), rates.pace(k, nullptr));
  }
  return found;
}

}  // namespace

std::string printed_modelica(const ExportedEquation& equation) {
  const std::size_t num_switches = equation.switches.size();
  std::vector<std::string> names{"p", "time"}, coefficients;
  names.insert(names.end(), equation.states.begin(), equation.states.end());
  std::string comment, inputs, arguments, derived, formulas, functions, states, rates;
  for (const std::string& line : described(equation, 1)) comment += "// " + line + "\n";
  for (const std::string& input : equation.inputs) {
    names.push_back(program_name(input));
    inputs += fmt::format("  input Real {} \"{}\";\n", program_name(input), meaning_of(equation, input));
  }
  for (std::size_t i = 2; i < names.size(); ++i) arguments += fmt::format("    input Real {};\n", names[i]);
  for (std::size_t k = 1; k <= num_switches; ++k) arguments += fmt::format("    input Real s{};\n", k);
  for (std::size_t i = 0; i < equation.terms.size(); ++i)
    coefficients.push_back(fmt::format("{}", equation.parameter(i).mean));
  for (const auto& one : equation.derived) {
    derived += fmt::format("    Real {};\n", one.name);
    formulas += fmt::format("{} = {};\n", one.name, ident::print_tree(*one.value, Notation::modelica));
  }
  const ModelicaRates of_states(equation, names);
  for (std::size_t i = 0; i < equation.models.size(); ++i)
    functions += fmt::format(
        "  function {name}\n    input Real p[{n}];\n    input Real t;\n{arguments}    output Real value;\n"
        "{protect}{derived}  algorithm\n{assignments}    value := {sum};\n  end {name};\n",
        fmt::arg("name", of_states.function_name(i)), fmt::arg("n", coefficients.size()),
        fmt::arg("arguments", arguments), fmt::arg("protect", derived.empty() ? "" : "  protected\n"),
        fmt::arg("derived", derived), fmt::arg("assignments", in_model(formulas, "    ", " := ")),
        fmt::arg("sum", sum_of_terms(equation, i, Notation::modelica, "{}[{}]", 1)));
  const std::vector<double> start = equation.start();
  for (std::size_t state = 0; state < equation.states.size(); ++state) {
    const auto model = std::find(equation.driven.begin(), equation.driven.end(), state) - equation.driven.begin();
    states += fmt::format("  Real {}(start = {}, fixed = true);\n", equation.states[state], start[state]);
    rates += fmt::format("  der({}) = {};\n", equation.states[state],
                         model == std::ssize(equation.driven) ? equation.states[state + 1]
                                                              : of_states.call(static_cast<std::size_t>(model), 0, ""));
  }
  const ModelicaSwitches switches = modelica_switches(equation, of_states);
  return fmt::format(
      "{comment}model Equation\n{functions}  parameter Real p[{n}] = {{{coefficients}}};\n{inputs}{states}"
      "{derived}{variables}initial equation\n{initial}equation\n{definitions}{equations}{rates}end Equation;\n",
      fmt::arg("comment", comment), fmt::arg("functions", functions), fmt::arg("n", coefficients.size()),
      fmt::arg("coefficients", fmt::join(coefficients, ", ")), fmt::arg("inputs", inputs), fmt::arg("states", states),
      fmt::arg("derived", derived), fmt::arg("variables", switches.variables), fmt::arg("initial", switches.initial),
      fmt::arg("definitions", in_model(formulas, "  ", " = ")), fmt::arg("equations", switches.equations),
      fmt::arg("rates", rates));
}

}  // namespace apps
