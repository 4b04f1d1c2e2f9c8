#pragma once
#include <memory>

#include "dsp/io/input_file.hpp"
#include "dsp/io/sample_source.hpp"

namespace dsp {

/// MATLAB v5 and v4 files as open_arrays has them, with what lies in structures (`run.x`) and cells (`c_2`), and the
/// signals of Simulink's "structure with time". The file is walked and every compressed element inflated
/// to its end before matio sees it, because matio reports success on truncated and damaged files. Throws Fault (input):
/// mat.truncated, mat.damaged, mat.size (more promised than the file or max_memory_bytes allows), mat.no_variable, and
/// those of even_clock for a variable t or time.
[[nodiscard]] std::unique_ptr<SampleSource> open_mat_file(std::unique_ptr<InputFile> file, const OpenOptions& options);

}  // namespace dsp
