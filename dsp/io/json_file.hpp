#pragma once
#include <memory>

#include "dsp/io/input_file.hpp"
#include "dsp/io/sample_source.hpp"

namespace dsp {

/// JSON, or one record a line: lists of numbers under their keys ({"t": [...], "x": [...]}), records
/// ([{"t": 0, "x": 1}, ...]), rows ({"columns": ["t", "x"], "data": [[0, 1], ...]}) and objects whose keys count
/// ({"x": {"0": 1, ...}}), at any depth, as open_arrays has them. null and NaN are missing values; texts that are
/// numbers or times of day are those. Held in memory. Throws Fault (input): json.syntax (with the byte), json.depth,
/// memory.limit.
[[nodiscard]] std::unique_ptr<SampleSource> open_json_file(std::unique_ptr<InputFile> file, const OpenOptions& options);

}  // namespace dsp
