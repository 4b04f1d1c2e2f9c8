#pragma once
#include <memory>
#include <string_view>

#include "dsp/io/input_file.hpp"
#include "dsp/io/sample_source.hpp"

namespace dsp {

/// Whether a file begins as a TDMS file does, or its index.
[[nodiscard]] bool is_tdms(std::string_view head);

/// TDMS, the binary files of LabVIEW: channels of one length, rate and beginning are columns, scaled as their
/// properties say (lines, polynomials, tables), in their unit_string, at the rate of their wf_increment or on a channel
/// of times; all else is listed in left_out. Streamed. Throws Fault (input): those of read_tdms_segments and of
/// open_arrays, and container.unsupported for the index of a file, which holds no samples.
[[nodiscard]] std::unique_ptr<SampleSource> open_tdms_file(std::unique_ptr<InputFile> file, const OpenOptions& options);

}  // namespace dsp
