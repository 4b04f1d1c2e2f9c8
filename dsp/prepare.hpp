#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "dsp/prepare/prepared.hpp"
#include "dsp/samples/raw_spectrum.hpp"

namespace dsp {

class RecordingReader;

/// From a recording in memory to signals ready for regression: decimated to the intermediate rate, faulty samples
/// filled, sensors equalised, derivatives over the whole record before anything is cut.
/// "matched": signals at the intermediate rate are formed in the wide state band; target and columns then pass
/// `filter`.
/// "paper": signals are filtered and decimated first and differentiated after, in the band [rolloff_hz, cutoff_hz];
/// sensors stay as they are.
/// The recording's bad intervals are excluded with the reach of the filters as margin, and where columns are
/// high-passed its start, 2 / cut-off long. Edge samples, which lean on linear prediction beyond the ends, are counted
/// (Motion::edge_samples, check "prepare.edges") and not marked: who gathers rows leaves them out. Throws Fault for a
/// recording that cannot be used so: sample.constant (input) where a channel the motion rests on shows one value only,
/// ...
[[nodiscard]] Prepared prepare(const Recording& recording, const PrepareOptions& options);

struct StreamOptions {
  Eigen::Index block_frames = 16384;  ///< read at a time; changes nothing in the result
  std::size_t max_memory_bytes = std::size_t{4} << 30;
  std::function<void(double)> progress = {};  ///< called with the fraction read so far; may throw to stop
  int num_threads = 1;                        ///< at work at a time; changes nothing in the result
};
/// The same, block by block from a file, in memory that grows with the samples at the intermediate rate only. Throws
/// Fault memory.limit (numerics) before it would pass max_memory_bytes.
[[nodiscard]] Prepared prepare(RecordingReader& reader, const PrepareOptions& options,
                               const StreamOptions& stream = {});

/// A recording brought down to the intermediate rate: all that preparation needs of its file.
struct IntermediateRecording {
  Recording recording;                    ///< at the intermediate rate, faulty samples filled and in `bad`
  double input_rate_hz = 0.0;             ///< of the file
  std::optional<DecimateOptions> filter;  ///< from the file to the intermediate rate; none: kept at its own rate
  std::optional<FilterSheet> sheet;       ///< of that filter
  RawSpectrum spectrum;                   ///< of the file's samples
  std::vector<Interval> clipped;          ///< as in Prepared
};

/// Fewest samples that can be prepared so: what the filters reach over.
[[nodiscard]] std::int64_t fewest_samples(const PrepareOptions& options, double sample_rate_hz);

/// One pass over a file for several ways of preparing it: a recording at the intermediate rate for each of `options`,
/// one and the same where they ask for the same filter. Throws as prepare does.
[[nodiscard]] std::vector<std::shared_ptr<IntermediateRecording>> read_intermediate(
    RecordingReader& reader, const std::vector<PrepareOptions>& options, const StreamOptions& stream = {});
/// The same, bit for bit, as from the file. Throws std::invalid_argument for one filled for other options.
[[nodiscard]] Prepared prepare(IntermediateRecording intermediate, const PrepareOptions& options, int num_threads = 1);

/// A signal as target or column of the regression: the signal at the intermediate rate through the column filter
/// ("matched"), the signal itself ("paper"). Without a high-pass both are the signal at the regression rate. Throws
/// std::invalid_argument for a name that is no signal.
[[nodiscard]] Eigen::VectorXd regression_signal(const Prepared& prepared, std::string_view name);

/// Mean of x at the intermediate rate over [from_s, to_s), excluded samples left out; 0 where there are none.
[[nodiscard]] double mean_displacement(const Prepared& prepared, double from_s, double to_s);

/// Subtracts `zero_m` from x, before and after the column filter alike (a laser's zero means nothing).
void set_displacement_zero(Prepared& prepared, double zero_m);

}  // namespace dsp
