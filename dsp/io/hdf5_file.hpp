#pragma once
#include <memory>
#include <string_view>

#include "dsp/io/input_file.hpp"
#include "dsp/io/sample_source.hpp"

namespace dsp {

/// Whether a file begins as HDF5 does, with or without the block that MATLAB v7.3 puts before.
[[nodiscard]] bool is_hdf5(std::string_view head);

/// HDF5 and MATLAB v7.3: datasets of numbers, the members of compound ones and, of MATLAB, what lies in structures and
/// cells, as open_arrays has them, streamed. `fs`, `dt` and their like are read as attributes, too, `units` as the
/// unit. Data outside the file (external, virtual) are left out. Throws Fault (input): container.truncated,
/// hdf5.damaged.
[[nodiscard]] std::unique_ptr<SampleSource> open_hdf5_file(std::unique_ptr<InputFile> file, const OpenOptions& options);

}  // namespace dsp
