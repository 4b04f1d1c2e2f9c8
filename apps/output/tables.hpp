#pragma once
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/prepare.hpp"
#include "ident/identify.hpp"

namespace apps {

/// Takes a table piece by piece.
using Sink = std::function<void(std::string_view)>;

/// prepared.csv: t, r, y, x, v, a, ddr and what else there is, then `excluded`; SI, 17 significant digits. Several
/// recordings follow one another with their name in a first column. Where any of them is not calibrated a last column
/// `uncalibrated` is 1 on its rows.
void write_prepared(const std::vector<const dsp::Prepared*>& recordings, const Sink& sink);

/// predictions.csv: a row for each row of each range: range, recording, part, t, the target, and for each method its
/// prediction and the standard deviation of that; then `uncalibrated` as above.
void write_predictions(const std::vector<ident::RangeResult>& ranges, const std::vector<ident::Columns>& recordings,
                       const Sink& sink);

/// A text as a cell of a CSV file: quoted where it must be, with ' before what a spreadsheet would take for a formula.
[[nodiscard]] std::string text_cell(std::string_view text);

}  // namespace apps
