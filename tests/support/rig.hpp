#pragma once
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dsp/decimate.hpp"
#include "dsp/recording.hpp"
#include "sim/qzs_rig.hpp"
#include "sim/qzs_sensors.hpp"

namespace support {

inline constexpr double rig_bus_hz = 256.0;

/// The rig's four sensors on the 256 Hz bus in SI by their nominal sensitivities, and what the payload truly did.
struct RigRecord {
  dsp::Recording recording;
  Eigen::VectorXd x, v;
  std::vector<int> modes;  ///< sim::QzsMode
};

/// Hands at the payload are annotated, as a person would.
inline RigRecord rig_record(const sim::QzsParameters& parameters, const sim::Programme& programme,
                            const sim::RawOptions& raw = {}) {
  const auto rig = std::make_shared<const sim::QzsRig>(parameters, programme);
  sim::RawRecorder recorder(rig, programme.duration_s, raw);
  dsp::Decimator decimator(
      sim::raw_rate_hz, sim::num_raw_channels,
      {.output_rate_hz = rig_bus_hz, .passband_end_hz = 30.0, .stopband_start_hz = rig_bus_hz - 30.0});
  RigRecord result;
  dsp::Recording& recording = result.recording;
  recording.name = programme.name;
  recording.sample_rate_hz = rig_bus_hz;
  const auto num_rows = static_cast<Eigen::Index>(std::llround(programme.duration_s * rig_bus_hz));
  recording.samples.resize(num_rows, sim::num_raw_channels);
  Eigen::Index done = 0;
  const auto keep = [&](const dsp::FrameBlock& rows) {
    const Eigen::Index count = std::min<Eigen::Index>(rows.rows(), num_rows - done);
    recording.samples.middleRows(done, count) = rows.topRows(count);
    done += count;
  };
  while (true) {
    const dsp::FrameBlock frames = recorder.next(1 << 16);
    if (frames.rows() == 0) break;
    keep(decimator.push(frames));
  }
  keep(decimator.finish());
  const auto sensors = sim::rig_sensors(sim::SensorLevel::ideal, parameters);
  for (std::size_t c = 0; c < sensors.size(); ++c) {
    recording.channels.push_back(
        {.name = sensors[c].name, .role = dsp::role_from_string(sensors[c].role), .unit = sensors[c].unit});
    recording.samples.col(static_cast<Eigen::Index>(c)) *= sim::raw_full_scale_v / sensors[c].volts_per_unit;
  }
  for (const auto& hand : programme.manual) recording.bad.push_back({hand.from_s, hand.to_s, hand.why});

  sim::QzsTrajectory trajectory(rig, programme.duration_s);
  result.x.resize(num_rows);
  result.v.resize(num_rows);
  for (Eigen::Index i = 0; i < num_rows; ++i) {
    const auto& state = trajectory.at(static_cast<double>(i) / rig_bus_hz);
    result.x(i) = state.x;
    result.v(i) = state.v;
    result.modes.push_back(state.mode);
  }
  return result;
}

}  // namespace support
