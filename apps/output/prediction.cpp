#include "apps/output/prediction.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/output/report_text.hpp"
#include "apps/process/printable.hpp"
#include "apps/text/json_number.hpp"
#include "apps/text/json_parts.hpp"
#include "ident/equation/model.hpp"

namespace apps {
namespace {

using Json = nlohmann::ordered_json;
using Eigen::Index;

std::string shown(const ident::Figure& figure) {
  return figure.reason.empty() ? fmt::format("{:.3g}", figure.value) : figure.reason;
}

std::string coefficient_text(const ident::CarryOver& one) {
  const auto with_std = [](double mean, double std) {
    return ident::number(mean) +
           (std::isfinite(std) ? fmt::format(" +- {:.2g}", std) : " (standard deviation unknown)");
  };
  const std::string identified = with_std(one.identified, one.identified_std);
  if (!std::isfinite(one.here))
    return fmt::format("  {}: {}; not kept here: whether it carries over is not known\n", one.term, identified);
  return fmt::format("  {}: {}, here {}: {}\n", one.term, identified, with_std(one.here, one.here_std),
                     !one.carries   ? "whether it carries over is not known"
                     : *one.carries ? "carries over"
                                    : "does not carry over");
}

}  // namespace

std::string prediction_json(const ident::RecordPrediction& prediction) {
  Json document{{"recording", printable(prediction.recording)}, {"stretches", Json::array()}};
  for (const dsp::Interval& stretch : prediction.stretches)
    document["stretches"].push_back({{"from_s", stretch.from_s}, {"to_s", stretch.to_s}});
  put(document, "nmse", prediction.nmse);
  document["num_restarts"] = prediction.num_restarts;
  put(document, "nmse_without_restarts", prediction.unaided);
  put(document, "rms", prediction.rms);
  document["unit"] = prediction.unit;
  put(document, "noise_floor", prediction.noise_floor);
  document["baselines"] = Json::object();
  put(document["baselines"], "linear", prediction.linear);
  put(document["baselines"], "still", prediction.still);
  document["coordinates"] = coordinates_json({prediction.coordinates});
  if (!prediction.remark.empty()) document["remark"] = printable(prediction.remark);
  document["coefficients"] = Json::array();
  for (const ident::CarryOver& one : prediction.coefficients)
    document["coefficients"].push_back({{"name", one.term},
                                        {"identified", one.identified},
                                        {"identified_std", number_or_null(one.identified_std)},
                                        {"here", number_or_null(one.here)},
                                        {"here_std", number_or_null(one.here_std)},
                                        {"carries_over", one.carries ? Json(*one.carries) : Json()}});
  return text_of(document);
}

std::string restarts_text(const ident::RecordPrediction& prediction) {
  if (prediction.num_restarts == 0) return {};
  return fmt::format(" (set to the measured state {} times, before errors have grown tenfold; without that {})",
                     prediction.num_restarts, shown(prediction.unaided));
}

CsvTable prediction_table(std::string name, const ident::RecordPrediction& prediction) {
  return {std::move(name), "t,x,x_predicted,x_linear\n", static_cast<std::size_t>(prediction.time_s.size()),
          [&prediction](std::size_t row, RowWriter& cells) {
            const Index i = static_cast<Index>(row);
            cells.number(prediction.time_s(i));
            for (const Eigen::VectorXd* values : {&prediction.x, &prediction.predicted, &prediction.linear_predicted})
              cells.number_if_any((*values)(i));
          }};
}

std::string prediction_text(const ident::RecordPrediction& prediction) {
  std::string text =
      fmt::format("{}: error of x in the free run, as NMSE: {}{}; of a linear equation: {}; of a payload at rest: {}\n",
                  printable(prediction.recording), shown(prediction.nmse), restarts_text(prediction),
                  shown(prediction.linear), shown(prediction.still));
  if (prediction.rms.reason.empty())
    text += fmt::format("  rms error {} {}, noise of the displacement {} {}\n", shown(prediction.rms), prediction.unit,
                        shown(prediction.noise_floor), prediction.unit);
  text += fmt::format("  {}\n", coordinates_sentence({prediction.coordinates}));
  if (!prediction.remark.empty()) text += fmt::format("  {}\n", printable(prediction.remark));
  for (const ident::CarryOver& one : prediction.coefficients) text += coefficient_text(one);
  return text;
}

}  // namespace apps
