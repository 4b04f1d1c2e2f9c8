#pragma once
#include <cstddef>

#include "dsp/io/input_file.hpp"

namespace dsp {

enum class MatLevel { four, five };

/// Of level 4, compares the size of every variable with the bytes that are there. Walks a MATLAB v5 file tag by tag,
/// inflates every compressed element to its end (whose checksum finds a flipped bit), and compares the dimensions of
/// every array with the bytes it brings, however deeply it is nested. Throws Fault (input): mat.truncated, mat.damaged
/// with the offset, mat.size where an element would expand beyond max_memory_bytes.
MatLevel check_mat(const InputFile& file, std::size_t max_memory_bytes);

}  // namespace dsp
