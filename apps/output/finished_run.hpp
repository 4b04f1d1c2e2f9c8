#pragma once
#include <filesystem>
#include <string>

#include "apps/config/config.hpp"
#include "apps/output/manifest.hpp"
#include "apps/process/console.hpp"

namespace apps {

/// A folder that a run finished. Each file in it that is missing or has changed since is named by a warning
/// ("run.changed"), where `strict` refused. Throws dsp::Fault (input): "run.incomplete" without a manifest.json, which
/// is written last; "run.damaged", "strict.warning".
void check_finished_run(const std::filesystem::path& run, bool strict, Console& console);

/// The name that a run fitted the recording with these bytes under, whatever it is called now; empty: it was not
/// fitted. `config`: of the run folder.
[[nodiscard]] std::string fitted_name(const Manifest& run, const Config& config, const std::string& sha256);

/// Has the recordings of a run folder's config called as the run called them, wherever they lie by now.
void take_names(const Manifest& run, Config& config);

}  // namespace apps
