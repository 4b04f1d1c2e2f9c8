#pragma once
#include <string>

#include "apps/output/tables.hpp"
#include "ident/validate/predict.hpp"

namespace apps {

/// predict.json: what an identified equation makes of another recording.
[[nodiscard]] std::string prediction_json(const ident::RecordPrediction& prediction);
/// predict.csv: t, x, x_predicted, x_linear; SI; empty where nothing was run.
void write_prediction(const ident::RecordPrediction& prediction, const Sink& sink);
/// The same for a person.
[[nodiscard]] std::string prediction_text(const ident::RecordPrediction& prediction);

}  // namespace apps
