#include "apps/config/recording_runs.hpp"

#include <filesystem>
#include <utility>

#include "dsp/io/read_recording.hpp"
#include "dsp/io/sidecar.hpp"

namespace apps {
namespace {

/// How many runs are asked for, 0 where it is one or none.
int runs_asked_for(const RecordingConfig& recording) {
  const auto file = recording.sidecar.empty() ? dsp::sidecar_path(recording.file) : recording.sidecar;
  std::error_code unknown;
  if (recording.run > 0 || (recording.run == 0 && !std::filesystem::exists(file, unknown))) return 0;
  try {
    const dsp::Sidecar sidecar = std::filesystem::exists(file, unknown) ? dsp::read_sidecar(file) : dsp::Sidecar();
    const int run = recording.run != 0 ? recording.run : sidecar.run;
    return run == dsp::all_runs ? dsp::count_runs(recording.file, sidecar) : 0;
  } catch (const dsp::Fault&) {
    return 0;
  }
}

}  // namespace

void take_runs_apart(std::vector<RecordingConfig>& recordings) {
  std::vector<RecordingConfig> apart;
  for (RecordingConfig& recording : recordings) {
    const int count = runs_asked_for(recording);
    for (int run = 1; run <= count; ++run) {
      apart.push_back(recording);
      apart.back().run = run;
    }
    if (count == 0) apart.push_back(std::move(recording));
  }
  recordings = std::move(apart);
}

}  // namespace apps
