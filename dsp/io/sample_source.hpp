#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/filter/decimate.hpp"
#include "dsp/io/clock_kind.hpp"
#include "dsp/io/clock_start.hpp"
#include "dsp/values/recording.hpp"

namespace dsp {

/// What every reader gives, whatever the container: channels with name and unit, a clock or a rate, what was left out
/// and remarks. Columns are all there are, a time column included.
struct SourceInfo {
  std::string container;        ///< "RF64, 24 bit", "text, tab separated", "MATLAB v5"
  double sample_rate_hz = 0.0;  ///< 0: the file does not say
  std::int64_t num_frames = 0;
  std::vector<std::string> columns;  ///< cleaned names; all empty where the container has none
  std::vector<std::string> units;    ///< as the file writes them, empty where it does not
  std::vector<bool> partial;  ///< columns the file itself calls shorter than the rest; no channels unless asked for
  bool named = false;         ///< columns have names of their own
  bool scaled = false;        ///< integers read as fractions of full scale: values mean nothing without one
  int time_column = -1;       ///< the clock, -1: none
  ClockStart clock_start{};
  int num_runs = 1;                   ///< side by side in a table
  std::vector<Interval> gaps;         ///< intervals the clock skips; filled by straight lines
  std::vector<std::string> left_out;  ///< what else the file holds and why it is no column
  std::vector<Check> checks;
};

struct OpenOptions {
  bool salvage = false;  ///< read what is left of a truncated or unfinished file
  std::size_t max_memory_bytes = std::size_t{4}
                                 << 30;  ///< for formats that must be held whole, and what they expand to
  std::string time_column{};        ///< text: name or 1-based number of the clock; empty: found by name (t, time, ...)
  std::string time_unit{};          ///< of that column; empty: from its name, else s
  std::optional<double> rate_hz{};  ///< the rate a person stated; needed where the clock is too coarse, or interpolated
  ClockKind clock = ClockKind::regular;        ///< else an irregular one is put on rate_hz by straight lines
  std::int64_t header_row = 0, skip_rows = 0;  ///< of a table: the line of names, lines not looked at; 0: found
  int run = 0;                                ///< which of several runs side by side in a table, from 1; 0: nobody said
  std::vector<std::string> signal_columns{};  ///< names or 1-based numbers of columns that are no clock
  bool with_clock = true;                     ///< false: rows as they are, whatever their times
  bool may_be_quoted = true;                  ///< messages may show what is in the file
  int num_threads = 1;  ///< above 1 a FLAC's MD5 has a thread of its own; changes nothing in what is read
};

/// Samples of one file, frame by frame, as the file holds them (integers as fractions of full scale).
class SampleSource {
 public:
  virtual ~SampleSource() = default;
  [[nodiscard]] const SourceInfo& info() const& { return info_; }
  void info() const&& = delete;
  /// Makes `block` the next frames, at most max_frames x num_columns; returns how many, 0 at the end. The frames do not
  /// depend on max_frames. Missing values are NaN. Throws Fault (input).
  virtual Eigen::Index read(FrameBlock& block, Eigen::Index max_frames) = 0;
  /// Has `read` multiply every column by its scale and shift it, rounded after either. False: this source does not, and
  /// the caller has to.
  [[nodiscard]] virtual bool calibrate(const Eigen::VectorXd& scales, const Eigen::VectorXd& shifts);
  /// Leaves out the next frames, which need not be whole then; returns how many, fewer at the end only.
  virtual Eigen::Index skip(Eigen::Index num_frames);
  void add_check(Check check) { info_.checks.push_back(std::move(check)); }

 protected:
  SourceInfo info_;
};

/// What is read, for messages.
inline constexpr std::string_view readable_formats =
    "sound files (WAV, RF64, W64, CAF, FLAC, AIFF), MATLAB, HDF5, NumPy (npy, npz), TDMS, UFF, JSON, CSV and "
    "LabVIEW text";

/// Opens a recording by its content, never by its name: all of readable_formats. Throws Fault (input): file.missing,
/// file.kind, file.empty, file.denied, container.unknown, container.truncated, container.lossy, container.limit, ...
[[nodiscard]] std::unique_ptr<SampleSource> open_source(const std::filesystem::path& file,
                                                        const OpenOptions& options = {});

}  // namespace dsp
