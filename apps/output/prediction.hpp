#pragma once
#include <string>

#include "apps/text/csv_table.hpp"
#include "ident/validate/predict.hpp"

namespace apps {

/// predict.json: what an identified equation makes of another recording.
[[nodiscard]] std::string prediction_json(const ident::RecordPrediction& prediction);
/// " (set to the measured state 3 times, ...; without that 1.2)"; empty where it was not.
[[nodiscard]] std::string restarts_text(const ident::RecordPrediction& prediction);
/// t, x, x_predicted, x_linear; SI; empty where nothing was run. The prediction must outlive it.
[[nodiscard]] CsvTable prediction_table(std::string name, const ident::RecordPrediction& prediction);
/// The same for a person.
[[nodiscard]] std::string prediction_text(const ident::RecordPrediction& prediction);

}  // namespace apps
