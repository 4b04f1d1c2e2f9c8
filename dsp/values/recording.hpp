#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "dsp/values/fault.hpp"
#include "dsp/values/signals.hpp"

namespace dsp {

struct Channel {
  std::string name;
  Role role = Role::other;
  std::string unit;                       ///< of the samples: SI ("m", "m/s^2", "N", "V", "rad", ...)
  double delay_s = 0.0;                   ///< known lag of this channel behind the clock; not yet removed
  std::vector<double> highpass_hz;        ///< known cut-offs of its AC coupling, one pole each
  bool calibrated = true;                 ///< false: samples are raw units because the user asked for that
  double sensitivity_uncertainty = 0.01;  ///< standard deviation of the sensitivity, as a fraction: a maker's usual
  double range = 0.0, drift = 0.0;  ///< of the sensor: largest reading, standard deviation of its zero; 0: not known
  bool unit_is_assumed = false;     ///< nobody said it: SI of the role
  int body = 0;                     ///< of several bodies with motions of their own which, from 1; 0: there is one
  bool role_is_assumed = false;     ///< by its name
  int hold_samples = 1;             ///< each value stands for so many samples: the sensor is slower than the clock
  double hold_s = 0.0;              ///< for so long; 0: what that does to a sine is taken out (remove_delays)
};

/// An interval of a recording that must not be used, in seconds from its first sample.
struct Interval {
  double from_s = 0.0, to_s = 0.0;
  std::string why;
  bool is_bridged = false;  ///< by what was measured on either side: kept where it is short in the band that is used
};

/// Samples [first, last).
struct IndexRange {
  Eigen::Index first = 0, last = 0;
};

/// Simultaneous channels on one clock. Sample i is at i / sample_rate_hz seconds from the start.
struct Recording {
  std::string name;  ///< for messages: the file it came from
  double sample_rate_hz = 0.0;
  double clock_start_s = 0.0;  ///< what the record's own clock said at the first sample
  std::vector<Channel> channels;
  Eigen::MatrixXd samples;    ///< num_samples x num_channels, SI
  std::vector<Interval> bad;  ///< annotated, faulty or missing intervals, margins not yet added
  std::vector<Check> checks;
  [[nodiscard]] double duration_s() const { return static_cast<double>(samples.rows()) / sample_rate_hz; }
  /// Column with this role, or -1.
  [[nodiscard]] Eigen::Index find(Role role) const;
};

}  // namespace dsp
