#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace apps {

/// A file of a run folder as it is. Throws dsp::Fault (input, "run.incomplete") where it cannot be read.
[[nodiscard]] std::string read_run_file(const std::filesystem::path& file);

/// A document of a run folder. Throws dsp::Fault (input): "run.incomplete" where it is missing, "run.damaged".
[[nodiscard]] nlohmann::ordered_json read_run_json(const std::filesystem::path& file);

}  // namespace apps
