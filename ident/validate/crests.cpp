#include "ident/validate/crests.hpp"

#include <algorithm>
#include <cmath>

#include "ident/sensors/channel_noise.hpp"

namespace ident {

std::vector<double> crests(const Eigen::Ref<const Eigen::VectorXd>& displacement, double noise_swing) {
  std::vector<double> found;
  if (displacement.size() < 2) return found;
  const double mean = displacement.mean();
  bool whole = false;  // the cycle under way has begun within the record
  bool below = false;  // the motion has been below the mean since
  double largest = 0.0;
  for (const double value : displacement) {
    const double now = value - mean;
    if (below && now >= noise_swing) {
      if (whole) found.push_back(largest);
      whole = true;
      below = false;
      largest = now;
    }
    below = below || now < -noise_swing;
    largest = std::max(largest, now);
  }
  return found;
}

double renewed_amplitude(const std::vector<double>& crests, double least) {
  if (crests.empty()) return 0.0;
  // Between turning points a crest moves one way; a turn counts once the crest has come back by `least`.
  double rises = 0.0, falls = 0.0, turn = crests.front(), extreme = crests.front();
  int direction = 0;
  const auto close = [&] { (direction > 0 ? rises : falls) += std::abs(extreme - turn); };
  for (const double crest : crests) {
    if (direction == 0) {
      if (std::abs(crest - turn) < least) continue;
      direction = crest > turn ? 1 : -1;
      extreme = crest;
    } else if (direction * (crest - extreme) >= 0.0) {
      extreme = crest;
    } else if (direction * (extreme - crest) >= least) {
      close();
      turn = extreme;
      extreme = crest;
      direction = -direction;
    }
  }
  if (direction != 0) close();
  const double largest = *std::max_element(crests.begin(), crests.end());
  return largest > 0.0 ? std::min(rises, falls) / largest : 0.0;
}

Crests crests_of(const RangeRows& rows, const std::vector<Columns>& recordings) {
  constexpr double noises = 4.0;  // passed by one in thirty thousand values of noise, in that direction
  Crests result;
  for (std::size_t r = 0; r < rows.usable.size(); ++r) {
    const dsp::Signal* x = recordings[r].signals->find("x");
    const std::vector<Eigen::Index>& samples = rows.usable[r];
    if (x == nullptr || samples.empty()) continue;
    const ChannelNoise* noise = recordings[r].noise.get();
    const double x_std = noise == nullptr ? 0.0 : std::sqrt(noise->covariance("x", "x"));
    for (std::size_t first = 0, last = 0; first < samples.size(); first = last) {
      for (last = first + 1; last < samples.size() && samples[last] == samples[last - 1] + 1;) ++last;
      result.push_back(
          crests(x->values.segment(samples[first], static_cast<Eigen::Index>(last - first)), noises * x_std));
    }
  }
  return result;
}

}  // namespace ident
