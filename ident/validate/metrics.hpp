#pragma once
#include <Eigen/Core>
#include <string_view>
#include <vector>

#include "ident/regression/r_factor.hpp"

namespace ident {

/// sum (predicted - actual)^2 / sum actual^2: the paper's NMSE, no mean removed. NaN where the target is zero
/// throughout.
[[nodiscard]] double nmse(const Eigen::Ref<const Eigen::VectorXd>& predicted,
                          const Eigen::Ref<const Eigen::VectorXd>& actual);
/// The same about the mean of `actual`. NaN where the target is constant.
[[nodiscard]] double nmse_centred(const Eigen::Ref<const Eigen::VectorXd>& predicted,
                                  const Eigen::Ref<const Eigen::VectorXd>& actual);

/// Variance of the predictive distribution of each row: sigma^2 + phi' delta phi (Eqs. 35-37 of [QZS23], with
/// Phi delta Phi' for the misprinted Phi' delta Phi). phi: rows x b', covariance b' x b'.
[[nodiscard]] Eigen::VectorXd predictive_variance(const Eigen::Ref<const Eigen::MatrixXd>& phi,
                                                  const Eigen::Ref<const Eigen::MatrixXd>& covariance,
                                                  double noise_variance);

/// Fraction of the values inside the central 50, 90 and 95 % bands of their predictive distributions. NaN for no
/// values.
struct BandFractions {
  double within_50 = 0.0, within_90 = 0.0, within_95 = 0.0;
};
/// "too narrow" or "too wide" where the bands of 95 % hold less than 92 or more than 98 % of the values; else empty.
[[nodiscard]] std::string_view fault_of(const BandFractions& bands);
[[nodiscard]] BandFractions band_fractions(const Eigen::Ref<const Eigen::VectorXd>& predicted,
                                           const Eigen::Ref<const Eigen::VectorXd>& variance,
                                           const Eigen::Ref<const Eigen::VectorXd>& actual);

/// Is a residual noise, or is there structure left in it? Judged inside the band that the column filter passes, since
/// everything above it was removed on purpose.
struct Whiteness {
  double p_value = 1.0;  ///< of two tests together: Bartlett's (the cumulated periodogram against a straight line)
                         ///< sees colour, Fisher's (its largest ordinate) sees a tone
  double peak_fraction =
      0.0;              ///< fraction of the residual's power in the strongest 5 % of frequencies; white noise: 0.20
  bool tested = false;  ///< false: too few rows, or no residual at all
  bool white = true;    ///< p_value >= 0.01
};
/// samples: number of each row's sample in its record, ascending; what lies between rows counts as zero, and as no
/// evidence; the last few samples are left out where that makes the transform fast. band_hz: where the filter's pass
/// band ends. Throws std::invalid_argument unless there are as many samples as residuals.
[[nodiscard]] Whiteness residual_whiteness(const Eigen::Ref<const Eigen::VectorXd>& residual,
                                           const std::vector<Eigen::Index>& samples, double sample_rate_hz,
                                           double band_hz);

/// Sums of phi_i e_i over about fifty consecutive blocks of rows, for robust_covariance: what coloured residuals and
/// columns do together, gathered as rows come by.
class BlockScores {
 public:
  BlockScores(Eigen::Index num_terms, Eigen::Index num_rows);
  /// The next rows: phi rows x b', residual one per row.
  void add(const Eigen::Ref<const Eigen::MatrixXd>& phi, const Eigen::Ref<const Eigen::VectorXd>& residual);
  [[nodiscard]] const Eigen::MatrixXd& sums() const& { return sums_; }  ///< b' x blocks
  void sums() const&& = delete;

 private:
  Eigen::Index num_rows_, next_row_ = 0;
  Eigen::MatrixXd sums_;
};

/// Covariance of the coefficients that does not assume a white residual: (Phi'Phi)^-1 S (Phi'Phi)^-1 with S from the
/// block scores ("sandwich"). `kept`: the R factor of the kept columns, b' of them. Empty for no columns, no more rows
/// than columns, or a column of zeros.
[[nodiscard]] Eigen::MatrixXd robust_covariance(const RFactor& kept, const BlockScores& scores);

}  // namespace ident
