#pragma once
#include <Eigen/Core>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/filter/spectral.hpp"
#include "dsp/values/recording.hpp"

namespace dsp {

/// One signal of a motion: its name in candidate terms ("x", "v", "ddr", ...), its SI unit, its samples.
struct Signal {
  std::string name, unit;
  Eigen::VectorXd values;
  double flat_to_hz = std::numeric_limits<double>::infinity();  ///< a derivative that was computed ends above
};

/// Named signals on one clock: what candidate terms, targets and conditions are evaluated on.
/// Sample i is at i / sample_rate_hz seconds from the start of the record.
struct Motion {
  double sample_rate_hz = 0.0;
  std::vector<Signal> signals;            ///< t first; all of one length
  std::vector<unsigned char> excluded;    ///< per sample: 1 where the data must not be used (faults with their margins)
  Eigen::Index edge_samples = 0;          ///< at either end: spoilt by filter and derivative ends; not in `excluded`
  std::vector<std::string> uncalibrated;  ///< channels of raw numbers; signals that may rest on one have no unit
  double dropped_power_fraction = 0.0;    ///< fraction of the displacement's power above the band edge
  [[nodiscard]] Eigen::Index num_samples() const { return signals.empty() ? 0 : signals.front().values.size(); }
  /// nullptr if there is no such signal.
  [[nodiscard]] const Signal* find(std::string_view name) const&;
  void find(std::string_view) const&& = delete;
  /// Throws std::invalid_argument that lists the names there are.
  [[nodiscard]] const Eigen::VectorXd& at(std::string_view name) const&;
  void at(std::string_view) const&& = delete;
};

/// Where the acceleration a = d2x/dt2 comes from.
enum class AccelerationSource {
  automatic,  ///< ddy - ddr where both accelerometers exist, else the second derivative of x
  accelerometer,
  displacement,
};

struct MotionOptions {
  SpectralBand band;  ///< required: derivatives are flat below rolloff_hz and zero above cutoff_hz
  ExtensionOptions extension;
  AccelerationSource acceleration = AccelerationSource::automatic;
  double integrate_from_hz = 0.0;  ///< required where no displacement was recorded
};

/// How far the high-pass of an integral reaches, in periods of integrate_from_hz.
inline constexpr double integral_reach_periods = 2.0;

/// Whether x was recorded, or y and r, or y where nothing of a base was.
[[nodiscard]] bool has_displacement(const Recording& recording);

/// From the channels of one recording to x = y - r (Eq. 49 of [QZS23]; x = y where there is no base channel), v, a, and
/// whatever else was measured or follows by differentiation (r dr ddr y dy ddy f z and channels without a role, by
/// name). Derivatives are taken over the whole record in the frequency domain; a measured derivative is preferred to a
/// computed one. Displacements are not filtered. Where none was recorded, velocities or accelerations are integrated
/// from integrate_from_hz on, and every signal of the motion ends there alike (gain 1 above, raised cosine down to 0 at
/// half of it). Channel delays are removed. The recording's bad intervals are excluded
/// without margins. `edge_samples` is the length of the band's impulse response, 1 / (cutoff_hz - rolloff_hz). Throws
/// Fault if no motion was recorded, std::invalid_argument for a band that does not fit below the Nyquist frequency or
/// where integrate_from_hz is needed and does not fit below the band.
[[nodiscard]] Motion relative_motion(Recording recording, const MotionOptions& options);

/// Advances every channel by the lag it is known to have, and says so in its description.
void remove_delays(Recording& recording, const ExtensionOptions& extension = {});

/// Excludes the samples of an interval widened by margin_s at both ends.
void mark(Motion& motion, const Interval& interval, double margin_s = 0.0);

}  // namespace dsp
