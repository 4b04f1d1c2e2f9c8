// Documents and models that are not run here: LaTeX, JSON, Modelica; and what all of them say of an equation.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "apps/export/printed_equation.hpp"
#include "apps/output/json_number.hpp"
#include "apps/output/json_parts.hpp"
#include "apps/output/report_text.hpp"
#include "apps/output/rounded.hpp"
#include "apps/page/equation_display.hpp"
#include "apps/process/printable.hpp"
#include "apps/process/version.hpp"
#include "ident/library/expression.hpp"

namespace apps {

using ident::Notation;
using Json = nlohmann::ordered_json;

std::vector<std::string> described(const ExportedEquation& equation, int first) {
  const ident::Model& model = equation.model;
  std::vector<std::string> lines{fmt::format("Equation of motion identified by Ardent {}, range {}, method {}: {}.",
                                             version(), equation.range, equation.method, equation.verdict),
                                 ident::to_text(model), "SI units. " + coordinates_sentence(model.coordinates)};
  if (!equation.recording.empty()) lines.push_back("Recording: " + equation.recording);
  if (!equation.no_run.empty()) lines.push_back("No free run to compare with: " + equation.no_run);
  for (std::size_t i = 0; i < model.terms.size(); ++i)
    lines.push_back(fmt::format("p {}: coefficient of {}, {}{}", static_cast<int>(i) + first, model.terms[i].name,
                                with_uncertainty(model.terms[i].mean, model.terms[i].std),
                                (model.terms[i].unit.empty() ? "" : " ") + model.terms[i].unit));
  for (std::size_t i = 0; i < 2; ++i)
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
  for (const ident::Tree& tree : trees)
    ident::for_each_node(tree, [&](const ident::Node& node) {
      if (node.operation != ident::Operation::signal) return;
      found = found || node.name == name;
      for (const auto& derived : equation.derived)
        if (derived.name == node.name) found = found || looks_at(equation, {derived.value}, name);
    });
  return found;
}

std::string sum_of_terms(const ExportedEquation& equation, Notation notation, std::string_view element, int first) {
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < equation.terms.size(); ++i)
    parts.push_back(fmt::format(fmt::runtime(element), "p", static_cast<int>(i) + first) + "*" +
                    ident::print_factor(*equation.terms[i], notation));
  return fmt::format("{}", fmt::join(parts, " + "));
}

std::string printed_latex(const ExportedEquation& equation) {
  std::string text, rows;
  for (const std::string& line : described(equation, 1)) text += "% " + line + "\n";
  for (const ident::ModelTerm& term : equation.model.terms)
    rows += fmt::format("  ${}$ & \\verb|{}| & \\verb|{}| \\\\\n", ident::Expression(term.name).print(Notation::latex),
                        with_uncertainty(term.mean, term.std), term.unit.empty() ? "-" : term.unit);
  return text +
         fmt::format(
             "\\documentclass{{article}}\n\\usepackage{{amsmath}}\n\\begin{{document}}\n\\begin{{equation}}\n  {}\n"
             "\\end{{equation}}\n\\begin{{tabular}}{{lll}}\n  term & coefficient & unit \\\\ "
             "\\hline\n{}\\end{{tabular}}\n"
             "\\end{{document}}\n",
             displayed_equation(equation.model, Notation::latex), rows);
}

