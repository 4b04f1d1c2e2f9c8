#pragma once
#include <cstdint>

#include "dsp/io/input_file.hpp"

namespace dsp {

/// Whether a FLAC file ends in the frame that holds sample num_frames - 1, whole by its checksum (RFC 9639, 9.1 to
/// 9.3). Looked up in the file's last bytes: a decoder's seek takes as long as decoding half the record. False also
/// where that does not show: frames of varying length, something behind or before the stream.
[[nodiscard]] bool ends_in_last_frame(const InputFile& file, std::int64_t num_frames);

}  // namespace dsp
