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
  /// r(l) of each lag; empty for fewer than 3 rows, or no residual.
  [[nodiscard]] Eigen::VectorXd autocorrelation(const Eigen::Ref<const Eigen::VectorXd>& residual) const;
  /// The fraction by the autocorrelation r of a residual.
  [[nodiscard]] double fraction_by(const Eigen::VectorXd& r) const { return fraction_by(r, r); }
  /// As evidence for the coefficient of a regressor with these values: by the product of its autocorrelation and r for
  /// r^2, 1 at most. Noise in a band that the regressor has no power in takes nothing away.
  [[nodiscard]] double fraction_beside(const Eigen::VectorXd& r, const Eigen::Ref<const Eigen::VectorXd>& values) const;
  /// The first lag at which an autocorrelation is within chance.
  [[nodiscard]] Eigen::Index first_lag_within_chance(const Eigen::VectorXd& r) const;

 private:
  struct Record {
    Eigen::Index first_row = 0, num_rows = 0, first_sample = 0, length = 0;
  };
  [[nodiscard]] bool within_chance(double r, Eigen::Index lag) const;
  /// Values at the rows of a record, at its samples; zero between rows.
  [[nodiscard]] Eigen::VectorXd in_time(const Record& record, const Eigen::Ref<const Eigen::VectorXd>& values,
                                        Eigen::Index size) const;
  [[nodiscard]] double fraction_by(const Eigen::VectorXd& r, const Eigen::VectorXd& other) const;
  std::vector<Eigen::Index> samples_;
  std::vector<Record> records_;
  std::unique_ptr<dsp::RealFft> fft_;
  Eigen::VectorXd pairs_;  ///< N(l), all records together
  double chance_ = 0.0;    ///< 2 ln n
};

/// Of one residual.
[[nodiscard]] double independent_fraction(const Eigen::Ref<const Eigen::VectorXd>& residual,
                                          const std::vector<Eigen::Index>& samples);

}  // namespace ident
