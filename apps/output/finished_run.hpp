#pragma once
#include <filesystem>
#include <string>

#include "apps/config/config.hpp"
#include "apps/process/console.hpp"

namespace apps {

/// A folder that a run finished. Each file in it that is missing or has changed since is named by a warning
/// ("run.changed"), where `strict` refused. Throws dsp::Fault (input): "run.incomplete" without a manifest.json, which
/// is written last; "run.damaged", "strict.warning".
void check_finished_run(const std::filesystem::path& run, bool strict, Console& console);

/// The name that the run fitted this very recording under, by its bytes, whatever it is called now; empty: it was not
/// fitted. `config`: of the run folder.
[[nodiscard]] std::string fitted_name(const std::filesystem::path& run, const Config& config,
                                      const std::filesystem::path& recording);

}  // namespace apps
