#include "apps/export/exported_equation.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "apps/export/prepared_rows.hpp"
#include "apps/output/equation_file.hpp"
#include "apps/output/report_text.hpp"
#include "apps/output/run_json.hpp"
#include "dsp/values/fault.hpp"
#include "dsp/values/signals.hpp"
#include "ident/equation/equation_of_motion.hpp"
#include "ident/library/expression_derivative.hpp"
#include "ident/library/expression_parser.hpp"
#include "ident/records/record.hpp"
#include "ident/validate/free_run.hpp"
#include "sim/ode/friction.hpp"

namespace apps {
namespace {

using Json = nlohmann::ordered_json;
using Eigen::Index;
namespace fs = std::filesystem;

ident::Tree tree_of(const std::string& text) {
  return ident::parse_expression(
      text, [](std::string_view) { return true; }, "");
}

/// The same with the signal s<k> for sgn of switch k.
ident::Tree with_sides(const ident::Tree& tree, const std::vector<std::string>& switches) {
  if (tree == nullptr) return nullptr;
  if (tree->operation == ident::Operation::call && tree->function == ident::Function::sgn) {
    for (std::size_t k = 0; k < switches.size(); ++k)
      if (ident::identical(*tree_of(switches[k]), *tree->left)) return ident::signal_node(fmt::format("s{}", k + 1));
  }
  ident::Node node = *tree;
  if (node.operation == ident::Operation::signal) node.name = program_name(node.name);
  node.left = with_sides(tree->left, switches);
  node.right = with_sides(tree->right, switches);
  return std::make_shared<const ident::Node>(std::move(node));
}

/// A stretch of a recording (1-based) that the verdict's free run ran through.
struct Stretch {
  std::size_t recording = 0;
  double from_s = 0.0, to_s = 0.0;
};

/// The longest; its recording is 0 where nothing was run.
Stretch longest_run(const Json& metrics, const std::string& range, const std::string& method) {
  Stretch longest;
  for (const Json& one : metrics.at("ranges"))
    for (const Json& fit : one.at("methods"))
      if (one.at("name") == range && fit.at("method") == method)
        for (const Json& run : fit.value("free_runs", Json::array()))
          if (const double from = run.at("from_s"), to = run.at("to_s"); to - from > longest.to_s - longest.from_s)
            longest = {run.at("recording"), from, to};
  return longest;
}

/// "x", 2 of "x2"; 0 for no such name.
std::pair<char, int> of_body(const std::string& signal) {
  int body = 0;
  const char *begin = signal.data() + 1, *end = signal.data() + signal.size();
  if (signal.size() < 2 || (signal[0] != 'x' && signal[0] != 'v') || std::from_chars(begin, end, body).ptr != end)
    return {};
  return {signal[0], body};
}

/// Compiled as the free run compiles it. Without a motion: every signal may be an input.
ident::EquationOfMotion compiled(const ident::Model& model, bool base_moves, const dsp::Motion& motion) {
  ident::StateEquation row{.state = 1, .terms = {}, .coefficients = {}};
  ident::EquationFrame frame;
  for (const dsp::Signal& signal : motion.signals) frame.inputs.push_back(signal.name);
  for (const ident::ModelTerm& term : model.terms) {
    row.terms.push_back(term.name);
    row.coefficients.push_back(term.mean);
    const ident::Expression expression(term.name);
    for (const std::string& name : expression.signals())
      if (motion.signals.empty()) frame.inputs.push_back(name);
  }
  if (motion.signals.empty()) frame.inputs.insert(frame.inputs.end(), {"r", "dr", "ddr"});
  if (model.target == "ddy") frame.states = {"y", "dy"};
  frame.base_moves = base_moves;
  if (const dsp::Signal* y = motion.find("y")) {
    Eigen::VectorXd offset = y->values - motion.at("x");
    if (base_moves) offset -= motion.at("r");
    frame.offset_m = offset.mean();
  }
  return {{std::move(row)}, std::move(frame)};
}

void describe(const ident::EquationOfMotion& equation, ExportedEquation& result) {
  const ident::EquationFrame& frame = equation.frame();
  result.states = frame.states;
  result.driven = {1};
  result.displacements = {"x"};
  result.inputs = equation.inputs();
  result.switches = equation.switches();
  const bool relative = frame.states[0] == "x";
  const auto looks_at = [&](const std::string& name) {
    return std::find(equation.signals().begin(), equation.signals().end(), name) != equation.signals().end();
  };
  const auto add = [&](const char* name, const char* state, const char* base, double offset) {
    std::string text = state;
    if (frame.base_moves) {
      text += fmt::format("{}{}", relative ? '+' : '-', base);
      if (std::find(result.inputs.begin(), result.inputs.end(), base) == result.inputs.end())
        result.inputs.emplace_back(base);
    }
    if (offset != 0.0) text += fmt::format("{}{}", (offset > 0.0) == relative ? '+' : '-', std::abs(offset));
    result.derived.push_back({name, tree_of(text)});
  };
  if (!relative || looks_at("y")) add(relative ? "y" : "x", relative ? "x" : "y", "r", frame.offset_m);
  if (looks_at(relative ? "dy" : "v")) add(relative ? "dy" : "v", relative ? "v" : "dy", "dr", 0.0);
  std::vector<unsigned char> can_hold;
  for (std::size_t k = 0; k < result.switches.size(); ++k) can_hold.push_back(equation.can_hold(k) ? 1 : 0);
  describe_terms(result, can_hold);
}

/// Integrates it again, from the measured state, in steps so small that two integrators agree.
ExportedRun run_again(const ident::Model& model, const dsp::Motion& motion, const Stretch& stretch,
                      const ExportedEquation& equation) {
  const dsp::IndexRange samples = samples_between(motion, stretch.from_s, stretch.to_s);
  const ident::Course course{
      &motion, {samples}, std::vector<unsigned char>(static_cast<std::size_t>(motion.num_samples()), 1)};
  const ident::FreeRun run =
      ident::free_run(model, {course}, {.min_periods = 0.0, .relative_tolerance = 1e-12, .keep_series = true});
  if (!run.reason.empty()) throw dsp::Fault(dsp::FaultKind::numerics, "export.free_run", run.reason);
  ExportedRun result = run_over(motion, samples, equation.inputs);
  for (const std::string& state : equation.states) result.state.push_back(motion.at(state)(samples.first));
  result.x = run.series.front().predicted.segment(samples.first, samples.last - samples.first);
  return result;
}

/// The same with every derived signal as what it is.
ident::Tree written_out(const ident::Tree& tree, const std::vector<ExportedEquation::Derived>& derived) {
  if (tree == nullptr) return nullptr;
  if (tree->operation == ident::Operation::signal)
    for (const auto& one : derived)
      if (one.name == tree->name) return one.value;
  ident::Node node = *tree;
  node.left = written_out(tree->left, derived);
  node.right = written_out(tree->right, derived);
  return std::make_shared<const ident::Node>(std::move(node));
}

/// dg/dt by inputs and t; none where the rate of an input is no input.
ident::Tree pace_by_inputs(ExportedEquation& equation, const ident::Tree& g) {
  ident::NormalForm pace = ident::derivative(g, "t");
  std::vector<std::string> looked_at;
  ident::for_each_node(g, [&](const ident::Node& node) {
    if (node.operation == ident::Operation::signal) looked_at.push_back(node.name);
  });
  for (const std::string& signal : looked_at) {
    const ident::NormalForm slope = ident::derivative(g, signal);
    if (signal == "t" || slope.number() == 0.0 ||
        std::find(equation.states.begin(), equation.states.end(), signal) != equation.states.end())
      continue;
    const std::string rate = signal == "r" ? "dr" : signal == "dr" ? "ddr" : "";
    if (rate.empty()) return nullptr;
    if (std::find(equation.inputs.begin(), equation.inputs.end(), rate) == equation.inputs.end())
      equation.inputs.push_back(rate);
    pace = pace + slope * ident::NormalForm::signal(rate);
  }
  return pace.tree();
}

}  // namespace

void describe_terms(ExportedEquation& equation, const std::vector<unsigned char>& can_hold) {
  if (equation.switches.size() > sim::max_switches)
    throw dsp::Fault(dsp::FaultKind::usage, "export.equation",
                     fmt::format("the equation has {} switches; at most {} can be exported", equation.switches.size(),
                                 sim::max_switches));
  for (const ident::Model& model : equation.models)
    for (const ident::ModelTerm& term : model.terms)
      equation.terms.push_back(with_sides(tree_of(term.name), equation.switches));
  for (std::size_t k = 0; k < equation.switches.size(); ++k) {
    equation.switch_values.push_back(with_sides(tree_of(equation.switches[k]), {}));
    const ident::Tree g = written_out(equation.switch_values.back(), equation.derived);
    std::vector<ident::Tree>& slopes = equation.slopes.emplace_back();
    for (const std::string& state : equation.states) slopes.push_back(ident::derivative(g, state).tree());
    slopes.push_back(can_hold[k] != 0 ? pace_by_inputs(equation, g) : nullptr);
  }
}

const ident::ModelTerm& ExportedEquation::parameter(std::size_t i) const& {
  for (const ident::Model& model : models) {
    if (i < model.terms.size()) return model.terms[i];
    i -= model.terms.size();
  }
  throw std::out_of_range("ExportedEquation::parameter");
}

std::vector<double> ExportedEquation::start() const {
  return run ? run->state : std::vector<double>(states.size(), 0.0);
}

std::string program_name(const std::string& signal) {
  const auto [letter, body] = of_body(signal);
  return body > 0 || dsp::find_signal(signal) != nullptr ? signal : "u_" + signal;
}

std::string meaning_of(const ExportedEquation& equation, const std::string& signal) {
  const auto [letter, body] = of_body(signal);
  const dsp::SignalInfo* info = dsp::find_signal(body > 0 ? std::string(1, letter) : signal);
  std::string unit(info == nullptr ? "" : info->unit);
  if (unit.starts_with("m") && info->body != dsp::Body::base) unit.replace(0, 1, equation.length);  // rad, rad/s
  std::string what = info == nullptr || info->role == dsp::Role::other ? "as recorded" : dsp::in_words(info->role);
  const bool is_state = std::find(equation.states.begin(), equation.states.end(), signal) != equation.states.end();
  if (is_state && equation.method.empty()) {  // of bodies in a row
    what = signal == "z" ? "inner state" : letter == 'v' || signal == "v" ? "velocity" : "displacement";
    if (body > 0) what += fmt::format(" of body {}", body);
    if (signal == "z") unit.clear();  // that of what it acts as
  }
  std::string text = what + (unit.empty() ? "" : ", " + unit);
  for (const ident::Extent& extent : equation.models.front().extents)
    if (extent.signal == signal) text += fmt::format("; fitted from {:.6g} to {:.6g}", extent.lowest, extent.highest);
  return text;
}

std::string origin_of(const ExportedEquation& equation) {
  if (equation.method.empty()) return equation.verdict;
  return fmt::format("range {}, method {}: {}", equation.range, equation.method, equation.verdict);
}

std::string text_of_models(const ExportedEquation& equation, const std::string& between) {
  std::vector<std::string> texts;
  for (const ident::Model& model : equation.models) texts.push_back(ident::to_text(model));
  return fmt::format("{}", fmt::join(texts, between));
}

ExportedEquation read_exported_equation(const fs::path& run, const std::string& range, const std::string& method) {
  const ident::IdentifiedEquation found = read_equation(run, range, method);
  ident::Model model = read_predicting_equation(run, found.range, found.method).model;
  if ((model.target != "a" && model.target != "ddy") || model.terms.empty())
    throw dsp::Fault(
        dsp::FaultKind::usage, "export.equation",
        fmt::format("{}: want an equation for a or ddy with at least one term, found {}", run.string(), found.text));
  ExportedEquation result{
      .range = found.range, .method = found.method, .verdict = std::string(to_string(found.verdict))};
  const bool has_rows = fs::exists(run / "prepared.csv") && fs::exists(run / "metrics.json");
  Stretch stretch;
  try {
    if (has_rows) stretch = longest_run(read_run_json(run / "metrics.json"), found.range, found.method);
  } catch (const Json::exception& error) {
    throw dsp::Fault(dsp::FaultKind::input, "run.damaged",
                     fmt::format("{}: {}", (run / "metrics.json").string(), error.what()));
  }
  dsp::Motion motion;
  if (has_rows && stretch.recording > 0) {
    PreparedRows rows = read_prepared_rows(run / "prepared.csv", stretch.recording, "x");
    motion = std::move(rows.motion);
    result.recording = rows.recording;
    for (const ident::Coordinates& one : model.coordinates) {
      if (!rows.recording.empty() && one.recording != rows.recording) continue;
      result.recording = one.recording;
      motion = ident::in_coordinates(std::move(motion), one.zero - one.prepared_zero, one.lead_s);
    }
  } else {
    result.no_run =
        has_rows ? "the run made no free run of this equation" : "the run folder has no prepared.csv (rows = false)";
  }
  int number = 0;
  for (const ident::ModelTerm& term : model.terms)
    if (term.recording > 0 && term.recording_name == result.recording) number = term.recording;
  const ident::Model own = equation_of(model, number);
  result.models = {own};
  result.covariance = own.covariance;
  result.coordinates = own.coordinates;
  result.coordinates_sentence = coordinates_sentence(own.coordinates);
  if (!own.coordinates.empty() && !own.coordinates.front().unit.empty()) result.length = own.coordinates.front().unit;
  const ident::EquationOfMotion equation =
      compiled(own, motion.signals.empty() ? found.base_measured : motion.find("r") != nullptr, motion);
  describe(equation, result);
  if (motion.signals.empty() && std::any_of(result.derived.begin(), result.derived.end(),
                                            [](const auto& one) { return one.name == "x" || one.name == "y"; }))
    throw dsp::Fault(dsp::FaultKind::usage, "export.equation",
                     fmt::format("{}: the equation looks at x and y, and how they differ is in prepared.csv alone: {}",
                                 run.string(), result.no_run));
  if (!motion.signals.empty()) result.run = run_again(own, motion, stretch, result);
  return result;
}

}  // namespace apps
