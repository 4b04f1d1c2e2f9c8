#pragma once
#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dsp/prepare.hpp"
#include "dsp/prepare/power_check.hpp"
#include "dsp/regimes/common_motion.hpp"
#include "dsp/segment_regimes.hpp"
#include "ident/ranges/ranges.hpp"
#include "ident/sensors/sensor_parameters.hpp"

namespace ident {

/// A correction of the base's signals: by how much they are scaled, and led.
struct BaseCorrection {
  double gain = 0.0, lead_s = 0.0;
};

/// A prepared recording with its amplitude regimes: what ranges are cut from.
struct Record {
  dsp::Prepared prepared;
  dsp::Segmentation segmentation;        ///< at the intermediate rate; no segments: regimes were not looked for
  std::vector<dsp::Regime> regimes;      ///< of each row, stops with their reach; empty likewise
  dsp::Mount mount;                      ///< by whose response the payload's signals were divided
  std::optional<dsp::PowerCheck> power;  ///< where displacement and acceleration of one body were measured
  std::optional<dsp::CommonMotion> common_motion;  ///< by which the base's signals were corrected
  std::array<BaseCorrection, 2> base_by_mount;     ///< how that correction changes with a MountParameter, for one unit
  bool zero_is_known = false;                      ///< of x: a person stated it
  bool zero_is_fitted = false;                     ///< it is found with the equation, whatever its channels say
  double zero = 0.0;                               ///< what was subtracted from the displacement as recorded, its unit
  std::vector<dsp::RangeSpec> ranges;              ///< that a person named; none: they follow from the regimes
};

/// Up to where the mount's response is undone.
[[nodiscard]] dsp::SpectralBand mount_band(const dsp::Prepared& prepared);

/// Gives the record these regimes, the power check in each of them, and the checks that follow ("power.balance",
/// "regime.left_out", "regime.no_motion", "regime.ground"). Where the sensors were equalised, what a mount that rings
/// adds to the payload's signals is taken off ("sensors.mount"). Where base and payload move as one, their displacement
/// sensors, once brought to agree with the accelerometers, are brought to agree with one another
/// ("sensors.common_motion").
void set_regimes(Record& record, dsp::Segmentation segmentation);

/// The same with the regimes found in the record (dsp::segment_regimes), on up to num_threads threads.
void find_regimes(Record& record, const dsp::SegmentOptions& options = {}, int num_threads = 1);
[[nodiscard]] Record find_regimes(dsp::Prepared prepared, const dsp::SegmentOptions& options = {});

/// The ranges of records for which nobody named any: low, high and mixed where there are two regimes of motion and each
/// lasts a tenth of it at least; the one there is where it sticks at times; else "all". Of several records each has its
/// own, named after it, and all together have "all recordings".
[[nodiscard]] std::vector<Range> default_ranges(const std::vector<const Record*>& records);

/// Whether a signal moves and is no motion of the system itself: the base's acceleration, a force, and further channels
/// in units of what drives a machine (N, N*m, Pa, V, A). What else was recorded may as well be another sensor on the
/// same motion.
[[nodiscard]] bool acts_from_outside(const dsp::Signal& signal);

/// What a library of polynomials in x and v cannot do without: dry friction, sgn(v), and what drives the motion from
/// outside in one of the records, as far as all have it.
[[nodiscard]] std::vector<std::string> default_terms(const std::vector<const Record*>& records);

/// Warnings "input.not_everywhere" about what drives the motion in one of the records and was not recorded in another:
/// no term of an equation of all of them can hold it.
[[nodiscard]] std::vector<dsp::Check> inputs_of_some(const std::vector<const Record*>& records);

/// Mean of x (m) over the first range of the recording with this 1-based number; where that is of a regime, over its
/// first run. Lasers' zeros mean nothing, so this is what is subtracted from a difference of two.
[[nodiscard]] double mean_of_first_range(const Record& record, const std::vector<Range>& ranges, int recording);

/// Parameters of a record's sensors, in the units of its displacement sensors. None in recipe "paper", where the
/// accelerometers set the scale, or where a displacement and the accelerometer beside it could not be brought to agree:
/// how wrong they are is not known then.
/// Displacements of base and payload: their relative gain (standard deviation as their channels say, 1 % each, or what
/// intervals of common motion leave), the zero of x (1 % of its channels' range, or of what they read) and its drift,
/// piecewise linear every 300 s (as the channels say, or as x is seen to wander). A displacement without a base keeps
/// its own zero, about which even powers of x are terms of the equation: its zero (1 % of the range) and its drift are
/// uncertain only where the channel states a range or a drift. A zero that a person stated is known. A force: its lag
/// (1 / sqrt(12) of the recording's sample interval: channels scanned in turn). No gain of a lone displacement or of a
/// force: its column is a candidate's own (c f); it is one of absolute_gains.hpp. Where the acceleration was measured,
/// each displacement beside an accelerometer: a lag; the accelerometer: the sum of the cut-offs of its coupling and its
/// gain; all to the standard deviation of their relation. Where base and payload were seen to move as one, the base's
/// lag is that to the payload's sensor. (An acceleration computed from the displacements is late as they are.)
[[nodiscard]] std::vector<SensorParameter> sensor_parameters(const Record& record);

/// The signals of a recording in the coordinates of an equation: x less `zero`, and f as it was recorded `lead_s`
/// later, to first order.
[[nodiscard]] dsp::Motion in_coordinates(dsp::Motion motion, double zero, double lead_s);

/// form_columns of a record, with its regimes, power check and sensor parameters. Throws dsp::Fault (numerics)
/// memory.limit where fitting them would take more than max_memory_bytes, memory.exhausted; as form_columns.
[[nodiscard]] Columns record_columns(const CandidateLibrary& library, const std::string& target, const Record& record,
                                     std::size_t max_memory_bytes = dsp::StreamOptions{}.max_memory_bytes,
                                     const std::function<void()>& poll = {}, int num_threads = 1);

}  // namespace ident
