#include "sim/rig/qzs_sensors.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <stdexcept>
#include <utility>

#include "dsp/values/constants.hpp"
#include "sim/noise.hpp"
#include "sim/rig/random_sensors.hpp"

namespace sim {
namespace {

using dsp::two_pi;
constexpr double g = 9.80665;
constexpr int update_frames = 32, capture_frames = 16;  // a laser's value lasts 32 frames and is 16 frames old at first
constexpr int chunk_frames = 128 * update_frames;

constexpr double laser_range_m = 35e-3, laser_range_v = 4.0, laser_noise_m = 12e-6, laser_step_m = 10e-6;
constexpr double laser_daq_noise_v = 30e-6, accelerometer_daq_noise_v = 60e-6;
constexpr std::array drift_cutoffs_hz{0.05, 0.5, 5.0};
constexpr double drift_rms = 0.3e-3, vibration_rms = 0.05, fan_amplitude = 0.15;  // m/s^2
constexpr double vibration_scale = 4.6;                                           // of white noise past the band filter
constexpr double mains_hz = 50.02, fan_hz = 148.7;
constexpr std::array laser_mains_v{0.5e-3, 0.1e-3, 0.25e-3}, accelerometer_mains_v{1.5e-3, 0.3e-3, 0.6e-3};

using Chunk = std::array<double, chunk_frames>;

/// Nearest integer, ties to even: adding 1.5 * 2^52 leaves no room for a fraction.
double nearest(double value) {
  constexpr double shift = 6755399441055744.0;
  return (value + shift) - shift;
}

/// Second-order recursion, transposed direct form II; numerator and denominator over 1 + a1 z^-1 + a2 z^-2.
struct Biquad {
  double b0 = 1.0, b1 = 0.0, b2 = 0.0, a1 = 0.0, a2 = 0.0, s1 = 0.0, s2 = 0.0;
  double operator()(double in) {
    const double out = b0 * in + s1;
    s1 = b1 * in - a1 * out + s2;
    s2 = b2 * in - a2 * out;
    return out;
  }
};

// Bilinear forms of analogue filters, exact at their own frequency: w / s becomes k (1 + z^-1) / (1 - z^-1).
double bilinear_k(double hz) {
  return std::tan(0.5 * two_pi * hz / raw_rate_hz);
}

/// w^2 (lowpass) or s^2 over s^2 + sqrt(2) w s + w^2.
Biquad butterworth(double hz, bool lowpass) {
  const double k = bilinear_k(hz), a0 = 1.0 + std::sqrt(2.0) * k + k * k, b = (lowpass ? k * k : 1.0) / a0;
  return {b, lowpass ? 2.0 * b : -2.0 * b, b, 2.0 * (k * k - 1.0) / a0, (1.0 - std::sqrt(2.0) * k + k * k) / a0};
}

/// (2 zeta w s + w^2) / (s^2 + 2 zeta w s + w^2): what a mass on a damped spring does of its support's motion.
Biquad suspension(double hz, double zeta) {
  const double k = bilinear_k(hz), d = 2.0 * zeta * k, a0 = 1.0 + d + k * k;
  return {(d + k * k) / a0, 2.0 * k * k / a0, (k * k - d) / a0, 2.0 * (k * k - 1.0) / a0, (1.0 - d + k * k) / a0};
}

/// One-pole high-pass s / (s + w), settled on its first input.
struct Highpass {
  double gain, pole, last_in = 0.0, last_out = 0.0;
  bool settled = false;
  explicit Highpass(double hz) : gain(1.0 / (1.0 + bilinear_k(hz))), pole((1.0 - bilinear_k(hz)) * gain) {}
  double operator()(double in) {
    if (!std::exchange(settled, true)) last_in = in;
    last_out = pole * last_out + gain * (in - last_in);
    last_in = in;
    return last_out;
  }
};

/// First-order autoregression of given rms, in its steady state from the start.
struct Drift {
  Noise noise;
  double pole, innovation, value = 0.0;
  Drift(Noise source, double cutoff_hz)
      : noise(source),
        pole(std::exp(-two_pi * cutoff_hz / raw_rate_hz)),
        innovation(drift_rms * std::sqrt(1.0 - pole * pole)) {}
  double operator()(std::uint64_t n) {
    value = n == 0 ? drift_rms * noise.at(0) : pole * value + innovation * noise.at(n);
    return value;
  }
};

/// sin(2 pi f t) and its first harmonics over a chunk, by rotation from an exact start.
template <std::size_t num_harmonics>
void tones(double hz, std::int64_t first, std::array<Chunk, num_harmonics>& sines) {
  const double turns = hz * static_cast<double>(first) / raw_rate_hz;
  std::complex<double> z = std::polar(1.0, two_pi * (turns - std::floor(turns)));
  const std::complex<double> step = std::polar(1.0, two_pi * hz / raw_rate_hz);
  for (int i = 0; i < chunk_frames; ++i) {
    std::complex<double> power = z;
    for (auto& harmonic : sines) {
      harmonic[static_cast<std::size_t>(i)] = power.imag();
      power *= z;
    }
    z *= step;
  }
}

struct Laser {
  Noise update_noise, daq_noise;
  double captured_m = 0.0;  ///< what the next update will show
};

struct Accelerometer {
  Noise vibration_noise, daq_noise;
  std::vector<Drift> drifts = {};
  Biquad band_low = butterworth(200.0, false), band_high = butterworth(800.0, true);
  std::vector<Highpass> highpasses = {};
};

Accelerometer accelerometer(std::uint64_t seed, std::uint64_t c, const RigSensor& sensor) {
  Accelerometer result{.vibration_noise = {seed, 30 + c}, .daq_noise = {seed, 70 + c}};
  for (std::uint64_t k = 0; k < drift_cutoffs_hz.size(); ++k)
    result.drifts.emplace_back(Noise(seed, 40 + 10 * c + k), drift_cutoffs_hz[k]);
  for (const double cutoff : sensor.highpass_hz) result.highpasses.emplace_back(cutoff);
  return result;
}

}  // namespace

double ZeroDrift::at(double t_s) const {
  return sine_m * std::sin(two_pi * t_s / period_s + phase) + slope_m * t_s / 1800.0;
}

namespace {
constexpr std::array level_names{"ideal", "noise", "full", "random"};
}

std::string_view to_string(SensorLevel level) {
  return level_names[static_cast<std::size_t>(level)];
}

SensorLevel sensor_level(std::string_view name) {
  for (std::size_t i = 0; i < level_names.size(); ++i)
    if (name == level_names[i]) return static_cast<SensorLevel>(i);
  throw std::invalid_argument(fmt::format("qzs: no sensors \"{}\"; there are {}", name, fmt::join(level_names, ", ")));
}

std::array<RigSensor, num_raw_channels> rig_sensors(SensorLevel level, const QzsParameters& parameters,
                                                    std::uint64_t seed) {
  constexpr double laser = laser_range_v / laser_range_m, accelerometer = 0.1 / g;
  std::array<RigSensor, num_raw_channels> sensors{
      {{"base_laser", "r", "m", laser, 1.0, 0.0, 0.0, {}, {}},
       {"payload_laser", "y", "m", laser, 1.0, 0.0, 0.0, {}, {}},
       {"base_accelerometer", "ddr", "m/s^2", accelerometer, 1.0, 0.0, 0.0, {}, {}},
       {"payload_accelerometer", "ddy", "m/s^2", accelerometer, 1.0, 0.0, 0.0, {}, {}}}};
  if (level != SensorLevel::full && level != SensorLevel::random) return sensors;
  constexpr std::array gains{1.003, 0.996, 1.020, 0.985}, cutoffs_hz{0.0, 0.0, 0.40, 0.45};
  constexpr std::array drifts{ZeroDrift{30e-6, 1400.0, 0.3, 20e-6}, ZeroDrift{45e-6, 1900.0, 1.1, -35e-6}};
  constexpr std::array offsets{1.2e-3, -0.7e-3, 0.20e-3 / accelerometer, -0.15e-3 / accelerometer};
  for (std::size_t c = 0; c < sensors.size(); ++c) {
    sensors[c].gain = gains[c];
    sensors[c].offset = offsets[c];
    if (c < 2) sensors[c].drift = drifts[c];
    if (c < 2) sensors[c].lag_s = (capture_frames + 0.5 * (update_frames - 1)) / raw_rate_hz;
    if (c >= 2) sensors[c].highpass_hz.push_back(cutoffs_hz[c]);
    if (c >= 2 && parameters.second_highpass_hz > 0.0) sensors[c].highpass_hz.push_back(parameters.second_highpass_hz);
  }
  if (level == SensorLevel::random) draw_sensors(sensors, seed);
  return sensors;
}

std::vector<TrueTerm> true_terms_as_recorded(const QzsParameters& parameters, double payload_gain) {
  std::vector<TrueTerm> terms = true_terms(parameters);
  std::erase_if(terms, [](const TrueTerm& term) { return term.row != 2; });  // the others say what v is
  for (TrueTerm& term : terms) {
    const double degree = term.name == "x^3" ? 3.0 : term.name == "x^2" ? 2.0 : term.name == "sgn(v)" ? 0.0 : 1.0;
    term.value *= std::pow(payload_gain, 1.0 - degree);
  }
  return terms;
}

struct RawRecorder::State {
  std::shared_ptr<const QzsRig> rig;
  QzsTrajectory trajectory;
  RawOptions options;
  std::array<RigSensor, num_raw_channels> sensors;
  std::array<Laser, 2> lasers;
  std::array<Accelerometer, 2> accelerometers;
  Biquad bounce_y, bounce_ddy;
  std::int64_t num_frames = 0, chunk_begin = -chunk_frames, next_frame = 0;
  std::array<Chunk, num_raw_channels> motion{}, volts{};  ///< r, y, r'', y'' as the sensors meet them; their output
  std::array<Chunk, 3> mains{};
  std::array<Chunk, 1> fan{};
  std::array<double, num_raw_channels> held_v{};  ///< last value before a problem of the holding kind

