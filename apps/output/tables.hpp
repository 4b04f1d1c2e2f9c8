#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "apps/text/csv_table.hpp"
#include "dsp/prepare.hpp"
#include "ident/identify.hpp"

namespace apps {

/// prepared.csv: t, r, y, x, v, a, ddr and what else there is, then `excluded`; SI, 17 significant digits. Several
/// recordings follow one another with their name in a first column. Where any of them is not calibrated a last column
/// `uncalibrated` is 1 on its rows. The recordings must outlive it.
[[nodiscard]] CsvTable prepared_table(const std::vector<const dsp::Prepared*>& recordings);

/// predictions.csv: a row for each row of each range: range, recording, part, t, the target, and for each method its
/// prediction and the standard deviation of that; then `uncalibrated` as above. Ranges and recordings must outlive it.
[[nodiscard]] CsvTable predictions_table(const std::vector<ident::RangeResult>& ranges,
                                         const std::vector<ident::Columns>& recordings);

/// A text as a cell of a CSV file: quoted where it must be, with ' before what a spreadsheet would take for a formula.
[[nodiscard]] std::string text_cell(std::string_view text);

}  // namespace apps
