#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace apps {

/// A file of a run folder as it is. Throws dsp::Fault (input, "run.incomplete") where it cannot be read.
[[nodiscard]] std::string read_run_file(const std::filesystem::path& file);

/// A document of a run folder. Throws dsp::Fault (input): "run.incomplete" where it is missing, "run.damaged".
[[nodiscard]] nlohmann::ordered_json read_run_json(const std::filesystem::path& file);

/// The method whose verdict a range of equation.json has; in folders of earlier versions, where no range says it, the
/// method that the run chose. Empty: there is none.
[[nodiscard]] std::string speaking_method(const nlohmann::ordered_json& equations, const nlohmann::ordered_json& range);

/// Of an equation's term: its name, "sgn(v) in run1.csv" where it is of one recording.
[[nodiscard]] std::string label_of(const nlohmann::ordered_json& term);

}  // namespace apps
