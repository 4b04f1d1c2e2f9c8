#include "apps/export/exported_equation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/output/equation_file.hpp"
#include "apps/output/run_json.hpp"
#include "dsp/fault.hpp"
#include "dsp/io/table_cells.hpp"
#include "dsp/signals.hpp"
#include "ident/equation/equation_of_motion.hpp"
#include "ident/library/expression_parser.hpp"
#include "ident/sensors/sensor_parameters.hpp"
#include "ident/validate/free_run.hpp"
#include "ident/validate/interpolant.hpp"
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

/// The signals of one recording of prepared.csv, and its name there; of the only one none.
struct PreparedRows {
  std::string recording;
  dsp::Motion motion;
};

PreparedRows read_rows(const fs::path& file, std::size_t recording) {
  const std::string text = read_run_file(file);
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;
  PreparedRows result;
  std::size_t number = 0;
  std::string last_name, name;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    dsp::Fields fields(std::string_view(text).substr(begin, end - begin), ',');
    begin = end + 1;
    std::string_view field;
    if (names.empty()) {
      while (fields.next(field)) names.emplace_back(dsp::unquoted(field));
      columns.resize(names.size());
      continue;
    }
    std::vector<double> row;
    while (fields.next(field)) {
      double value = std::nan("");
      if (names[row.size() % names.size()] == "recording")
        name = dsp::unquoted(field);
      else
        (void)dsp::parse_cell(field, false, value);
      row.push_back(value);
    }
    if (row.size() != names.size())
      throw dsp::Fault(dsp::FaultKind::input, "run.damaged", fmt::format("{}: rows of unequal length", file.string()));
    if (number == 0 || name != last_name) ++number, last_name = name;
    if (number != recording) continue;
    result.recording = name;
    for (std::size_t c = 0; c < row.size(); ++c) columns[c].push_back(row[c]);
  }
  for (std::size_t c = 0; c < names.size(); ++c)
    if (names[c] != "recording")
      result.motion.signals.push_back(
          {names[c], "", Eigen::Map<const Eigen::VectorXd>(columns[c].data(), std::ssize(columns[c]))});
  const dsp::Signal* t = result.motion.find("t");
  const Index n = result.motion.num_samples();
  if (t == nullptr || result.motion.find("x") == nullptr || n < 2 || !(t->values(n - 1) > t->values(0)))
    throw dsp::Fault(dsp::FaultKind::input, "run.damaged",
                     fmt::format("{}: want columns t and x of the recording that was run", file.string()));
  result.motion.sample_rate_hz = static_cast<double>(n - 1) / (t->values(n - 1) - t->values(0));
  return result;
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
  result.inputs = equation.inputs();
  result.switches = equation.switches();
  if (result.switches.size() > sim::max_switches)
    throw dsp::Fault(dsp::FaultKind::usage, "export.equation",
                     fmt::format("the equation has {} switches; at most {} can be exported", result.switches.size(),
                                 sim::max_switches));
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
  for (const ident::ModelTerm& term : result.model.terms)
    result.terms.push_back(with_sides(tree_of(term.name), result.switches));
  for (std::size_t k = 0; k < result.switches.size(); ++k) {
    const bool other = frame.base_moves && result.switches[k] == (relative ? "dy" : "v");
    result.switch_values.push_back(with_sides(tree_of(result.switches[k]), {}));
    result.can_hold.push_back(equation.can_hold(k) ? 1 : 0);
    for (const char* base : {"dr", "ddr"})
      result.held.push_back(tree_of(other ? (relative ? "-" : "") + std::string(base) : "0"));
  }
}

/// Integrates it again, from the measured state, in steps so small that two integrators agree.
ExportedRun run_again(const ident::Model& model, const dsp::Motion& motion, const Stretch& stretch,
                      const ExportedEquation& equation) {
  const auto first = static_cast<Index>(std::llround(stretch.from_s * motion.sample_rate_hz));
  const auto last = static_cast<Index>(std::llround(stretch.to_s * motion.sample_rate_hz));
  const Index n = motion.num_samples();
  if (first < 0 || last > n || last - first < 2)
    throw dsp::Fault(dsp::FaultKind::input, "run.damaged", "prepared.csv: the free run is outside of it");
  ident::Course course{&motion, {{first, last}}, std::vector<unsigned char>(static_cast<std::size_t>(n), 1)};
  const ident::FreeRun run =
      ident::free_run(model, {course}, {.min_periods = 0.0, .relative_tolerance = 1e-12, .keep_series = true});
  if (!run.reason.empty()) throw dsp::Fault(dsp::FaultKind::numerics, "export.free_run", run.reason);
  ExportedRun result{
      .start_s = static_cast<double>(first) / motion.sample_rate_hz,
      .rate_hz = ExportedRun::steps_per_sample * motion.sample_rate_hz,
      .position = motion.at(equation.states[0])(first),
      .speed = motion.at(equation.states[1])(first),
      .inputs = Eigen::MatrixXd((last - first - 1) * ExportedRun::steps_per_sample + 1, std::ssize(equation.inputs)),
      .x = run.series.front().predicted.segment(first, last - first)};
  for (Index c = 0; c < result.inputs.cols(); ++c) {
    const ident::Interpolant input(motion.at(equation.inputs[static_cast<std::size_t>(c)]), motion.sample_rate_hz,
                                   first, last);
    for (Index i = 0; i < result.inputs.rows(); ++i)
      result.inputs(i, c) = input.at(result.start_s + static_cast<double>(i) / result.rate_hz);
  }
  return result;
}

}  // namespace

std::string program_name(const std::string& signal) {
  return dsp::find_signal(signal) == nullptr ? "u_" + signal : signal;
}

std::string meaning_of(const ExportedEquation& equation, const std::string& signal) {
  const dsp::SignalInfo* info = dsp::find_signal(signal);
  std::string unit(info == nullptr ? "" : info->unit);
  const auto& coordinates = equation.model.coordinates;
  if (unit.starts_with("m") && info->body != dsp::Body::base && !coordinates.empty() &&
      !coordinates.front().unit.empty())  // of an angle: rad, rad/s
    unit.replace(0, 1, coordinates.front().unit);
  std::string text = info == nullptr || info->role == dsp::Role::other
                         ? std::string("as recorded")
                         : fmt::format("{}{}{}", dsp::in_words(info->role), unit.empty() ? "" : ", ", unit);
  for (const ident::Extent& extent : equation.model.extents)
    if (extent.signal == signal) text += fmt::format("; fitted from {:.6g} to {:.6g}", extent.lowest, extent.highest);
  return text;
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
    PreparedRows rows = read_rows(run / "prepared.csv", stretch.recording);
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
  result.model = equation_of(model, number);
  const ident::EquationOfMotion equation =
      compiled(result.model, motion.signals.empty() ? found.base_measured : motion.find("r") != nullptr, motion);
  describe(equation, result);
  if (motion.signals.empty() && std::any_of(result.derived.begin(), result.derived.end(),
                                            [](const auto& one) { return one.name == "x" || one.name == "y"; }))
    throw dsp::Fault(dsp::FaultKind::usage, "export.equation",
                     fmt::format("{}: the equation looks at x and y, and how they differ is in prepared.csv alone: {}",
                                 run.string(), result.no_run));
  if (!motion.signals.empty()) result.run = run_again(result.model, motion, stretch, result);
  return result;
}

}  // namespace apps
