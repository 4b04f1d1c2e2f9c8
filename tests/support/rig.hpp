#pragma once
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dsp/prepare/intermediate_recorder.hpp"
#include "dsp/values/recording.hpp"
#include "sim/rig/qzs_rig.hpp"
#include "sim/rig/qzs_sensors.hpp"

namespace support {

inline constexpr double rig_intermediate_hz = 256.0;

/// The rig's four sensors at the intermediate rate of 256 Hz in SI by their nominal sensitivities, and what the payload
/// truly did.
struct RigRecord {
  dsp::Recording recording;
  Eigen::VectorXd x, v;
  std::vector<int> modes;  ///< sim::QzsMode
};

/// As the product reads it: samples found faulty are filled and marked. Hands at the payload are annotated, as a person
/// would.
inline RigRecord rig_record(const sim::QzsParameters& parameters, const sim::Programme& programme,
                            const sim::RawOptions& raw = {}) {
  const auto rig = std::make_shared<const sim::QzsRig>(parameters, programme);
  sim::RawRecorder recorder(rig, programme.duration_s, raw);
  dsp::Recording description;
  description.name = programme.name;
  description.sample_rate_hz = sim::raw_rate_hz;
  const auto sensors = sim::rig_sensors(sim::SensorLevel::ideal, parameters);
  Eigen::RowVectorXd scale(sim::num_raw_channels);
  for (std::size_t c = 0; c < sensors.size(); ++c) {
    description.channels.push_back(
        {.name = sensors[c].name, .role = dsp::role_from_string(sensors[c].role), .unit = sensors[c].unit});
    scale(static_cast<Eigen::Index>(c)) = sim::raw_full_scale_v / sensors[c].volts_per_unit;
  }
  dsp::IntermediateRecorder intermediate(
      description, static_cast<Eigen::Index>(std::llround(programme.duration_s * sim::raw_rate_hz)),
      dsp::DecimateOptions{.output_rate_hz = rig_intermediate_hz,
                           .passband_end_hz = 30.0,
                           .stopband_start_hz = rig_intermediate_hz - 30.0});
  while (true) {
    dsp::FrameBlock frames = recorder.next(1 << 16);
    if (frames.rows() == 0) break;
    frames.array().rowwise() *= scale.array();
    intermediate.push(frames);
  }
  RigRecord result;
  dsp::Recording& recording = result.recording;
  recording = intermediate.finish();
  const Eigen::Index num_rows = recording.samples.rows();
  for (const auto& hand : programme.manual) recording.bad.push_back({hand.from_s, hand.to_s, hand.why});

  sim::QzsTrajectory trajectory(rig, programme.duration_s);
  result.x.resize(num_rows);
  result.v.resize(num_rows);
  for (Eigen::Index i = 0; i < num_rows; ++i) {
    const auto& state = trajectory.at(static_cast<double>(i) / rig_intermediate_hz);
    result.x(i) = state.x;
    result.v(i) = state.v;
    result.modes.push_back(state.mode);
  }
  return result;
}

}  // namespace support
