#pragma once
#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "dsp/prepare.hpp"

namespace ident {

/// One-sided density of white noise beside a motion whose spectrum falls: median of the spectrum, which lines do not
/// move, in quarters of the band between these frequencies. The least, where two agree that it is flat there; else that
/// of the first, which is no less than the noise below it: a bound. 0 where a quarter holds too few ordinates.
struct NoiseDensity {
  double value = 0.0;
  bool is_bound = false;
};
[[nodiscard]] NoiseDensity noise_density(const Eigen::Ref<const Eigen::VectorXd>& signal, double sample_rate_hz,
                                         double from_hz, double to_hz);

/// White noise of the channels of a recording, as its signals have it within the band of the regression's columns:
/// each signal's is that of the channels it was made of, by sums, differences, derivatives and, where no displacement
/// was recorded, integrals from prepare.integrate_from_hz on.
class ChannelNoise {
 public:
  /// `target`: a signal of the recording.
  ChannelNoise(const dsp::Prepared& prepared, const std::string& target);
  /// Covariance of the noise of two signals, which may be one, up to a frequency; 0 where the recording has no room to
  /// tell. Of a channel whose spectrum is flat nowhere above the band only a bound is known: with `known` it counts for
  /// nothing.
  [[nodiscard]] double covariance(const std::string& one, const std::string& other, bool known, double to_hz) const;
  /// In the whole band.
  [[nodiscard]] double covariance(const std::string& one, const std::string& other, bool known = false) const {
    return covariance(one, other, known, band_hz_);
  }
  [[nodiscard]] double band_hz() const { return band_hz_; }      ///< where the band of the columns ends
  [[nodiscard]] double needed_hz() const { return needed_hz_; }  ///< up to here the target is more than noise

 private:
  /// A channel, derived so many times (below 0: integrated), with its sign in a signal.
  struct Part {
    std::string channel;
    int order = 0;
    double sign = 1.0;
  };
  [[nodiscard]] std::vector<Part> parts_of(const dsp::Prepared& prepared, const std::string& signal, int depth) const;

  /// Of f^power, by the square of the gain that all signals have at low frequencies.
  [[nodiscard]] double integral_of(int power, double to_hz) const;

  double band_hz_ = 0.0, needed_hz_ = 0.0;
  double integrated_from_hz_ = 0.0;                 ///< 0: nothing was
  std::map<std::string, std::vector<Part>> parts_;  ///< of each signal
  std::map<std::string, NoiseDensity> density_;     ///< of each channel
};

}  // namespace ident
