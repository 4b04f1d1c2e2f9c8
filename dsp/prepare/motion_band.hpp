#pragma once
#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dsp/prepare/prepared.hpp"
#include "dsp/samples/raw_spectrum.hpp"

namespace dsp {

class RecordingReader;

/// One-sided power spectrum of a motion and where in it the motion lies.
struct MotionBand {
  std::string signal;    ///< what was looked at: "y - r", "x", "ddy", ...; empty: none is a motion, or it is too slow
  int order = 0;         ///< of it: 0 displacement, 1 velocity, 2 acceleration
  double peak_hz = 0.0;  ///< where most of the motion is
  double from_hz = 0.0;  ///< of order 1 and 2: below, drift integrated to a displacement exceeds the motion
  double to_hz = 0.0;    ///< above, noise derived twice grows faster than the motion falls off
  double nyquist_hz = 0.0;    ///< to_hz is this where the motion is above its noise up to the end of the band
  double bin_hz = 0.0;        ///< of `density`
  Eigen::VectorXd density{};  ///< of `signal`, bins from 0 Hz on, in any unit; of a slow motion they end sooner
  int hold_samples = 1;  ///< the channel is slower than the clock (HoldLength): all of this is below its own rate's
  double noise = 0.0;    ///< density of the noise at to_hz, likewise; 0: not seen
  /// Fraction of the acceleration's power, noise apart, that lies below cutoff_hz: 1 from to_hz on.
  [[nodiscard]] double kept_fraction(double cutoff_hz) const;
};

/// The band of a motion from its power a bin. The acceleration's spectrum falls with the motion and rises with the
/// noise of a sensor, that of a displacement by f^4: its least value, averaged over a sixth of an octave either way and
/// over two harmonics of the motion at least, parts them, but for tones beyond a gap that win more motion than noise.
/// No floor has to be seen and none has to be flat. Of a measured acceleration, whose noise does not rise, the spectrum
/// is derived once more. Nothing (no signal) where most of the motion is slower than the bins resolve.
[[nodiscard]] MotionBand motion_band(std::string signal, int order, Eigen::VectorXd density, double bin_hz);

/// The same of a recording's motion: x, y - r where both were recorded, y; else the velocity or the acceleration. Reads
/// quarters of the record, or some tens of pieces of a long one; of a motion too slow for those, all of it or eighths,
/// of means of several samples where they are too many for a spectrum. `open` begins at the first frame each time.
/// Throws as RecordingReader::read does.
[[nodiscard]] MotionBand find_motion_band(const std::function<RecordingReader()>& open);

/// The same of the channel that shows most of the motion, from spectra that were gathered on the way: of y rather than
/// y - r.
[[nodiscard]] MotionBand motion_band_of_channels(const std::vector<Channel>& channels, const RawSpectrum& spectrum);

/// The length of the segments that spectra of a record are first taken of: a quarter of it, or as many samples as a
/// spectrum takes. Nothing about a record is decided by a length in seconds: times printed in ms are as good.
[[nodiscard]] double usual_segment_s(Eigen::Index num_frames, double sample_rate_hz);

/// Its segments held too few periods of the motion to part it from what Hann's window leaves of a mean.
[[nodiscard]] bool is_unresolved(const MotionBand& band);

/// Of a motion too slow for those: the spectrum of the whole recording, or of eighths of a long one.
[[nodiscard]] RawSpectrum spectrum_of_slow(const Recording& recording);

/// Of a record, at either end, what the reach of an integral's high-pass, two of its periods, may take.
inline constexpr double most_lost_to_integral = 0.1;

/// From where on the velocities and accelerations of bodies without a displacement can be integrated: above the drift
/// of each, and so that no more than a tenth of the record is lost at either end unless the motion is slower; 0 where
/// none moves.
[[nodiscard]] double integration_from_hz(const std::vector<Channel>& channels, const RawSpectrum& spectrum,
                                         double duration_s);

/// prepare.cutoff_hz for a motion, so that columns are flat up to its end; 0 where the record's band ends first.
[[nodiscard]] double cutoff_for(const MotionBand& band);

/// rate_hz, where it is left open and cutoff_hz is not: the least whole part of the record's rate with short filters
/// that is at least 2.5 times cutoff_hz.
[[nodiscard]] PrepareOptions rate_by_cutoff(PrepareOptions options, double sample_rate_hz);

/// "prepare.band": what of the motion the columns keep; a warning below 95 %.
[[nodiscard]] Check band_check(const MotionBand& band, double cutoff_hz);

}  // namespace dsp
