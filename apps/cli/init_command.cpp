#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <memory>
#include <optional>

#include "apps/cli/command.hpp"
#include "apps/output/results_json.hpp"
#include "apps/output/staging_folder.hpp"
#include "apps/process/output_file.hpp"
#include "apps/process/system_fault.hpp"
#include "dsp/io/read_recording.hpp"
#include "dsp/io/settings.hpp"
#include "ident/regression/methods.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

/// `sidecar` empty: it lies beside the recording, where it is looked for.
std::string draft_config(const std::string& recording, const std::string& sidecar) {
  std::vector<std::string_view> methods;
  for (const ident::Method method : ident::default_methods()) methods.push_back(to_string(method));
  return fmt::format(R"toml(schema = 1

[[recording]]
file = {}
{}
# [prepare]
# cutoff_hz = 10.24      # columns and derivatives end here; left out: where the motion falls below its noise
# rate_hz = 25.6         # of the regression; left out: follows cutoff_hz
# zero = "fit"           # where x = 0: found with the equation; or "mean", "none" or a number in metres

[library]
order = 3                # polynomials in x and v; sgn(v) and every recorded input are candidates too
# terms = ["abs(x)*x"]   # further candidates
# only = ["x", "v", "f"] # or these and no others

[fit]
target = "a"
methods = ["{}"]

# [[range]]              # left out: the amplitude regimes found in the record, else all of it
# name = "low"
# from = 0               # s
# to = 830
# train_to = 500         # left out: the first 60 % are for training
# where = "abs(v) > 0.004"
)toml",
                     dsp::toml_quoted(recording),
                     sidecar.empty() ? "" : fmt::format("sidecar = {}\n", dsp::toml_quoted(sidecar)),
                     fmt::join(methods, "\", \""));
}

void require_replaceable(const Folder& folder, const std::string& name, bool force) {
  const std::optional<FolderEntry> entry = folder.entry(name);
  if (!entry || !entry->is_file())
    throw output_fault("output.foreign", folder.shown() / name,
                       "exists and is not a file. Choose another place with -o");
  if (!force) throw taken_at(folder.shown() / name);
}

/// A file that is there stays unless `force`: dsp::Fault (output, "output.exists").
void init(const fs::path& recording, const fs::path& folder, bool force, Console& console) {
  const fs::path place = folder.empty() ? dsp::sidecar_path(recording).parent_path() : folder;
  const fs::path sidecar = place / dsp::sidecar_path(recording.filename()),
                 config = place / recording.stem().concat(".toml");
  const std::string sidecar_text = dsp::draft_sidecar(recording);
  const fs::path from_config = fs::absolute(recording).lexically_proximate(fs::absolute(config).parent_path());
  const bool beside = !from_config.has_parent_path();
  const std::vector<std::string> names{sidecar.filename(), config.filename()};
  StagingFolder staging(
      sidecar, [force](const Folder& there, const std::string& name) { require_replaceable(there, name, force); });
  for (const std::string& name : names) staging.require_free(name);
  write_file(staging.fresh(), names[0], sidecar, sidecar_text);
  write_file(staging.fresh(), names[1], config,
             draft_config(from_config.generic_string(), beside ? "" : sidecar.filename().string()));
  staging.place(names);
  console.result(console.json() ? files_json({sidecar.string(), config.string()})
                                : fmt::format("wrote {} and {}\n", sidecar.string(), config.string()));
}

}  // namespace

Command init_command() {
  const auto recording = std::make_shared<fs::path>();
  return {.name = "init",
          .help = "A first sidecar and config for a recording",
          .group = look_group,
          .unused = {{"--seed"}, {"--dry-run"}, {"--set"}, {"--threads"}},
          .options = {{"FILE", recording.get(), "Recording.", {.required = true, .is_recording = true}}},
          .run =
              [recording](const GlobalOptions& global, Console& console) {
                init(*recording, global.output, global.force, console);
                return 0;
              },
          .examples = {"ardent init drive.wav", "ardent init drive.wav -o project --force"}};
}

}  // namespace apps
