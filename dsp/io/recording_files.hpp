#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "dsp/io/read_recording.hpp"
#include "dsp/io/sample_source.hpp"
#include "dsp/io/sidecar.hpp"
#include "dsp/values/faults.hpp"

namespace dsp {

/// One file of a recording, open.
struct OpenFile {
  std::filesystem::path path;
  std::string name;
  std::unique_ptr<SampleSource> source;
  FrameBlock block;
  bool may_be_quoted = true;                     ///< messages may show what is in it
  std::unordered_map<std::string, int> columns;  ///< by name, with its unit and without; the first of each
  std::vector<std::string> called;               ///< "channel3": what columns without names are called
};

/// What a sidecar is asked to say where nothing else says the rate. Nobody's rate is "?": pasted as it is, it is
/// refused.
inline constexpr std::string_view rate_line = "rate = \"?\"  # samples a second, in Hz";

/// The recording itself, if any channel lies in it, and every file its channels name, each once. Where a clock does not
/// do, that is added to `faults` and all are opened without clocks, so that what else is wrong can be found.
[[nodiscard]] std::vector<OpenFile> open_files(const std::filesystem::path& recording, const Sidecar& sidecar,
                                               const ReadOptions& options, Faults& faults);

/// Arrays in memory as the one file of a recording. Throws Fault (usage) channel.file where the sidecar names another.
[[nodiscard]] OpenFile open_in_memory(ArrayContents arrays, const Sidecar& sidecar, const ReadOptions& options);

/// A channel for every column that is neither the clock nor shorter than the rest; a name that is a role is one.
[[nodiscard]] std::vector<ChannelSpec> channels_of(const OpenFile& file);
/// 0-based column of a channel, which is the `index_in_file`-th of its file. Throws Fault channel.column,
/// channel.index.
[[nodiscard]] int find_column(const ChannelSpec& channel, const OpenFile& file, int index_in_file);

/// The one rate of all files; a whole rate of a sound file may be the sidecar's, rounded. Throws Fault rate.mismatch,
/// rate.missing.
[[nodiscard]] double agree_on_rate(const std::vector<OpenFile>& files, const Sidecar& sidecar);
/// The one length; with `salvage` the shortest, and a warning. Throws Fault channel.length, recording.empty.
[[nodiscard]] std::int64_t agree_on_length(const std::vector<OpenFile>& files, bool salvage,
                                           std::vector<Check>& checks);
/// Where the first file's clock begins. Throws Fault clock.start if another begins more than half a sample earlier or
/// later, or on another day where both say theirs; beyond a hundredth, `checks` say that its channels are shifted.
[[nodiscard]] ClockStart agree_on_start(const std::vector<OpenFile>& files, double rate_hz, std::vector<Check>& checks);
/// How much later than `start` a file begins, where that is worth a shift; 0 without a clock.
[[nodiscard]] double late_start_s(const OpenFile& file, const ClockStart& start, double rate_hz);

}  // namespace dsp
