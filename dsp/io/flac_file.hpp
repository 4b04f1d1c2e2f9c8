#pragma once
#include <memory>

#include "dsp/io/sample_source.hpp"

namespace dsp {

class InputFile;

/// FLAC through libFLAC, as fractions of full scale. Throws Fault (input): container.truncated, container.wrapped
/// (fewer frames promised than there are), container.damaged where blocks are missing or repeated or the samples do not
/// have the MD5 in the file's head.
[[nodiscard]] std::unique_ptr<SampleSource> open_flac_file(std::unique_ptr<InputFile> file, const OpenOptions& options);

}  // namespace dsp
