#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "dsp/filter/column_spectra.hpp"

namespace dsp {

/// What a displacement sensor D and an accelerometer A on one body say of one another:
///   A / D = -(2 pi f)^2 sign gain e^{i 2 pi f lag} prod_k i f / (f_k + i f).
/// Only the ratio of their gains and the difference of their lags can be observed.
struct SensorRelation {
  std::string name;                        ///< "y and ddy"
  std::string displacement, acceleration;  ///< names of the channels
  double sign = 1.0;                       ///< -1: one of the two is upside down; gain is positive
  double gain = 1.0, gain_std = 0.0;
  double lag_s = 0.0, lag_std_s = 0.0;  ///< positive: the displacement comes later
  std::vector<double> highpass_hz,
      highpass_std_hz;               ///< one-pole cut-offs of the accelerometer's AC coupling, none to two
  double highpass_sum_std_hz = 0.0;  ///< of the cut-offs' sum, which is better known than each
  std::vector<double> declared_hz;   ///< cut-offs that the accelerometer's description names
  /// Of the fit, relative to the measured ratio; of derivatives, root of the fraction of power not common to both.
  double residual = 0.0;
  int num_windows = 0;
  std::string reason;  ///< not empty: the relation could not be found, and why
  /// Of a pair of any two of displacement, velocity and acceleration: how often the first of the two ("displacement")
  /// is differentiated already, and how often it has to be to become the second ("acceleration").
  int from_order = 0, order = 2;
  double calibration_std = 0.0;     ///< of the ratio of the gains, as both channels' calibrations leave it: a fraction
  bool sign_and_unit_only = false;  ///< lag and cut-offs were not looked for; the gain is the ratio of the rms
};

struct RelateOptions {
  double window_s = 40.0;  ///< Hann, half overlapping; windows with excluded samples are left out
  double from_hz = 0.7, to_hz = 6.0;
  int min_windows = 4;
  double pole_gain = 0.2;  ///< one more pole must lower the rms or the mean error by this fraction
};

/// Fits the relation to the cross-spectrum of two records of one length (SI, any rate), robustly (soft L1).
[[nodiscard]] SensorRelation relate_sensors(const Eigen::Ref<const Eigen::VectorXd>& displacement_m,
                                            const Eigen::Ref<const Eigen::VectorXd>& acceleration_m_per_s2,
                                            double sample_rate_hz, const std::vector<unsigned char>& excluded,
                                            const RelateOptions& options = {});

/// Which of the two sensors of a pair is believed in scale.
enum class ScaleReference { displacement, accelerometer };

/// The pairs r and ddr, y and ddy of a recording, as far as it has them, on up to num_threads threads; nothing is
/// changed.
[[nodiscard]] std::vector<SensorRelation> relate_pairs(ColumnSpectra& spectra,
                                                       const std::vector<unsigned char>& excluded, int num_threads = 1);

/// Every other pair of channels of one body of which one is the derivative of the other (x, v, a; r, dr, ddr; y, dy,
/// ddy), compared by sign and size alone, in the band that holds the motion: either may have been computed from the
/// other, so that a lag is no sensor's problem. Velocity is compared with acceleration where there is no
/// displacement.
[[nodiscard]] std::vector<SensorRelation> relate_derivatives(ColumnSpectra& spectra,
                                                             const std::vector<unsigned char>& excluded);

/// Whether lag and cut-offs of a pair can be corrected: the two were related, neither is upside down.
[[nodiscard]] bool can_be_corrected(const SensorRelation& relation);

/// No sensor's gain is off by more; a ratio beyond it is a wrong unit or a wrong sheet, and which of the two sensors is
/// right cannot be decided from it.
inline constexpr double largest_gain_error = 0.1;
[[nodiscard]] bool gain_is_plausible(const SensorRelation& relation);

struct Equalised {
  std::vector<SensorRelation> relations;  ///< base pair first, where there is one
  std::vector<double>
      highpass_hz;  ///< cut-offs that all accelerations now have in common; columns must be given them too
};
/// Brings the sensors of a recording to one clock, one scale and one high-pass, in its spectra: displacements are
/// advanced by their lag, accelerations (or displacements) rescaled where the gain is plausible, and the base
/// acceleration is brought to the payload's high-pass (below 0.02 Hz to zero), which is never inverted. Channels of
/// roles r, ddr, y, ddy; a pair that cannot be related, or whose signs are opposite, stays as it is but for the
/// cut-offs its channel names, with the reason in its relation. Without an accelerometer pair nothing changes. Known
/// delays must have been removed. The pairs are shared by up to num_threads threads.
Equalised equalise_sensors(ColumnSpectra& spectra, const std::vector<unsigned char>& excluded,
                           ScaleReference scale = ScaleReference::displacement, int num_threads = 1);

/// Gives accelerations that passed these cut-offs (roles ddr and ddy) back what the cut-offs took, in their spectra:
/// above the highest cut-off by dividing by the high-pass, which costs no more than a factor sqrt(2) of noise a pole
/// there; below half of it, where that would amplify drift, from the displacement of the same body instead, with a
/// smooth passage. Their mean becomes zero. A body without a displacement keeps its acceleration as it is.
void restore_low_frequencies(ColumnSpectra& spectra, const std::vector<double>& highpass_hz, int num_threads = 1);

}  // namespace dsp
