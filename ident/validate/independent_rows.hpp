#pragma once
#include <Eigen/Core>
#include <memory>
#include <vector>

#include "dsp/filter/fft.hpp"

namespace ident {

/// What fraction of as many white values residuals on these rows are worth: 1 / (1 + 2 sum over lags of
/// (N(l) / n) r(l)^2), r its autocorrelation and N(l) the number of pairs of rows l samples apart. Correlations within
/// chance (r^2 N(l) up to 2 ln n) count as none.
class IndependentRows {
 public:
  /// `samples`: each row's sample, ascending; what lies between rows is no evidence. `first_rows`: of each record; lags
  /// never cross from one to the next.
  explicit IndependentRows(const std::vector<Eigen::Index>& samples, std::vector<Eigen::Index> first_rows = {0});
  [[nodiscard]] double fraction(const Eigen::Ref<const Eigen::VectorXd>& residual) const;
  /// The first lag at which the residual's autocorrelation is within chance.
  [[nodiscard]] Eigen::Index first_lag_within_chance(const Eigen::Ref<const Eigen::VectorXd>& residual) const;

 private:
  struct Record {
    Eigen::Index first_row = 0, num_rows = 0, first_sample = 0, length = 0;
  };
  /// r(l)^2 of each lag; empty for fewer than 3 rows, or no residual.
  [[nodiscard]] Eigen::VectorXd squared_autocorrelation(const Eigen::Ref<const Eigen::VectorXd>& residual) const;
  [[nodiscard]] bool within_chance(double square, Eigen::Index lag) const;
  std::vector<Eigen::Index> samples_;
  std::vector<Record> records_;
  std::unique_ptr<dsp::RealFft> fft_;
  Eigen::VectorXd pairs_;  ///< N(l), all records together
};

/// Of one residual.
[[nodiscard]] double independent_fraction(const Eigen::Ref<const Eigen::VectorXd>& residual,
                                          const std::vector<Eigen::Index>& samples);

}  // namespace ident