std::string printed_json(const ExportedEquation& equation) {
  const ident::Model& model = equation.model;
  Json document{{"program", "Ardent " + version()},
                {"range", printable(equation.range)},
                {"method", equation.method},
                {"verdict", equation.verdict},
                {"recording", printable(equation.recording)},
                {"target", model.target},
                {"target_unit", model.target_unit},
                {"text", ident::to_text(model)},
                {"latex", displayed_equation(model, Notation::latex)},
                {"states", equation.states},
                {"inputs", Json::array()},
                {"switches", equation.switches},
                {"parameters", Json::array()},
                {"covariance", Json::array()},
                {"coordinates", coordinates_json(model.coordinates)},
                {"extents", Json::object()}};
  for (const std::string& input : equation.inputs)
    document["inputs"].push_back({{"name", printable(input)}, {"meaning", meaning_of(equation, input)}});
  for (std::size_t i = 0; i < model.terms.size(); ++i) {
    const ident::ModelTerm& term = model.terms[i];
    document["parameters"].push_back(
        {{"term", term.name}, {"mean", term.mean}, {"std", number_or_null(term.std)}, {"unit", term.unit}});
    Json row = Json::array();
    for (Eigen::Index j = 0; j < model.covariance.cols(); ++j)
      row.push_back(number_or_null(model.covariance(static_cast<Eigen::Index>(i), j)));
    document["covariance"].push_back(std::move(row));
  }
  for (const ident::Extent& extent : model.extents)
    document["extents"][extent.signal] = {extent.lowest, extent.highest};
  if (equation.run)
    document["free_run"] = {{"start_s", equation.run->start_s},
                            {"rate_hz", equation.run->rate_hz},
                            {equation.states[0], equation.run->position},
                            {equation.states[1], equation.run->speed},
                            {"file", "free_run.csv"}};
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

/// Every switch on a side, or held where no side leads away.
struct ModelicaSwitches {
  std::string variables, equations, initial, rate;
};

ModelicaSwitches modelica_switches(const ExportedEquation& equation, const std::vector<std::string>& names) {
  const std::size_t num_switches = equation.switches.size();
  // The acceleration with one switch on this side, the others where they are.
  const auto call = [&](std::size_t which, const char* side) {
    std::vector<std::string> given = names;
    for (std::size_t k = 1; k <= num_switches; ++k) given.push_back(k == which ? side : fmt::format("side{}", k));
    return fmt::format("acceleration({})", fmt::join(given, ", "));
  };
  ModelicaSwitches found{.rate = call(0, "")};
  for (std::size_t k = num_switches; k-- > 0;) {
    const std::string held = ident::print_tree(*equation.held[2 * k + 1], Notation::modelica);
    found.variables +=
        fmt::format("  Real g{0} \"{1}\", above{0}, below{0};\n  Integer side{0}(start = 1) \"of {1}; 0: held\";\n",
                    k + 1, equation.switches[k]);
    found.equations += fmt::format(
        "  g{0} = {1};\n  above{0} = {2} - ({4});\n  below{0} = {3} - ({4});\n"
        "  when (g{0} < 0 and pre(side{0}) > 0) or (g{0} > 0 and pre(side{0}) < 0) then\n"
        "    side{0} = if {5} and above{0} <= 0 and below{0} >= 0 then 0 else -pre(side{0});\n"
        "  elsewhen pre(side{0}) == 0 and above{0} > 0 then\n    side{0} = 1;\n"
        "  elsewhen pre(side{0}) == 0 and below{0} < 0 then\n    side{0} = -1;\n  end when;\n",
        k + 1, ident::print_tree(*equation.switch_values[k], Notation::modelica), call(k + 1, "1.0"),
        call(k + 1, "-1.0"), held, equation.can_hold[k] ? "true" : "false");
    found.rate = fmt::format("if side{} == 0 then {} else {}", k + 1, held, found.rate);
  }
  for (std::size_t k = 1; k <= num_switches; ++k)
    found.initial += fmt::format("  side{0} = if g{0} < 0 then -1 else 1;\n", k);
  return found;
}

}  // namespace

std::string printed_modelica(const ExportedEquation& equation) {
  const std::size_t num_switches = equation.switches.size();
  std::vector<std::string> names{"p", "time", equation.states[0], equation.states[1]}, coefficients;
  std::string comment, inputs, arguments, derived, formulas;
  for (const std::string& line : described(equation, 1)) comment += "// " + line + "\n";
  for (const std::string& input : equation.inputs) {
    names.push_back(program_name(input));
    inputs += fmt::format("  input Real {} \"{}\";\n", program_name(input), meaning_of(equation, input));
  }
  for (std::size_t i = 2; i < names.size(); ++i) arguments += fmt::format("    input Real {};\n", names[i]);
  for (std::size_t k = 1; k <= num_switches; ++k) arguments += fmt::format("    input Real s{};\n", k);
  for (const ident::ModelTerm& term : equation.model.terms) coefficients.push_back(fmt::format("{}", term.mean));
  for (const auto& one : equation.derived) {
    derived += fmt::format("    Real {};\n", one.name);
    formulas += fmt::format("{} = {};\n", one.name, ident::print_tree(*one.value, Notation::modelica));
  }
  const ModelicaSwitches switches = modelica_switches(equation, names);
  const double position = equation.run ? equation.run->position : 0.0, speed = equation.run ? equation.run->speed : 0.0;
  return fmt::format(
      "{comment}model Equation\n  function acceleration\n    input Real p[{n}];\n    input Real t;\n{arguments}"
      "    output Real value;\n{protect}{derived}  algorithm\n{assignments}    value := {sum};\n  end acceleration;\n"
      "  parameter Real p[{n}] = {{{coefficients}}};\n{inputs}  Real {x}(start = {x0}, fixed = true);\n"
      "  Real {v}(start = {v0}, fixed = true);\n{derived_variables}{variables}initial equation\n{initial}equation\n"
      "{definitions}{equations}  der({x}) = {v};\n  der({v}) = {rate};\nend Equation;\n",
      fmt::arg("comment", comment), fmt::arg("n", coefficients.size()), fmt::arg("arguments", arguments),
      fmt::arg("protect", derived.empty() ? "" : "  protected\n"), fmt::arg("derived", derived),
      fmt::arg("assignments", in_model(formulas, "    ", " := ")),
      fmt::arg("sum", sum_of_terms(equation, Notation::modelica, "{}[{}]", 1)),
      fmt::arg("coefficients", fmt::join(coefficients, ", ")), fmt::arg("inputs", inputs),
      fmt::arg("x", equation.states[0]), fmt::arg("v", equation.states[1]), fmt::arg("x0", position),
      fmt::arg("v0", speed), fmt::arg("derived_variables", derived), fmt::arg("variables", switches.variables),
      fmt::arg("initial", switches.initial), fmt::arg("definitions", in_model(formulas, "  ", " = ")),
      fmt::arg("equations", switches.equations), fmt::arg("rate", switches.rate));
}

}  // namespace apps
