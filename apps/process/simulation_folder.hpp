#pragma once
#include <filesystem>

namespace apps {

/// Throws dsp::Fault (output, "output.exists") if `folder` holds a simulation, unless it may be replaced (`force`).
void require_no_simulation(const std::filesystem::path& folder, bool force);

/// Removes what an earlier simulation left, so that no file of it stays beside the new one's. Other files stay.
void clear_simulation(const std::filesystem::path& folder);

}  // namespace apps
