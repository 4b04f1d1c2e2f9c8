#pragma once
#include <array>
#include <complex>
#include <cstddef>
#include <string>
#include <vector>

// What a shaker does to the base of the rig: r(t) = Re sum_h Z_h(t) e^{i h phi(t)}, h = 1..3, phi' = 2 pi f(t), where
// amplitudes Z and frequency f pass smoothly (twice differentiable) from one node's values to the next.

namespace sim {

/// From t_s on, Z and f go over to these values within transition_s.
struct ProgrammeNode {
  double t_s = 0.0, transition_s = 0.0, frequency_hz = 0.0;
  std::array<std::complex<double>, 3> harmonics_m{};
};

/// A hand at the payload from from_s to to_s: a force per mass
///   w(t) (by_base * r'' + by_velocity * x' + stiffness * (hold_at - x)).
/// It pushes (grip_s = 0: w = sin^2(pi u), u from 0 to 1) or grips, w rising over grip_s, and lets go at to_s, w
/// falling over release_s before it. No part of any model, so a record names the interval.
struct ManualForce {
  double from_s = 0.0, to_s = 0.0, by_base = 0.0, by_velocity_per_s = 0.0;
  double stiffness_per_s2 = 0.0, hold_at_m = 0.0, grip_s = 0.0, release_s = 0.0;
  std::string why;
  [[nodiscard]] double window(double t) const;  ///< w; 0 outside
};

struct Programme {
  std::string name;
  std::vector<ProgrammeNode> nodes;  ///< by time, the first at 0
  std::vector<ManualForce> manual;
  double duration_s = 0.0;  ///< after which it starts again, node 0 following the last
};

/// A stepped-sine test: each frequency for dwell_s, in four feed-forward iterations of a quarter whose errors of
/// amplitude and residue of harmonics die out by 0.35 each.
struct SteppedSine {
  std::vector<double> frequencies_hz;
  double amplitude_m = 4.5e-3, dwell_s = 40.0;
};
/// Throws std::invalid_argument unless there are frequencies, all positive, and dwell_s is at least 4 s.
[[nodiscard]] Programme stepped_sine(const SteppedSine& test);

/// 45 steps from 1.84 down to 0.80 Hz; in the 23rd a push onto the upper branch (905 s), in the 25th a stop by hand
/// (980 s).
[[nodiscard]] Programme stepped_sine_down(double amplitude_m = 4.5e-3, double dwell_s = 40.0);

/// 33 steps from 0.80 up to 1.60 Hz: coarse where the payload is locked, fine beyond; ended before it breaks something.
[[nodiscard]] Programme stepped_sine_up(double amplitude_m = 4.5e-3, double dwell_s = 40.0);

/// The base at rest: a hand takes the payload aside and lets it go, num_releases times, to either side in turn, from
/// amplitudes that fall evenly to half of the first.
struct Releases {
  double amplitude_m = 28e-3, dwell_s = 20.0;  ///< dwell: from one release to the next
  int num_releases = 6;
};
/// Throws std::invalid_argument unless there is a release, an amplitude and a dwell of at least 8 s.
[[nodiscard]] Programme free_decay(const Releases& releases = {});

/// A pure sine stepped through these frequencies.
struct SineSteps {
  std::vector<double> frequencies_hz;
  double amplitude_m = 4.5e-3, dwell_s = 40.0, transition_s = 3.0;
};
/// Throws std::invalid_argument unless there is a frequency and each lasts longer than its transition.
[[nodiscard]] Programme sine_steps(const SineSteps& steps);

struct BaseState {
  double r_m = 0.0, dr_m_per_s = 0.0, ddr_m_per_s2 = 0.0;
};

/// The exact motion of a programme. At rest before t = 0.
class BaseMotion {
 public:
  /// Throws std::invalid_argument for nodes out of order or a programme without duration.
  explicit BaseMotion(const Programme& programme);
  /// `near`: where the last call found its node, to be kept between calls; any value is right, a near one is fast.
  [[nodiscard]] BaseState at(double t, std::size_t& near) const;
  [[nodiscard]] BaseState at(double t) const;

 private:
  using Harmonics = std::array<std::complex<double>, 3>;
  struct Piece {
    double t_s = 0.0, transition_s = 0.0, f0_hz = 0.0, f1_hz = 0.0, phase = 0.0;  ///< phase at t_s, in turns
    Harmonics z0{}, z1{};
    [[nodiscard]] double turns(double elapsed_s) const;
  };
  [[nodiscard]] static std::vector<Piece> pieces(const Programme& programme, const ProgrammeNode& before);
  [[nodiscard]] static BaseState state(const Piece& piece, double elapsed_s, double phase);

  std::vector<Piece> first_, again_;  ///< first time through, and every later time: node 0 starts elsewhere
  double duration_s_ = 0.0, turns_first_ = 0.0, turns_again_ = 0.0;
};

}  // namespace sim