  State(std::shared_ptr<const QzsRig> the_rig, double duration_s, const RawOptions& the_options);
  void fill_chunk();
  void move();
  void read_laser(std::size_t c);
  void read_accelerometer(std::size_t c);
  void break_sensors();
  [[nodiscard]] bool has_noise() const { return options.level != SensorLevel::ideal && options.noise > 0.0; }
  [[nodiscard]] int frames_in_chunk() const {
    return static_cast<int>(std::min<std::int64_t>(chunk_frames, num_frames - chunk_begin));
  }
};

RawRecorder::State::State(std::shared_ptr<const QzsRig> the_rig, double duration_s, const RawOptions& the_options)
    : rig(the_rig),
      trajectory(std::move(the_rig), duration_s),
      options(the_options),
      sensors(rig_sensors(options.level, rig->parameters(), options.seed)),
      lasers{{{{options.seed, 10}, {options.seed, 20}}, {{options.seed, 11}, {options.seed, 21}}}},
      accelerometers{{accelerometer(options.seed, 0, sensors[2]), accelerometer(options.seed, 1, sensors[3])}},
      num_frames(std::llround(duration_s * raw_rate_hz)) {
  if (!(options.noise >= 0.0))
    throw std::invalid_argument(fmt::format("RawRecorder: noise must not be negative, got {}", options.noise));
  for (const auto& problem : options.problems)
    if (problem.channel < 0 || problem.channel >= num_raw_channels)
      throw std::invalid_argument(fmt::format("RawRecorder: no channel {} for a sensor problem", problem.channel));
  if (const auto& p = rig->parameters(); p.bounce_hz > 0.0)
    bounce_y = bounce_ddy = suspension(p.bounce_hz, p.bounce_damping);
}

void RawRecorder::State::move() {
  for (int i = 0; i < frames_in_chunk(); ++i) {
    const auto n = static_cast<std::size_t>(i);
    const QzsState& state = trajectory.at(static_cast<double>(chunk_begin + i) / raw_rate_hz);
    motion[0][n] = state.base.r_m;
    motion[1][n] = bounce_y(state.x + state.base.r_m);
    motion[2][n] = state.base.ddr_m_per_s2;
    motion[3][n] = bounce_ddy(state.a + state.base.ddr_m_per_s2);
  }
}

void RawRecorder::State::read_laser(std::size_t c) {
  const RigSensor& sensor = sensors[c];
  Laser& laser = lasers[c];
  const double noise = has_noise() ? options.noise : 0.0;
  for (int first = 0; first < frames_in_chunk(); first += update_frames) {
    const std::int64_t frame = chunk_begin + first;
    const auto update = static_cast<std::uint64_t>(frame / update_frames);
    const double error = noise > 0.0 ? noise * laser_noise_m * laser.update_noise.at(update) : 0.0;
    const double taken_s = static_cast<double>(frame - capture_frames) / raw_rate_hz;
    const double held = sensor.gain * laser.captured_m + sensor.offset + sensor.drift.at(taken_s) + error;
    laser.captured_m = motion[c][static_cast<std::size_t>(first + capture_frames)];
    for (int i = first; i < first + update_frames; ++i) {
      const auto n = static_cast<std::size_t>(i);
      double shown = motion[c][n];
      if (options.level == SensorLevel::full || options.level == SensorLevel::random)
        shown = std::clamp(laser_step_m * nearest(held / laser_step_m), -laser_range_m, laser_range_m);
      if (options.level == SensorLevel::noise) shown = laser_step_m * nearest((shown + error) / laser_step_m);
      volts[c][n] = shown * sensor.volts_per_unit;
      if (noise == 0.0) continue;
      double hum = laser_daq_noise_v * laser.daq_noise.at(static_cast<std::uint64_t>(chunk_begin + i));
      for (std::size_t h = 0; h < mains.size(); ++h) hum += laser_mains_v[h] * mains[h][n];
      volts[c][n] += noise * hum;
    }
  }
}

void RawRecorder::State::read_accelerometer(std::size_t c) {
  const RigSensor& sensor = sensors[2 + c];
  Accelerometer& device = accelerometers[c];
  const double noise = has_noise() ? options.noise : 0.0;
  const double volts_per_unit = sensor.gain * sensor.volts_per_unit, offset_v = sensor.offset * sensor.volts_per_unit;
  for (int i = 0; i < frames_in_chunk(); ++i) {
    const auto n = static_cast<std::size_t>(i);
    const auto frame = static_cast<std::uint64_t>(chunk_begin + i);
    double felt = motion[2 + c][n], hum = 0.0;
    if (noise > 0.0) {
      double shaking = fan_amplitude * fan[0][n];
      shaking += vibration_rms * vibration_scale * device.band_high(device.band_low(device.vibration_noise.at(frame)));
      for (Drift& drift : device.drifts) shaking += drift(frame);
      felt += noise * shaking;
      hum = accelerometer_daq_noise_v * device.daq_noise.at(frame);
      for (std::size_t h = 0; h < mains.size(); ++h) hum += accelerometer_mains_v[h] * mains[h][n];
    }
    double signal = felt * volts_per_unit;
    for (Highpass& highpass : device.highpasses) signal = highpass(signal);
    volts[2 + c][n] = signal + offset_v + noise * hum;
  }
}

void RawRecorder::State::break_sensors() {
  for (const auto& problem : options.problems) {
    const auto c = static_cast<std::size_t>(problem.channel);
    const std::int64_t from = std::llround(problem.from_s * raw_rate_hz), to = std::llround(problem.to_s * raw_rate_hz);
    for (std::int64_t frame = std::max(from, chunk_begin); frame < std::min(to, chunk_begin + chunk_frames); ++frame) {
      double& out = volts[c][static_cast<std::size_t>(frame - chunk_begin)];
      if (frame == from) held_v[c] = out;
      if (problem.kind == SensorProblem::Kind::rail) out = raw_full_scale_v;
      if (problem.kind == SensorProblem::Kind::hold) out = held_v[c];
      if (problem.kind == SensorProblem::Kind::clip) out = std::clamp(out, -problem.limit_v, problem.limit_v);
    }
  }
}

void RawRecorder::State::fill_chunk() {
  chunk_begin += chunk_frames;
  move();
  if (has_noise()) {
    tones(mains_hz, chunk_begin, mains);
    tones(fan_hz, chunk_begin, fan);
  }
  for (std::size_t c = 0; c < 2; ++c) {
    read_laser(c);
    read_accelerometer(c);
  }
  break_sensors();
}

RawRecorder::RawRecorder(std::shared_ptr<const QzsRig> rig, double duration_s, const RawOptions& options)
    : state_(std::make_unique<State>(std::move(rig), duration_s, options)) {}
RawRecorder::~RawRecorder() = default;
RawRecorder::RawRecorder(RawRecorder&&) noexcept = default;
RawRecorder& RawRecorder::operator=(RawRecorder&&) noexcept = default;

std::int64_t RawRecorder::num_frames() const {
  return state_->num_frames;
}

RawRecorder::Frames RawRecorder::next(Eigen::Index n) {
  auto& s = *state_;
  constexpr double steps = 8388608.0;  // 2^23
  Frames frames(std::min<Eigen::Index>(n, s.num_frames - s.next_frame), num_raw_channels);
  for (Eigen::Index row = 0; row < frames.rows(); ++row, ++s.next_frame) {
    if (s.next_frame == s.chunk_begin + chunk_frames) s.fill_chunk();
    const auto i = static_cast<std::size_t>(s.next_frame - s.chunk_begin);
    for (std::size_t c = 0; c < num_raw_channels; ++c)
      frames(row, static_cast<Eigen::Index>(c)) =
          std::clamp(nearest(s.volts[c][i] * (steps / raw_full_scale_v)), -steps, steps - 1.0) / steps;
  }
  return frames;
}

}  // namespace sim
