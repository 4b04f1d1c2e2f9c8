#pragma once
#include <Eigen/Core>
#include <memory>

namespace dsp {

/// The smallest even 2^a 3^b 5^c 7^d that is at least `at_least`: a length for which the transform is fast.
[[nodiscard]] Eigen::Index good_fft_size(Eigen::Index at_least);

/// The largest of these lengths that is no more than `at_most`; 2 where none is.
[[nodiscard]] Eigen::Index good_fft_size_within(Eigen::Index at_most);

/// Mean square of Hann's window.
inline constexpr double hann_power = 3.0 / 8.0;

/// Hann's window of n samples: 1/2 - 1/2 cos(2 pi (i + 1/2) / n).
[[nodiscard]] Eigen::VectorXd hann_window(Eigen::Index n);

/// Discrete Fourier transform of real sequences of one length n. Plans are made when first used, from estimates, so
/// equal input gives equal bits, and those of the last few lengths are kept for the next object; making one is
/// serialised, using one is not, so one object may serve several threads.
class RealFft {
 public:
  /// Throws std::invalid_argument for n < 1.
  explicit RealFft(Eigen::Index n);
  /// X_k = sum_i x_i exp(-2 pi i k i / n) for k = 0 .. n/2.
  [[nodiscard]] Eigen::VectorXcd forward(const Eigen::Ref<const Eigen::VectorXd>& x) const;
  /// The same into X, resized where it is of another length: for transform after transform of an even n.
  void forward(const Eigen::Ref<const Eigen::VectorXd>& x, Eigen::VectorXcd& X) const;
  /// The sequence whose forward transform is X: n samples, scaled by 1/n. The imaginary parts of X_0 and X_(n/2) are
  /// ignored.
  [[nodiscard]] Eigen::VectorXd inverse(Eigen::VectorXcd X) const;
  [[nodiscard]] Eigen::Index size() const;

 private:
  struct Plans;
  static std::shared_ptr<const Plans> plans_for(Eigen::Index n);
  std::shared_ptr<const Plans> plans_;
};

}  // namespace dsp
