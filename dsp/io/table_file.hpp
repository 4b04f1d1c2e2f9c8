#pragma once
#include <memory>

#include "dsp/io/input_file.hpp"
#include "dsp/io/sample_source.hpp"

namespace dsp {

/// CSV, TSV and LabVIEW text: two passes, the first for the clock and the count of rows, the second for the numbers.
/// Throws Fault (input): table.ragged, table.cell, table.cut (the last line), table.header, table.line with line and
/// column, and those of even_clock; usage for a time column that is not there.
[[nodiscard]] std::unique_ptr<SampleSource> open_table_file(std::unique_ptr<InputFile> file,
                                                            const OpenOptions& options);

}  // namespace dsp
