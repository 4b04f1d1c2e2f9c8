#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "apps/cli/command.hpp"
#include "apps/cli/predict_bodies.hpp"
#include "apps/config/other_recording.hpp"
#include "apps/output/bodies_file.hpp"
#include "apps/output/equation_file.hpp"
#include "apps/output/finished_run.hpp"
#include "apps/output/output_folder.hpp"
#include "apps/output/prediction.hpp"
#include "apps/page/page.hpp"
#include "apps/process/background_hashes.hpp"
#include "dsp/values/fault.hpp"
#include "dsp/values/names.hpp"

namespace apps {
namespace {

namespace fs = std::filesystem;

/// Those of the fit are those of the run.
void refuse_other_settings(const std::vector<std::string>& set) {
  for (const std::string& one : set)
    if (!one.starts_with("prepare.") && !one.starts_with("recording."))
      throw dsp::Fault(
          dsp::FaultKind::usage, "usage",
          fmt::format("--set {}: a prediction fits nothing; want a setting of [prepare] or [[recording]]", one));
}

/// The equation of a finished run, run free on another recording. 4 where it could not be run to the end.
int predict(const PredictArguments& arguments, const GlobalOptions& global, Console& console) {
  const fs::path equation_file = arguments.run / "equation.json", config_file = arguments.run / "config.toml";
  const fs::path destination = global.output.empty()
                                   ? fs::path(dsp::slug(arguments.recording.stem().string()) + "-predict")
                                   : fs::path(global.output);
  check_finished_run(arguments.run, global.strict, console);
  if (is_bodies_run(arguments.run)) return predict_bodies(arguments, global, console);
  require_apart(destination, {equation_file, config_file, arguments.recording});
  const Manifest fitted = read_manifest(arguments.run).value_or(Manifest());
  refuse_other_settings(global.set);
  Config config = read_config(config_file, global.set);
  take_names(fitted, config);
  const PredictedEquation equation = read_predicting_equation(arguments.run, arguments.range, arguments.method);
  OutputFolder folder(destination, global.force);
  Manifest manifest = begin_manifest("predict", global.command_line, global.seed, folder.destination());
  HashesBeside hashes({arguments.recording}, thread_count(global));
  const Input input = other_recording(config, {.file = arguments.recording, .sidecar = arguments.sidecar}, 0,
                                      thread_count(global), console);
  refuse_warnings(global.strict, console);
  const auto range = std::find_if(config.ranges.begin(), config.ranges.end(),
                                  [&](const ident::Range& one) { return one.spec.name == equation.range; });
  const std::string hash = hashes.of(input.files.front());
  const ident::RecordPrediction prediction =
      ident::predict(equation.model, equation.linear, input,
                     {.fitted_as = fitted_name(fitted, config, hash),
                      .where = range == config.ranges.end() ? "" : range->spec.where,
                      .num_threads = thread_count(global),
                      .poll = shown_poll(console, "free run")});
  const std::string document = prediction_json(prediction);
  folder.write("predict.json", document);
  OutputFile series = folder.file("predict.csv");
  write_table(prediction_table("predict.csv", prediction), [&](std::string_view text) { series.write(text); });
  series.close();
  folder.write("predict.html", prediction_page(prediction, ident::to_text(equation.model), console.warnings()));
  for (const fs::path& file : {equation_file, config_file}) add_input(manifest, file, folder.destination());
  add_input(manifest, input.files.front(), folder.destination(), hash, input.prepared.name);
  for (std::size_t i = 1; i < input.files.size(); ++i) add_input(manifest, input.files[i], folder.destination());
  manifest.warnings = console.warnings();
  folder.commit(std::move(manifest));
  console.result(console.json() ? document
                                : fmt::format("{}results are in {}\n", prediction_text(prediction),
                                              folder.destination().string()));
  if (prediction.nmse.reason.empty()) return 0;
  console.error("predict.no_free_run",
                fmt::format("{}: no free run: {}", prediction.recording, prediction.nmse.reason));
  return 4;
}

}  // namespace

Command predict_command() {
  const auto typed = std::make_shared<PredictArguments>();
  return {
      .name = "predict",
      .help = "Tests the equation of a run on another recording",
      .group = use_group,
      .unused = {{"--seed"}, {"--dry-run"}},
      .options = {{"RUN", &typed->run, "Run folder.", {.required = true}},
                  {"RECORDING",
                   &typed->recording,
                   "Recording of the same set-up, not a fitted one.",
                   {.required = true, .is_recording = true}},
                  {"--sidecar",
                   &typed->sidecar,
                   "Its sidecar. Left out: the one beside it, else the run's.",
                   {.name = "FILE"}},
                  {"--range", &typed->range, "Range whose equation is used. Left out: the one that the run chose."},
                  {"--method", &typed->method, "Method that found it. Left out: the one whose verdict the range has."}},
      .run = [typed](const GlobalOptions& global, Console& console) { return predict(*typed, global, console); },
      .examples = {"ardent predict swing1-run swing2.csv -o swing2-predict",
                   "ardent predict frame_250g-run frame_450g.csv --range slip --json"},
      .details =
          "Writes predict.json, predict.csv and predict.html: the error of the free run beside the noise of the "
          "sensors, "
          "beside a linear equation and a payload at rest, and which coefficients carry over to the recording. Of a "
          "driven "
          "motion whose small errors grow tenfold the run begins again from the measured state, as for a verdict, and "
          "the error without that is beside. x is about the zero that prepare.zero states, else about that with which "
          "the equation is closest. --set takes settings of [prepare] and [[recording]]. "
          "Of a run with several bodies every body is run free together, over the inputs of the recording, which may "
          "hold nothing else: then from rest. predict.json and predict.csv have every body."};
}

}  // namespace apps
