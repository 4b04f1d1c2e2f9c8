#pragma once
#include <memory>
#include <string_view>

#include "dsp/io/input_file.hpp"
#include "dsp/io/sample_source.hpp"

namespace dsp {

/// Whether a file begins as NumPy's .npy does.
[[nodiscard]] bool is_npy(std::string_view head);

/// NumPy's .npy: a vector, the columns of a matrix in either order, or the fields of records; streamed. With `salvage`
/// the rows that are there of a file that was cut. Throws Fault (input): npy.header, container.truncated, and those of
/// open_arrays.
[[nodiscard]] std::unique_ptr<SampleSource> open_npy_file(std::unique_ptr<InputFile> file, const OpenOptions& options);

/// A ZIP archive of such (.npz), whose checksums are verified: stored members are streamed, packed ones unpacked in
/// memory. Throws Fault (input): zip.truncated, zip.damaged, zip.size (a member expands beyond max_memory_bytes),
/// container.unsupported for any other archive, with how to convert a spreadsheet.
[[nodiscard]] std::unique_ptr<SampleSource> open_npz_file(std::unique_ptr<InputFile> file, const OpenOptions& options);

}  // namespace dsp
