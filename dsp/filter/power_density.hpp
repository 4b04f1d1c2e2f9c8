#pragma once
#include <Eigen/Core>

namespace dsp {

/// One-sided power density of a signal: its periodogram under Hann's window, which keeps the leap between the ends out,
/// averaged over pieces of one length, each about its mean.
class PowerDensity {
 public:
  /// As many pieces of `piece_samples` samples or more as there are; 0: the record in one. Nothing is known of a record
  /// shorter than 8 samples.
  PowerDensity(const Eigen::Ref<const Eigen::VectorXd>& signal, double rate_hz, Eigen::Index piece_samples = 0);
  /// The same of a record in one piece, in its own memory.
  PowerDensity(Eigen::VectorXd&& signal, double rate_hz);
  /// As the median in a band says that it is everywhere in it, whatever lines of motion there are: the density of white
  /// noise with this median. 0 where the record does not reach so far or the band holds fewer than `least` ordinates.
  [[nodiscard]] double between(double from_hz, double to_hz, Eigen::Index least = 1) const;
  [[nodiscard]] const Eigen::VectorXd& ordinates() const& { return density_; }  ///< at 0, step_hz(), 2 step_hz(), ...
  void ordinates() const&& = delete;
  [[nodiscard]] double step_hz() const { return step_hz_; }

 private:
  PowerDensity(Eigen::Index num_samples, double rate_hz, Eigen::Index piece_samples);
  /// A piece about its mean; X: its transform.
  void add(Eigen::VectorXd piece, Eigen::VectorXcd& X);
  void normalise(double rate_hz);

  Eigen::VectorXd density_;
  double step_hz_ = 0.0, end_hz_ = 0.0;
  Eigen::Index num_pieces_ = 1, length_ = 0;  ///< samples of a piece; 0: too few
};

}  // namespace dsp
