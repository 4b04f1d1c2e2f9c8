#pragma once
#include <Eigen/Core>

namespace ident {

/// A signal at any time between its samples (in samples from the first), band-limited: Kaiser-windowed sinc, flat to
/// 0.85 of the Nyquist frequency within 1e-4. Beyond either end the record is continued by point reflection.
[[nodiscard]] double interpolate(const Eigen::Ref<const Eigen::VectorXd>& samples, double at);

/// A measured signal between its samples: eightfold band-limited (Kaiser-windowed sinc, flat to 0.85 of the Nyquist
/// frequency), then cubic Hermite on that fine grid. Beyond either end the record is continued by point reflection.
class Interpolant {
 public:
  /// Samples [first, last) are to be covered. Throws std::invalid_argument for an empty range or one outside.
  Interpolant(const Eigen::Ref<const Eigen::VectorXd>& samples, double sample_rate_hz, Eigen::Index first,
              Eigen::Index last);
  /// t_s counts from sample 0 of the record; outside the covered range the nearest end's value.
  [[nodiscard]] double at(double t_s) const;

 private:
  double fine_rate_hz_, start_s_;
  Eigen::VectorXd fine_, slope_;  ///< values and per-step slopes on the fine grid
};

}  // namespace ident
