#pragma once
#include <memory>

#include "dsp/io/sample_source.hpp"

namespace dsp {

class InputFile;

/// WAV, RF64, W64, CAF, FLAC, AIFF through libsndfile; integers come as fractions of full scale, floats as they are.
/// Throws Fault (input): container.truncated where the header promises more than the file holds, container.unfinished
/// (data size 0), container.wrapped (over 4 GiB in 32-bit sizes), container.lossy, container.limit, container.damaged.
[[nodiscard]] std::unique_ptr<SampleSource> open_sound_file(std::unique_ptr<InputFile> file,
                                                            const OpenOptions& options);

}  // namespace dsp
