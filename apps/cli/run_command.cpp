#include <fmt/format.h>

#include <algorithm>

#include "apps/cli/run_arguments.hpp"
#include "apps/config/identification.hpp"
#include "apps/config/other_recording.hpp"
#include "apps/output/fit_outcome.hpp"
#include "apps/output/prediction.hpp"
#include "apps/output/report_text.hpp"
#include "apps/output/results_json.hpp"
#include "apps/output/run_folder.hpp"
#include "apps/page/page_files.hpp"
#include "apps/process/interrupt.hpp"
#include "dsp/names.hpp"
#include "ident/identify.hpp"
#include "ident/validate/judge.hpp"
#include "ident/validate/predict.hpp"

namespace apps {
namespace {

/// 4 and a message where a range has no fit to show.
int exit_code_of(const std::vector<ident::RangeResult>& ranges, Console& console) {
  int code = 0;
  for (const ident::RangeResult& range : ranges)
    code = std::max(code, outcome_of(range.fits, fmt::format("range '{}'", range.spec.name), console));
  return code;
}

/// The chosen equation run free on the recordings that were kept for that: predict-NAME.json and .csv for each.
std::vector<ident::RecordPrediction> predict_test_recordings(const Work& work,
                                                             const std::vector<ident::RangeResult>& ranges,
                                                             const RunArguments& arguments, RunFolder& results,
                                                             Console& console) {
  const std::optional<ident::ChosenFit> chosen = ident::chosen_fit(ranges);
  std::vector<ident::RecordPrediction> predictions;
  if (!chosen || work.config.test_recordings.empty()) return predictions;
  const ident::RangeResult& range = ranges[chosen->range];
  for (std::size_t i = 0; i < work.config.test_recordings.size(); ++i) {
    const RecordingConfig& recording = work.config.test_recordings[i];
    const Input input = other_recording(work.config, recording, arguments.max_memory_bytes, console);
    results.add_files({input});
    ident::RecordPrediction prediction =
        ident::predict(range.fits[chosen->method].model, range.linear, input,
                       {.where = range.spec.where, .num_threads = arguments.num_threads, .poll = check_interrupted});
    const std::string name = fmt::format("predict-{}-{}", i + 1, dsp::slug(recording.file.stem().string()));
    results.write(name + ".json", prediction_json(prediction));
    results.stream(name + ".csv", [&](const Sink& sink) { write_prediction(prediction, sink); });
    predictions.push_back(std::move(prediction));
  }
  return predictions;
}

/// What the first screen leaves out.
std::string details_text(const RunResults& found) {
  std::string text = report_text(found.ranges) + findings_text(found.inputs);
  for (const ident::RecordPrediction& prediction : found.predictions) text += prediction_text(prediction);
  return text;
}

/// Recording to judged equation: the run folder, and the equations on the console.
int run(const RunArguments& arguments, Console& console) {
  const Config config = config_of(arguments);
  if (arguments.dry_run) {
    console.result(plan_text(arguments, config));
    return 0;
  }
  RunFolder results(folder_apart(arguments, config, "-run"), arguments.force, origin_of(arguments, "run", config));
  Work work = prepare_work(config, arguments, console);
  results.add_files(work.inputs);
  const auto libraries = compile_libraries(work.config, work.inputs);
  std::vector<ident::Columns> columns =
      all_columns(work.config, work.inputs, libraries, arguments.max_memory_bytes, console);
  const ident::IdentifyOptions options = identify_options(work.config, work.inputs, arguments.num_threads);
  auto ranges = identify_ranges(work.config, columns, libraries.front(), options, console);
  const RunResults found{work.config, work.inputs, columns, ranges,
                         predict_test_recordings(work, ranges, arguments, results, console)};
  refuse_warnings(arguments.strict, console);
  const FirstScreen first = first_screen(found);
  results.write("equation.txt", to_text(first));
  results.write("details.txt", details_text(found));
  results.write("equation.tex", report_latex(ranges));
  results.write("equation.json", equation_json(ranges));
  results.write("metrics.json", metrics_json(ranges, options));
  results.stream("predictions.csv", [&](const Sink& sink) { write_predictions(ranges, columns, sink); });
  write_page(found, first, results, console);
  results.finish(work.config, work.inputs, console);
  const std::string folder = results.destination().string();
  console.result(console.json()
                     ? equation_json(ranges)
                     : fmt::format("{0}{1:<{2}}results are in {3}: open report.html, or ardent report {3} --details\n",
                                   to_text(first), "more", label_width, folder));
  return exit_code_of(ranges, console);
}

}  // namespace

Command run_command() {
  return {"run", "From a recording to its equation of motion", {}, run_like(run)};
}

}  // namespace apps
