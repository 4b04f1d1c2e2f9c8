#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/config/config.hpp"
#include "apps/process/console.hpp"
#include "dsp/io/sidecar.hpp"
#include "dsp/prepare.hpp"
#include "dsp/prepare/motion_band.hpp"
#include "ident/records/record.hpp"

namespace dsp {
struct ReadOptions;
}
namespace apps {

/// A recording of a config, read and prepared, and where it came from.
struct Input : ident::Record {
  std::vector<std::filesystem::path> files;  ///< all that were read: recording, further files, sidecar
  std::string sidecar;                       ///< name of its sidecar, there or not
  std::vector<dsp::ChannelSpec> channels;    ///< of its sidecar
  double recorded_rate_hz = 0.0;             ///< of the file
};

/// The inputs themselves, as the library takes them.
[[nodiscard]] std::vector<const ident::Record*> records_of(const std::vector<Input>& inputs);
void records_of(const std::vector<Input>&&) = delete;

/// Warnings and notes of a recording, to the console.
void report_checks(const std::vector<dsp::Check>& checks, const std::string& name, Console& console);

[[nodiscard]] dsp::ReadOptions read_options(const RecordingConfig& recording, std::size_t max_memory_bytes);

/// prepare.cutoff_hz where neither it nor a rate is given: by the motion of the recording that reaches highest; left
/// open where that is above its noise in the whole band. Every recording is looked through once.
void choose_band(Config& config, std::size_t max_memory_bytes, Console& console);

/// Of the recordings that are fitted, each looked through once.
struct RecordedBand {
  double sample_rate_hz = 0.0;
  dsp::MotionBand motion;
};
[[nodiscard]] std::vector<RecordedBand> recorded_bands(const Config& config, std::size_t max_memory_bytes);

/// prepare.cutoff_hz with which columns are gone from stop_hz on. Nothing where that leaves less of the motion of one
/// of the recordings than dsp::band_check wants, or where no band was found.
[[nodiscard]] std::optional<double> cutoff_below(double stop_hz, const std::vector<RecordedBand>& recordings);

/// Opens every recording as a run would, without reading on: throws all that is wrong with them and their sidecars.
void look_at_recordings(const Config& config, std::size_t max_memory_bytes);

/// The files a run would read, without reading them: recordings and sidecars that are there.
[[nodiscard]] std::vector<std::filesystem::path> input_files(const Config& config);

/// Reads and prepares every recording, one after the other, each on up to num_threads threads. Progress and warnings go
/// to the console.
[[nodiscard]] std::vector<Input> prepare_inputs(const Config& config, std::size_t max_memory_bytes, int num_threads,
                                                Console& console);

/// A recording of a config, read once for several ways of preparing it.
struct Source {
  Input described;                                                         ///< what does not depend on the way
  std::vector<std::shared_ptr<dsp::IntermediateRecording>> intermediates;  ///< for each way
};
/// `ways` replace config.prepare.
[[nodiscard]] std::vector<Source> read_sources(const Config& config, const std::vector<dsp::PrepareOptions>& ways,
                                               std::size_t max_memory_bytes, Console& console);
/// The same as prepare_inputs(config, ...) from the files, for sources read with config.prepare as number `way`.
[[nodiscard]] std::vector<Input> prepare_inputs(const std::vector<Source>& sources, std::size_t way,
                                                const Config& config, Console& console);

/// Fills in what the config left to the recordings: ranges (the sidecar's; else low, high and mixed where there are two
/// regimes of motion; the one there is where it sticks at times; else one "all", or one for each of several recordings,
/// named after it; each in two by the sign of v if asked for), further terms (sgn(v) and the inputs that all
/// recordings have, ident::default_terms), the zero of x, which is then subtracted, and the prepare options where all
/// recordings agree. Throws dsp::Fault (usage, "range.*") with the range's place.
void settle(Config& config, std::vector<Input>& inputs, Console& console);

}  // namespace apps
