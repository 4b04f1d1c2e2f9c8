#pragma once
#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

#include "dsp/filter/decimate.hpp"
#include "dsp/filter/spectral.hpp"

namespace dsp {

/// The one linear filter that the target and every column pass on their way to the regression: from samples at the
/// intermediate rate to samples at the regression rate. Zero phase but for its high-pass; output n is centred on time n
/// / output_rate_hz.
class ColumnFilter {
 public:
  /// Raised-cosine low-pass in the frequency domain, same rate in and out. Ends are continued by linear prediction.
  [[nodiscard]] static ColumnFilter taper(double sample_rate_hz, const SpectralBand& band);
  /// FIR decimation from the intermediate rate to the regression rate. Throws as Decimator does.
  [[nodiscard]] static ColumnFilter decimation(double input_rate_hz, const DecimateOptions& options);
  /// The same filter followed by one-pole high-passes jf / (f_c + jf), those of an AC coupling: causal, DC goes to
  /// zero. Throws std::invalid_argument for a cut-off that is not positive.
  [[nodiscard]] ColumnFilter with_highpass(const std::vector<double>& cutoffs_hz) const;
  [[nodiscard]] Eigen::VectorXd apply(const Eigen::Ref<const Eigen::VectorXd>& intermediate_signal) const;
  /// The same of several signals side by side, whose samples [first, first + count) `read` gives, in order.
  [[nodiscard]] Eigen::MatrixXd apply(
      Eigen::Index num_samples, Eigen::Index num_signals,
      const std::function<Eigen::MatrixXd(Eigen::Index first, Eigen::Index count)>& read) const;
  /// The high-pass alone, of a signal at the regression rate. Of a decimation it comes last: what the same filter
  /// without it makes of a signal becomes so what `apply` makes of it.
  [[nodiscard]] Eigen::VectorXd high_passed(const Eigen::Ref<const Eigen::VectorXd>& signal) const;
  [[nodiscard]] double input_rate_hz() const;
  [[nodiscard]] double output_rate_hz() const;
  /// Columns are gone from here on: the taper's cut-off, the start of the decimation's stop band.
  [[nodiscard]] double stop_hz() const;
  /// Of the decimation; no stages for a taper.
  [[nodiscard]] const FilterSheet& sheet() const&;
  void sheet() const&& = delete;
  /// Outputs lean on samples this far away, on either side; at the ends on predicted ones.
  [[nodiscard]] double edge_s() const;

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

}  // namespace dsp
