#include "apps/cli/predict_bodies.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/output/bodies_file.hpp"
#include "apps/output/output_folder.hpp"
#include "apps/process/printable.hpp"
#include "apps/text/csv_table.hpp"
#include "apps/text/json_parts.hpp"
#include "dsp/io/read_recording.hpp"
#include "dsp/values/names.hpp"

namespace apps {
namespace {

using Eigen::Index;
using Json = nlohmann::ordered_json;

dsp::Fault misfit(const std::string& name, const std::string& what) {
  return {dsp::FaultKind::input, "predict.bodies", fmt::format("{}: {}", name, what)};
}

/// In the frame and with the inputs of the equations, in their order.
ident::BodiesRecord as_equations_want(ident::BodiesRecord record, const ident::BodiesLayout& layout) {
  if (record.num_bodies != 0 && record.num_bodies != layout.num_bodies)
    throw misfit(record.name, fmt::format("{} bodies, the equations have {}. Record all of them, or the inputs alone",
                                          record.num_bodies, layout.num_bodies));
  ident::BodiesRecord framed = ident::in_frame(std::move(record), layout.frame);
  Eigen::MatrixXd inputs(framed.input_samples.rows(), std::ssize(layout.inputs));
  std::vector<double> noise;
  for (Index j = 0; j < inputs.cols(); ++j) {
    const std::string& wanted = layout.inputs[static_cast<std::size_t>(j)];
    const auto found = std::find(framed.inputs.begin(), framed.inputs.end(), wanted);
    if (found == framed.inputs.end())
      throw misfit(framed.name,
                   fmt::format("no input {}, which the equations have. Recorded are: {}", wanted,
                               framed.inputs.empty() ? "none" : fmt::format("{}", fmt::join(framed.inputs, ", "))));
    inputs.col(j) = framed.input_samples.col(found - framed.inputs.begin());
    noise.push_back(framed.input_noise_std[static_cast<std::size_t>(found - framed.inputs.begin())]);
  }
  framed.inputs = layout.inputs, framed.input_samples = std::move(inputs), framed.input_noise_std = std::move(noise);
  return framed;
}

struct Prediction {
  ident::BodiesRecord record;
  Index first = 0, counted = 0;  ///< samples from which it runs, and from which its errors count
  Eigen::MatrixXd positions;
  Eigen::VectorXd nmse;  ///< of each body; NaN: not recorded, or it runs away
};

Prediction predicted(const ident::BodiesModel& model, ident::BodiesRecord given, int num_threads) {
  Prediction prediction{.record = as_equations_want(std::move(given), model.layout), .positions = {}, .nmse = {}};
  const ident::BodiesRecord& record = prediction.record;
  std::vector<double> state(static_cast<std::size_t>(model.layout.num_states()), 0.0);
  double scale = 1.0;
  if (record.num_bodies > 0) {
    constexpr double most_s = 2.0, of_record = 0.125;
    const dsp::IndexRange longest =
        *std::max_element(record.usable.begin(), record.usable.end(),
                          [](const auto& a, const auto& b) { return a.last - a.first < b.last - b.first; });
    const auto size = static_cast<Index>(
        std::min(most_s * record.sample_rate_hz, of_record * static_cast<double>(longest.last - longest.first)));
    prediction.first = longest.first, prediction.counted = longest.first + std::max<Index>(size, 32);
    const auto found = ident::first_state(model, record, {prediction.first, prediction.counted}, num_threads);
    if (!found)
      throw misfit(record.name, "no state is found in which the equations begin it. Record longer, or with less noise");
    state = *found;
    scale = record.samples.leftCols(record.num_bodies).cwiseAbs().maxCoeff();
  } else if (model.layout.frame == ident::Frame::absolute) {
    for (Index j = 0; j < record.input_samples.cols(); ++j)
      for (std::size_t i = 0; i < state.size(); ++i)
        if (record.inputs[static_cast<std::size_t>(j)] == (i % 2 == 0 ? "r" : "dr"))
          state[i] = record.input_samples(0, j);
  }
  const Index n = record.input_samples.rows() - prediction.first;
  const double begin_s = static_cast<double>(prediction.first) / record.sample_rate_hz;
  const Eigen::MatrixXd inputs = record.input_samples.bottomRows(n);
  prediction.positions =
      ident::responses_of(model, ident::run_free(model, inputs, record.sample_rate_hz, state, scale, begin_s), inputs,
                          record.sample_rate_hz, begin_s);
  prediction.nmse = ident::errors_of_run(record, prediction.positions, prediction.first, prediction.counted).nmse;
  return prediction;
}

std::string json_of(const Prediction& prediction, const ident::BodiesLayout& layout) {
  const ident::BodiesRecord& record = prediction.record;
  const bool ran = prediction.positions.allFinite();
  Json document{
      {"recording", printable(record.name)},
      {"stretches",
       {{{"from_s", static_cast<double>(prediction.counted) / record.sample_rate_hz},
         {"to_s", static_cast<double>(prediction.first + prediction.positions.rows()) / record.sample_rate_hz}}}},
      {"unit", printable(layout.imposed ? layout.force_unit : record.length)},
      {"bodies", Json::array()}};
  for (Index body = 0; body < prediction.positions.cols(); ++body) {
    Json one{{"body", body + 1}};
    apps::put(one, "nmse", prediction.nmse(body),
              !ran             ? "the equations run away"
              : layout.imposed ? "its force was not recorded"
                               : "its displacement was not recorded");
    document["bodies"].push_back(std::move(one));
  }
  return text_of(document);
}

CsvTable table_of(const Prediction& prediction, const ident::BodiesLayout& layout) {
  const Index n = prediction.positions.cols();
  const bool is_recorded = prediction.record.num_bodies > 0;
  CsvTable table{"predict.csv", "t", static_cast<std::size_t>(prediction.positions.rows()), {}};
  for (int body = 1; body <= n; ++body) {
    const std::string x = layout.response(body);
    table.header += is_recorded ? fmt::format(",{0},{0}_predicted", x) : fmt::format(",{}_predicted", x);
  }
  table.header += "\n";
  table.fill = [&prediction, n, is_recorded](std::size_t row, RowWriter& cells) {
    const Index k = prediction.first + static_cast<Index>(row);
    cells.number(static_cast<double>(k) / prediction.record.sample_rate_hz);
    for (Index body = 0; body < n; ++body) {
      if (is_recorded) cells.number_if_any(prediction.record.samples(k, body));
      cells.number_if_any(prediction.positions(static_cast<Index>(row), body));
    }
  };
  return table;
}

std::string text_of_prediction(const Prediction& prediction, const ident::BodiesLayout& layout) {
  std::string text = fmt::format("{}: free run{}\n", printable(prediction.record.name),
                                 layout.num_bodies == 1 ? "" : fmt::format(" of {} bodies", layout.num_bodies));
  for (Index body = 0; body < prediction.nmse.size(); ++body) {
    const std::string x = layout.response(static_cast<int>(body) + 1);
    text += std::isfinite(prediction.nmse(body))
                ? fmt::format("  {}  NMSE {:.2g}, an error of {:.2g} % of its rms\n", x, prediction.nmse(body),
                              100.0 * std::sqrt(prediction.nmse(body)))
                : fmt::format("  {}  {}\n", x,
                              prediction.record.num_bodies > 0 ? "runs away" : "predicted; it was not recorded");
  }
  return text;
}

}  // namespace

int predict_bodies(const PredictArguments& arguments, const GlobalOptions& global, Console& console) {
  if (!arguments.range.empty() || !arguments.method.empty() || !global.set.empty())
    throw dsp::Fault(dsp::FaultKind::usage, "usage",
                     "predict: --range, --method and --set are for runs of one body. Leave them out");
  const std::filesystem::path equation_file = arguments.run / "equation.json";
  const std::filesystem::path destination =
      global.output.empty() ? std::filesystem::path(dsp::slug(arguments.recording.stem().string()) + "-predict")
                            : global.output;
  require_apart(destination, {equation_file, arguments.recording});
  const ident::BodiesModel model = read_bodies(arguments.run).model;
  OutputFolder folder(destination, global.force);
  Manifest manifest = begin_manifest("predict", global.command_line, global.seed, folder.destination());
  dsp::ReadOptions options;
  options.sidecar = arguments.sidecar;
  const dsp::Recording recording = dsp::read_recording(arguments.recording, options);
  const Prediction prediction =
      predicted(model,
                model.layout.imposed ? ident::imposed_record(recording)
                                     : ident::bodies_record(recording, model.layout.num_bodies == 1),
                thread_count(global));
  const std::string document = json_of(prediction, model.layout);
  folder.write("predict.json", document);
  OutputFile series = folder.file("predict.csv");
  write_table(table_of(prediction, model.layout), [&](std::string_view rows) { series.write(rows); });
  series.close();
  for (const std::filesystem::path& file : {equation_file, arguments.recording})
    add_input(manifest, file, folder.destination());
  manifest.warnings = console.warnings();
  folder.commit(std::move(manifest));
  console.result(console.json() ? document
                                : fmt::format("{}results are in {}\n", text_of_prediction(prediction, model.layout),
                                              folder.destination().string()));
  if (prediction.positions.allFinite()) return 0;
  console.error("predict.no_free_run", fmt::format("{}: the equations run away", recording.name));
  return 4;
}

}  // namespace apps
