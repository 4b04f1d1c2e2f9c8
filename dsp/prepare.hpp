#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/decimate.hpp"
#include "dsp/filter/column_filter.hpp"
#include "dsp/motion.hpp"
#include "dsp/recording.hpp"
#include "dsp/samples/raw_spectrum.hpp"
#include "dsp/sensors/sensor_consistency.hpp"

namespace dsp {

class RecordingReader;

enum class Recipe {
  matched,  ///< columns are formed first, on wide-band signals, and filtered after, each by the filter of the target
  paper,    ///< signals are filtered first and columns formed from them, as in [QZS23]
};

struct PrepareOptions {
  Recipe recipe = Recipe::matched;
  double rate_hz = 0.0;     ///< regression rate; 0: the record's own
  double cutoff_hz = 0.0;   ///< 0: 0.4 x regression rate. Derivatives go to zero here; so do columns at the record's
                            ///< own rate; decimated columns are flat up to here and gone at 1.25 x cutoff
  double rolloff_hz = 0.0;  ///< where the taper begins; 0: 0.78125 x cutoff (8 of 10.24)
  double state_cutoff_hz = 0.0;  ///< band in which states are formed before their columns are filtered; 0: at the
                                 ///< record's own rate 0.49 x that, rolling off from 0.75 of it; when decimating
  double state_rolloff_hz =
      0.0;  ///< 20/10.24 x cutoff as far as the intermediate rate allows (0.4 x), rolling off from 0.64 of it
  double intermediate_rate_hz =
      0.0;  ///< rate at which columns are formed when decimating; 0: about 10 x regression rate
  AccelerationSource acceleration = AccelerationSource::automatic;
  double integrate_from_hz = 0.0;  ///< of a record without a displacement; 0: where its drift ends
  bool equalise = true;            ///< "matched": displacements and accelerometers of one body are equalised
  ScaleReference scale = ScaleReference::displacement;
  bool operator==(const PrepareOptions&) const = default;
};

/// A recording ready for regression.
struct Prepared {
  std::string name;
  PrepareOptions options;  ///< with every default filled in
  Motion intermediate;     ///< wide-band signals at the intermediate rate: columns are formed from these ("matched")
  Motion signals;          ///< the same signals low-passed, at the regression rate: prepared.csv, conditions, free run;
                           ///< columns of recipe "paper"
  ColumnFilter filter;     ///< from intermediate to regression rate, with the high-pass that all accelerometers share
  std::vector<double> highpass_hz;          ///< its cut-offs; none: columns keep their means
  std::vector<Channel> channels;            ///< of the recording
  std::optional<FilterSheet> decimation;    ///< from the recording to the regression rate
  std::vector<SensorRelation> relations;    ///< between displacement and accelerometer of base and payload
  std::vector<SensorRelation> derivatives;  ///< between other channels one of which is the other's derivative
  Eigen::VectorXd raw_v, raw_a;             ///< at the regression rate, before the sensors were equalised; for the
                                            ///< power check; empty where they were not
  bool x_is_difference = false;             ///< x = y - r of two displacements, whose zeros mean nothing
  /// The channels of x or its derivatives at the intermediate rate, nothing but decimated and brought to one clock,
  /// with the intervals that must not be used, without margins; null where x is a difference, or all was filtered
  /// first.
  std::shared_ptr<const Recording> recorded;
  /// The other channels in the same way, where x is integrated, which takes what is slow from the signals of all; else
  /// null.
  std::shared_ptr<const Recording> recorded_beside;
  std::vector<Interval> excluded;  ///< with margins and reasons; marked in both motions
  std::vector<Interval> clipped;   ///< of these, the clipped ones without margins; why: the channel's name
  std::vector<Check> checks;
  /// nullptr where the recording has none.
  [[nodiscard]] const Channel* channel(Role role) const&;
  void channel(Role) const&& = delete;
  /// Whether x was integrated, from options.integrate_from_hz on, as no displacement was recorded.
  [[nodiscard]] bool integrated() const;
  /// Whether the relations were used: only "matched" does, unless asked not to.
  [[nodiscard]] bool equalised() const { return options.recipe == Recipe::matched && options.equalise; }
};

/// The options with nothing left to choose for a recording at this rate. The intermediate rate divides the recording's
/// rate and is a multiple of the regression rate where there is such a rate between 5 and 20 times the latter. Throws
/// Fault (usage) for rates and frequencies that do not fit each other.
[[nodiscard]] PrepareOptions resolved(const PrepareOptions& options, double sample_rate_hz);

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
