#pragma once
#include <Eigen/Core>

namespace dsp {

/// Reflection coefficients k_1 .. k_order of a linear predictor by Burg's method: each minimises the sum of forward and
/// backward prediction error powers [Bur75]. All lie in [-1, 1]; once rounding is all that is left to predict the rest
/// are zero. By time reversal the same coefficients predict backwards. Throws std::invalid_argument unless 0 <= order <
/// x.size().
[[nodiscard]] Eigen::VectorXd burg(const Eigen::Ref<const Eigen::VectorXd>& x, Eigen::Index order);

/// The `count` samples that follow x by linear prediction. Runs the lattice rather than the direct form, which loses
/// its stability to rounding when a record is heavily oversampled. x must have more samples than there are
/// coefficients.
[[nodiscard]] Eigen::VectorXd predict_forward(const Eigen::Ref<const Eigen::VectorXd>& x,
                                              const Eigen::Ref<const Eigen::VectorXd>& reflection, Eigen::Index count);

/// How a record is continued beyond its ends.
struct ExtensionOptions {
  Eigen::Index num_samples = 0;  ///< either side; 0: chosen from rate and length (10 s where there is that much)
  Eigen::Index order = 0;        ///< of the predictor; 0: chosen (64 at most at low rates, 128 beyond 100 Hz)
  Eigen::Index fit_samples = 0;  ///< the predictor is fitted to this many; 0: 8 x order (40 x above 100 Hz)
};
/// The same with nothing left to choose for a record of num_samples at this rate; short records get short predictors.
[[nodiscard]] ExtensionOptions resolved(const ExtensionOptions& options, Eigen::Index num_samples,
                                        double sample_rate_hz);

/// The samples that would follow (or, oldest first, precede) x: Burg prediction from its last (first) fit_samples.
[[nodiscard]] Eigen::VectorXd extend_after(const Eigen::Ref<const Eigen::VectorXd>& x,
                                           const ExtensionOptions& resolved);
[[nodiscard]] Eigen::VectorXd extend_before(const Eigen::Ref<const Eigen::VectorXd>& x,
                                            const ExtensionOptions& resolved);

}  // namespace dsp
