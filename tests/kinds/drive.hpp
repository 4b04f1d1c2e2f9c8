#pragma once
#include <string>
#include <vector>

#include "kinds/random_stream.hpp"

namespace kinds {

/// A signal of rms about 1 at count moments `step_s` apart, and what twice its integral is where that is wanted.
/// kind: noise (150 lines), multisine (3 to 8 lines), sweep, steps; their frequencies between low and high, in Hz.
struct Signal {
  std::vector<double> value;
  std::vector<double> twice_integrated;  ///< Of noise and multisine only.
};
Signal draw_signal(const std::string& kind, RandomStream& random, double low, double high, double step_s,
                   std::size_t count);

/// Half-sine pushes at random moments, `mean_s` apart in the mean, each of 0.2 mean_s / 15 to 0.2 mean_s.
std::vector<double> draw_pushes(RandomStream& random, double mean_s, double step_s, std::size_t count);

}  // namespace kinds
