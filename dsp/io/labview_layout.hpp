#pragma once
#include "dsp/io/table_layout.hpp"

namespace dsp {

/// Whether text begins as LabVIEW's measurement files (LVM) do.
[[nodiscard]] bool is_labview(const std::vector<TableLine>& lines);
/// Of one: two headers of `key<separator>value...`, a line of names, rows; with Multi_Headings another header and line
/// of names before each segment. Throws Fault table.header (input).
[[nodiscard]] TableLayout labview_layout(const InputFile& file, const std::vector<TableLine>& lines);

}  // namespace dsp
