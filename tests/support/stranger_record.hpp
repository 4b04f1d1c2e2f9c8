#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace support {

/// A text file as a person who measured a driven Duffing oscillator would bring it, and what is true of it.
struct StrangerRecord {
  std::string csv;           ///< clock, displacement and force, named and in units as people do
  std::string csv_unforced;  ///< the same without the force
  std::string drawn;         ///< what was drawn, as text
  /// x'' = sum of these, in SI, by term: "x", "v", "x^3", "f".
  std::vector<std::pair<std::string, double>> truth;
};

/// Stiffness 20 to 100 1/s^2, damping ratio 1 to 10 %, cubic term up to half of the restoring force, a force of slow
/// sweeps or of several tones, white noise on x of noise_from to noise_to of its rms. Everything follows from the seed;
/// the motion is integrated here, by fourth-order Runge-Kutta steps, and not by the library under test.
[[nodiscard]] StrangerRecord stranger_record(std::uint32_t seed, double noise_from, double noise_to);

}  // namespace support
