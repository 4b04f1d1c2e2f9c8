#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "sim/rig/qzs_rig.hpp"

// Two lasers and two accelerometers on the rig, sampled together at 25.6 kHz, 24 bits over +-5 V.

namespace sim {

inline constexpr double raw_rate_hz = 25600.0;
inline constexpr double raw_full_scale_v = 5.0;
inline constexpr int num_raw_channels = 4;

/// What is between motion and record. In every case 24-bit steps and the limit of +-5 V.
enum class SensorLevel {
  ideal,  ///< none of it: exact displacement and acceleration
  noise,  ///< noise, resolution and interference only: no wrong gain, offset, lag, drift, high-pass or range
  full,
  random,  ///< as full, with gains, offsets, drifts and high-pass cut-offs drawn from the seed: random_sensors.hpp
};
/// "ideal", "noise", "full", "random"; throws std::invalid_argument.
[[nodiscard]] SensorLevel sensor_level(std::string_view name);
[[nodiscard]] std::string_view to_string(SensorLevel level);

/// How a laser's zero wanders: sine_m sin(2 pi t / period_s + phase) + slope_m t / 1800 s.
struct ZeroDrift {
  double sine_m = 0.0, period_s = 1.0, phase = 0.0, slope_m = 0.0;
  [[nodiscard]] double at(double t_s) const;
};

/// A sensor and what its user does not know of it: volts = gain * volts_per_unit * (what it measures).
struct RigSensor {
  std::string name, role, unit;
  double volts_per_unit = 0.0;      ///< nominal, of the SI unit
  double gain = 1.0, offset = 0.0;  ///< offset in the SI unit
  double lag_s = 0.0;               ///< on average over its hold
  std::vector<double> highpass_hz;  ///< one pole each
  ZeroDrift drift;                  ///< of a laser
};
/// In the order of the record's channels: base laser (r), payload laser (y), base and payload accelerometer. `seed`
/// counts at the level random alone.
[[nodiscard]] std::array<RigSensor, num_raw_channels> rig_sensors(SensorLevel level, const QzsParameters& parameters,
                                                                  std::uint64_t seed = 1);

/// The slipping rig's equation in the units of sensors whose displacements all read payload_gain times too much:
/// x^3 / g^2, x^2 / g, sgn(v) g; x, v and ddr as they are.
[[nodiscard]] std::vector<TrueTerm> true_terms_as_recorded(const QzsParameters& parameters, double payload_gain);

/// A failing sensor, as a test of those who must notice.
struct SensorProblem {
  enum class Kind { rail, hold, clip };  ///< output at +5 V; stuck at its value; limited to +-limit_v
  Kind kind = Kind::rail;
  int channel = 0;
  double from_s = 0.0, to_s = 0.0, limit_v = 5.0;
};

struct RawOptions {
  SensorLevel level = SensorLevel::full;
  double noise = 1.0;  ///< times the nominal amplitude of every noise and interference
  std::uint64_t seed = 1;
  std::vector<SensorProblem> problems = {};
};

/// The raw record, block by block. Frame n is at n / 25600 s. A frame does not depend on how the frames were asked for.
class RawRecorder {
 public:
  using Frames = Eigen::Matrix<double, Eigen::Dynamic, num_raw_channels, Eigen::RowMajor>;
  /// Throws std::invalid_argument for a negative noise or a problem on no channel.
  RawRecorder(std::shared_ptr<const QzsRig> rig, double duration_s, const RawOptions& options = {});
  ~RawRecorder();
  RawRecorder(RawRecorder&&) noexcept;
  RawRecorder& operator=(RawRecorder&&) noexcept;
  [[nodiscard]] std::int64_t num_frames() const;
  /// Up to n further frames, fewer at the end: volts over full scale, exact multiples of 2^-23.
  [[nodiscard]] Frames next(Eigen::Index n);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sim
