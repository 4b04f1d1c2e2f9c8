#include "sim/rig/rig_recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "dsp/filter/decimate.hpp"

namespace sim {
namespace {

constexpr Eigen::Index block_frames = 1 << 16;

/// The preparation's own band on its 256 Hz, for any rate: flat, and free of aliases, up to 30 / 256.
dsp::DecimateOptions decimation(double rate_hz) {
  const double passband_end_hz = rate_hz * 30.0 / 256.0;
  return {
      .output_rate_hz = rate_hz, .passband_end_hz = passband_end_hz, .stopband_start_hz = rate_hz - passband_end_hz};
}

/// Sensor problems counted from the beginning of the test.
RawOptions of_test(const RigTest& test) {
  RawOptions raw = test.raw;
  for (SensorProblem& problem : raw.problems) {
    problem.from_s += test.from_s;
    problem.to_s += test.from_s;
  }
  return raw;
}

}  // namespace

void write_rig_recording(const RigTest& test, const std::filesystem::path& file, const RigRecordingOptions& options) {
  RawRecorder recorder(test.rig, test.from_s + test.duration_s, of_test(test));
  const std::int64_t skipped = std::llround(test.from_s * raw_rate_hz);
  dsp::SoundFileWriter writer(file, {.container = options.container,
                                     .format = dsp::SampleFormat::pcm24,
                                     .sample_rate_hz = test.rate_hz,
                                     .num_channels = num_raw_channels,
                                     .num_frames = std::llround(test.duration_s * test.rate_hz),
                                     .comment = {},
                                     .shown = options.shown});
  std::optional<dsp::Decimator> decimator;
  if (test.rate_hz < raw_rate_hz) decimator.emplace(raw_rate_hz, num_raw_channels, decimation(test.rate_hz));
  for (std::int64_t begin = 0; begin < recorder.num_frames();) {
    if (options.progress) options.progress(static_cast<double>(begin) / static_cast<double>(recorder.num_frames()));
    // What comes before is made too: filters and drifts have a past.
    const std::int64_t end = begin < skipped ? skipped : recorder.num_frames();
    const dsp::FrameBlock frames = recorder.next(std::min<std::int64_t>(block_frames, end - begin));
    if (begin >= skipped) writer.write(decimator ? decimator->push(frames) : frames);
    begin += frames.rows();
  }
  if (decimator) writer.write(decimator->finish());
  writer.close();
}

std::string rig_sidecar(const RigTest& test) {
  const Programme& programme = test.rig->programme();
  std::string text = fmt::format("schema = 1\ntitle = \"QZS rig, {}\"\nrate = {}\n", programme.name, test.rate_hz);
  int index = 0;
  for (const RigSensor& sensor : rig_sensors(SensorLevel::ideal, test.rig->parameters())) {
    const bool laser = sensor.unit == "m";
    text += fmt::format(
        "\n[[channel]]\nname = \"{}\"\nindex = {}\nrole = \"{}\"\nunit = \"{}\"\nsensitivity = \"{}\"\n"
        "full_scale = \"{} V\"\ncoupling = \"{}\"\n",
        sensor.name, ++index, sensor.role, sensor.unit,
        laser ? fmt::format("{} mV/mm", sensor.volts_per_unit) : std::string("100 mV/g"), raw_full_scale_v,
        laser ? "DC" : "IEPE");
  }
  for (double start = -test.from_s; start < test.duration_s; start += programme.duration_s)
    for (const ManualForce& hand : programme.manual) {
      const double from_s = std::max(start + hand.from_s, 0.0), to_s = std::min(start + hand.to_s, test.duration_s);
      if (from_s < to_s) text += fmt::format("\n[[bad]]\nfrom = {}\nto = {}\nwhy = \"{}\"\n", from_s, to_s, hand.why);
    }
  return text;
}

}  // namespace sim
