#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>

namespace apps {

/// A document of a run folder. Throws dsp::Fault (input): "run.incomplete" where it is missing, "run.damaged".
[[nodiscard]] nlohmann::ordered_json read_run_json(const std::filesystem::path& file);

}  // namespace apps
