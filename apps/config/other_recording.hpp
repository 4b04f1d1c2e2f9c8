#pragma once
#include <cstddef>
#include <filesystem>
#include <string>

#include "apps/config/config.hpp"
#include "apps/config/inputs.hpp"
#include "ident/validate/predict.hpp"

namespace apps {

/// A recording that an equation was not identified from, read and prepared as those of `config` were, about its own
/// zero. Of `recording` what is left out (sidecar, where there is none beside it; channels) is as of the first of them.
[[nodiscard]] Input other_recording(Config config, RecordingConfig recording, std::size_t max_memory_bytes,
                                    int num_threads, Console& console);

}  // namespace apps
