#pragma once
#include <vector>

#include "apps/config/config.hpp"

namespace apps {

/// Puts as many recordings in the place of one as its table holds runs side by side, where it or its sidecar says
/// run = "all". A file or a sidecar that cannot be read stays what it is: whoever reads it says what is wrong.
void take_runs_apart(std::vector<RecordingConfig>& recordings);

}  // namespace apps
