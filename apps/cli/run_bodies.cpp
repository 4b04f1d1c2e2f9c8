#include "apps/cli/run_bodies.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "apps/config/identification.hpp"
#include "apps/output/bodies_file.hpp"
#include "apps/output/results_json.hpp"
#include "apps/output/tables.hpp"
#include "apps/page/bodies_page.hpp"
#include "apps/page/figures.hpp"
#include "apps/process/printable.hpp"
#include "dsp/io/read_recording.hpp"
#include "ident/equation/verdict.hpp"

namespace apps {
namespace {

using Eigen::Index;

/// What a config is for that others are not.
const char* what_is_special(const Config& config) {
  return config.inner == ident::Inner::none ? "a recording of several bodies" : "[library] inner";
}

/// Whether the motion was imposed and its force is to be explained.
bool is_force_asked(const Config& config) {
  return config.fit.target == dsp::to_string(dsp::Role::f) && config.inner == ident::Inner::hysteresis;
}

/// What a config may hold for one body only.
void refuse_settings(const Config& config) {
  const std::string& name = config.recordings.front().name;
  const auto refuse = [&](const std::string& found, const std::string& remedy) {
    throw dsp::Fault(dsp::FaultKind::usage, "bodies.config",
                     fmt::format("{}: {} with {}. {}", name, found, what_is_special(config), remedy));
  };
  if (!config.test_recordings.empty()) refuse("use = \"test\"", "Try ardent predict RUN RECORDING");
  if (!config.ranges.empty()) refuse("[[range]]", "Leave it out; [fit] train_share says how much is fitted");
  const auto looks_at_z = [](const std::string& term) {
    const ident::Expression expression(term);
    return std::find(expression.signals().begin(), expression.signals().end(), "z") != expression.signals().end();
  };
  if (config.inner != ident::Inner::none &&
      std::any_of(config.library.terms.begin(), config.library.terms.end(), looks_at_z))
    refuse("a term with z", "Of z the products are given; leave it out of terms");
  if (config.fit.target != "a" && !is_force_asked(config))
    refuse("target = \"" + config.fit.target + "\"",
           "The target is the acceleration of each body; with inner = \"hysteresis\" it may be f, the force on an "
           "imposed motion");
  if (config.fit.stage == ident::Stage::regression) refuse("stage = \"regression\"", "Leave `stage` out");
}

/// Recordings read as they are, and as what the documents of a run are written from.
struct BodiesInput {
  std::vector<Input> inputs;
  ident::BodiesRecord record;
};

dsp::Motion signals_of(const ident::BodiesRecord& record) {
  dsp::Motion motion;
  motion.sample_rate_hz = record.sample_rate_hz;
  const Index n = record.samples.rows();
  motion.signals.push_back(
      {"t", "s", Eigen::VectorXd::LinSpaced(n, 0.0, static_cast<double>(n - 1)) / record.sample_rate_hz});
  const ident::BodiesLayout layout{.num_bodies = record.num_bodies, .imposed = record.imposed};
  const auto name_of = [&](const dsp::Channel& channel) {
    return record.imposed ? layout.response(1) : layout.named("xva"[dsp::info_of(channel.role).order], channel.body);
  };
  for (Index j = 0; j < record.samples.cols(); ++j) {
    const dsp::Channel& channel = record.channels[static_cast<std::size_t>(j)];
    motion.signals.push_back({name_of(channel), channel.unit, record.samples.col(j)});
  }
  for (Index j = 0; j < record.input_samples.cols(); ++j)
    motion.signals.push_back({record.inputs[static_cast<std::size_t>(j)], "", record.input_samples.col(j)});
  motion.excluded.assign(static_cast<std::size_t>(n), 1);
  for (const dsp::IndexRange& one : record.usable)
    std::fill(motion.excluded.begin() + one.first, motion.excluded.begin() + one.last, 0);
  return motion;
}

ident::BodiesRecord read_one(const Config& config, const RecordingConfig& recording, const RunArguments& arguments,
                             Input& input, Console& console) {
  const dsp::ReadOptions options = read_options(recording, arguments.max_memory_bytes);
  dsp::RecordingReader reader(recording.file, options);
  dsp::Recording samples = dsp::read_recording(reader, options.max_memory_bytes);
  samples.name = recording.name;
  if (!reader.sidecar().ranges.empty())
    throw dsp::Fault(dsp::FaultKind::usage, "bodies.config",
                     fmt::format("{}: [[range]] in its sidecar, with {}. Leave it out; [fit] train_share says how much "
                                 "is fitted",
                                 recording.name, what_is_special(config)));
  const bool one_body = config.inner != ident::Inner::none;
  if (one_body && samples.find(dsp::Role::z) >= 0)
    throw dsp::Fault(
        dsp::FaultKind::usage, "bodies.config",
        fmt::format("{}: z was recorded, with [library] inner, which finds one that was not. Leave it out, "
                    "or role = \"z\"",
                    recording.name));
  ident::BodiesRecord record =
      is_force_asked(config) ? ident::imposed_record(samples) : ident::bodies_record(samples, one_body);
  if (is_force_asked(config) && record.num_bodies == 0)
    throw dsp::Fault(dsp::FaultKind::input, "bodies.imposed",
                     fmt::format("{}: target = \"f\" and no force was recorded. Give its channel role = \"f\" in a "
                                 "[[channel]]",
                                 recording.name));
  if (one_body && record.num_bodies != 1)
    throw dsp::Fault(dsp::FaultKind::usage, "bodies.config",
                     fmt::format("{}: {} bodies with [library] inner, which is for one. Leave it out, or the channels "
                                 "of the other bodies",
                                 recording.name, record.num_bodies));
  input.prepared.name = recording.name;
  input.files = reader.files();
  if (!reader.sidecar().file.empty()) input.files.push_back(reader.sidecar().file);
  input.prepared.checks = samples.checks;
  input.prepared.channels = samples.channels;
  input.prepared.excluded = samples.bad;
  input.prepared.signals = signals_of(record);
  input.prepared.intermediate.sample_rate_hz = input.recorded_rate_hz = samples.sample_rate_hz;
  report_checks(input.prepared.checks, recording.name, console);
  return record;
}

BodiesInput read_bodies(const Config& config, const RunArguments& arguments, Console& console) {
  refuse_settings(config);
  BodiesInput result{.inputs = std::vector<Input>(config.recordings.size()), .record = {}};
  std::vector<ident::BodiesRecord> records;
  for (std::size_t i = 0; i < config.recordings.size(); ++i)
    records.push_back(read_one(config, config.recordings[i], arguments, result.inputs[i], console));
  result.record = ident::joined(records);
  return result;
}

/// Among the signals of each recording the inputs as the equations look at them: in their frame, what it lacks derived.
void add_inputs(std::vector<Input>& inputs, const ident::BodiesRecord& record, const ident::BodiesLayout& layout) {
  const ident::BodiesRecord framed = ident::in_frame(record, layout.frame);
  for (std::size_t i = 0; i < inputs.size(); ++i)
    for (std::size_t j = 0; j < framed.inputs.size(); ++j) {
      std::vector<dsp::Signal>& signals = inputs[i].prepared.signals.signals;
      const dsp::IndexRange& rows = framed.parts[i].rows;
      const Eigen::VectorXd values =
          framed.input_samples.col(static_cast<Index>(j)).segment(rows.first, rows.last - rows.first);
      const auto found = std::find_if(signals.begin(), signals.end(),
                                      [&](const dsp::Signal& one) { return one.name == framed.inputs[j]; });
      if (found != signals.end())
        found->values = values;
      else
        signals.push_back({framed.inputs[j], "", values});
    }
}

ident::BodyLibrary library_of(const Config& config) {
  return {.order = config.library.order,
          .constant = config.library.constant,
          .defaults = config.default_terms,
          .terms = config.library.terms};
}

int exit_code_of(const ident::BodiesResult& result, const RunArguments& arguments, Console& console) {
  if (!result.silent_because.empty()) {
    console.error("fit.nothing", fmt::format("no equations: {}. Try a longer record, less noise, or other [library] "
                                             "terms",
                                             result.silent_because));
    return 4;
  }
  const auto least = ident::verdict_from_string(arguments.require);
  if (!least || ident::preference(result.verdict) >= ident::preference(*least)) return 0;
  console.error("verdict.required",
                fmt::format("the verdict is {}, --require {} wants {}", to_string(result.verdict), arguments.require,
                            *least == ident::Verdict::describes ? "describes" : "in_part or better"));
  return 4;
}

CsvTable free_run_table(const ident::BodiesResult& result, const ident::BodiesRecord& record) {
  const Index n = record.num_bodies;
  const bool are_several = record.parts.size() > 1;
  std::vector<std::pair<const ident::BodiesRun*, Index>> rows;
  for (const ident::BodiesRun& run : result.runs)
    for (Index k = 0; k < run.positions.rows(); ++k) rows.emplace_back(&run, k);
  CsvTable table{"predictions.csv", are_several ? "recording,t" : "t", rows.size(), {}};
  for (int body = 1; body <= n; ++body)
    table.header += fmt::format(",{0},{0}_free_run", result.model.layout.response(body));
  table.header += "\n";
  table.fill = [rows = std::move(rows), &record, n, are_several](std::size_t row, RowWriter& cells) {
    const auto [run, k] = rows[row];
    const Index at = run->samples.first + k;
    if (are_several) cells.text(text_cell(record.parts[run->part].name));
    cells.number(static_cast<double>(at - record.parts[run->part].rows.first) / record.sample_rate_hz);
    for (Index body = 0; body < n; ++body) {
      cells.number_if_any(record.samples(at, body));
      cells.number_if_any(run->positions(k, body));
    }
  };
  return table;
}

}  // namespace

bool is_of_bodies(const dsp::Fault& error) {
  return error.name() == "recording.bodies";
}

RunOutcome run_bodies_into(RunFolder& results, const Config& config, const RunArguments& arguments, Console& console) {
  HashesBeside hashes(input_files(config), arguments.num_threads);
  auto [inputs, record] = read_bodies(config, arguments, console);
  (void)results.add_files(inputs, hashes);
  refuse_warnings(arguments.strict, console);
  console.step(config.inner == ident::Inner::none
                   ? fmt::format("identifying the equations of {} bodies together", record.num_bodies)
               : is_force_asked(config) ? "identifying the force on the imposed motion with and without a memory"
                                        : "identifying the equation of motion with and without a memory");
  const ident::BodiesResult found = ident::identify_bodies(
      record, {library_of(config), config.inner, config.fit.train_fraction, arguments.num_threads});
  RunOutcome outcome;
  outcome.config = config;
  for (const Input& input : inputs) outcome.files.insert(outcome.files.end(), input.files.begin(), input.files.end());
  outcome.report = to_text(bodies_screen(found, record));
  outcome.equation = bodies_json(found, record);
  results.write("equation.txt", outcome.report);
  results.write("details.txt", outcome.report);
  results.write("equation.tex", bodies_latex(found, record));
  results.write("equation.json", outcome.equation);
  results.write("report.json", outcome.equation);
  add_inputs(inputs, record, found.model.layout);
  results.write("metrics.json", "{\n  \"ranges\": []\n}\n");  // which are of one body
  if (config.rows && !found.runs.empty()) results.write(free_run_table(found, record), console);
  const std::vector<PlotFigure> figures = bodies_figures(found, record);
  if (config.figures)
    for (const PlotFigure& figure : figures)
      write_figure_files(figure, [&](const std::string& name, std::string_view bytes) { results.write(name, bytes); });
  results.write("report.html", bodies_page(found, record, figures, config));
  outcome.exit_code = exit_code_of(found, arguments, console);
  results.finish(config, inputs, {}, console, outcome.exit_code);
  return outcome;
}

std::string check_bodies(const Config& config, const RunArguments& arguments, Console& console) {
  const auto [inputs, record] = read_bodies(config, arguments, console);
  if (console.json()) return checks_json(inputs);
  std::string text;
  for (const Input& input : inputs)
    for (const dsp::Check& found : input.prepared.checks)
      text += fmt::format("{:<8} {}: {}: {}{}\n", to_string(found.status), input.prepared.name, found.name,
                          printable(channel_prefix(found)), printable(found.message));
  return text + fmt::format("{:<8} {} {}, {} samples at {:.9g} Hz; inputs: {}\n", "ok", record.num_bodies,
                            record.num_bodies == 1 ? "body" : "bodies", record.samples.rows(), record.sample_rate_hz,
                            record.inputs.empty() ? "none" : fmt::format("{}", fmt::join(record.inputs, ", ")));
}

}  // namespace apps
