#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "dsp/filter/decimate.hpp"
#include "dsp/io/sidecar.hpp"
#include "dsp/values/recording.hpp"

namespace dsp {

struct ArrayContents;

struct ReadOptions {
  std::filesystem::path sidecar{};           ///< empty: NAME.ext.toml beside the recording, if there
  bool salvage = false;                      ///< read what is left of a truncated or unfinished file
  bool uncalibrated = false;                 ///< channels without a sensitivity stay raw and are marked so
  std::map<std::string, std::string> use{};  ///< role -> channel name, where several could play it or none says so
  std::size_t max_memory_bytes = std::size_t{4} << 30;
  int run = 0;          ///< which of several runs side by side in a table, from 1; 0: as the sidecar says
  int num_threads = 1;  ///< above 1 a FLAC's MD5 has a thread of its own; changes nothing in what is read
};

/// A recording as a stream of calibrated SI blocks: one or several files on one clock, and what their sidecar says of
/// them. Channels come in the sidecar's order; without a sidecar in the files', roles read off column names that are
/// roles
/// ("x", "y_mm", "ddr"). The frames delivered do not depend on the block size.
/// Throws Fault: calibration.missing (its lines() are those to add), channel.column, channel.length,
/// rate.mismatch, rate.missing, and whatever open_source and read_sidecar throw (input); channel.role, channel.name,
/// channel.index, unit.role (usage).
class RecordingReader {
 public:
  explicit RecordingReader(const std::filesystem::path& file, const ReadOptions& options = {});
  /// The same of arrays in memory (dsp/io/array_file.hpp), which must outlive it; nothing is copied but the block that
  /// is read. files() is its name. Throws also Fault channel.file (usage) where the sidecar names a file, and
  /// std::invalid_argument for options that are of files: sidecar, salvage, run.
  RecordingReader(ArrayContents arrays, const Sidecar& sidecar, const ReadOptions& options = {});
  ~RecordingReader();
  RecordingReader(RecordingReader&&) noexcept;
  RecordingReader& operator=(RecordingReader&&) noexcept;
  /// Name, rate, channels, and the bad intervals and checks known so far (all of them once read() has returned 0); no
  /// samples.
  [[nodiscard]] const Recording& description() const&;
  void description() const&& = delete;
  [[nodiscard]] const Sidecar& sidecar() const&;
  void sidecar() const&& = delete;
  [[nodiscard]] const std::string& container() const&;
  void container() const&& = delete;
  [[nodiscard]] const std::vector<std::filesystem::path>& files() const&;  ///< recording first, sidecar not among them
  void files() const&& = delete;
  [[nodiscard]] std::int64_t num_frames() const;
  /// Makes `block` the next frames, at most max_frames x channels; returns how many, 0 at the end. Gaps (NaN, Inf)
  /// are bridged by straight lines and noted in description().bad. Throws Fault sample.missing, sample.huge
  /// (input).
  Eigen::Index read(FrameBlock& block, Eigen::Index max_frames);
  /// Memory that whoever reads takes beside the reader. It is counted where frames must be held until a late channel
  /// begins: read() throws Fault memory.limit (numerics) before both would pass ReadOptions::max_memory_bytes.
  void set_bytes_beside(double bytes);
  /// Leaves out the next frames, without looking at them where the files allow; returns how many, fewer at the end
  /// only.
  Eigen::Index skip(Eigen::Index num_frames);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The whole recording in memory. Throws Fault memory.limit (numerics) before it would pass max_memory_bytes.
[[nodiscard]] Recording read_recording(const std::filesystem::path& file, const ReadOptions& options = {});
/// The same of a reader that is open and at its beginning.
[[nodiscard]] Recording read_recording(RecordingReader& reader, std::size_t max_memory_bytes);

/// How many runs side by side a recording holds; 1 for any but a table of several. Throws as open_source does.
[[nodiscard]] int count_runs(const std::filesystem::path& file, const Sidecar& sidecar);

/// A first sidecar for a recording: what its files say filled in, the rest commented out.
[[nodiscard]] std::string draft_sidecar(const std::filesystem::path& file, const ReadOptions& options = {});

}  // namespace dsp
