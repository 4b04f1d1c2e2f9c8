#include "apps/process/simulation_folder.hpp"

#include <string>
#include <system_error>

#include "apps/process/system_fault.hpp"
#include "dsp/io/sidecar.hpp"
#include "dsp/io/sound_file.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

constexpr const char* truth_name = "truth.json";  // written last: it is there if the simulation is complete

bool holds_simulation(const fs::path& folder) {
  std::error_code unknown;
  return fs::exists(fs::symlink_status(folder / truth_name, unknown));
}

void remove_file(const fs::path& path) {
  std::error_code error;
  fs::remove(path, error);
  if (error) throw cannot_write(path, error.value());
}

}  // namespace

void require_no_simulation(const fs::path& folder, bool force) {
  if (!force && holds_simulation(folder))
    throw output_fault("output.exists", folder,
                       "holds a simulation. Use --force to replace it or -o to write elsewhere");
}

void clear_simulation(const fs::path& folder) {
  using enum dsp::SoundContainer;
  if (!holds_simulation(folder)) return;
  remove_file(folder / truth_name);
  for (const char* name : {"response.csv", "truth.csv", "frc.csv", "frc.json", "frc.svg"}) remove_file(folder / name);
  for (const auto container : {rf64, w64, caf, flac, aiff}) {  // rf64: recording.wav, as wav
    const fs::path recording = folder / ("recording." + dsp::extension(container));
    remove_file(recording);
    remove_file(dsp::sidecar_path(recording));
  }
}

}  // namespace apps
