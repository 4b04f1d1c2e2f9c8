#pragma once
#include <Eigen/Core>
#include <vector>

namespace dsp {

/// A record's windows, each half over the next, that hold no excluded sample, and the frequencies of a band in them.
class BandWindows {
 public:
  /// `excluded`: per sample, not zero where it must not be used; may end before the record. No windows where they are
  /// shorter than 16 samples or longer than the record. Bins of 0 Hz are in no band.
  BandWindows(Eigen::Index num_samples, double sample_rate_hz, const std::vector<unsigned char>& excluded,
              double window_s, double from_hz, double to_hz);
  [[nodiscard]] Eigen::Index num_windows() const { return static_cast<Eigen::Index>(firsts_.size()); }
  [[nodiscard]] const Eigen::VectorXd& frequencies_hz() const& { return frequencies_hz_; }
  void frequencies_hz() const&& = delete;
  /// Of a signal as long as the record: frequencies x windows, each window less its mean, under Hann's.
  [[nodiscard]] Eigen::MatrixXcd spectra(const Eigen::Ref<const Eigen::VectorXd>& signal) const;

 private:
  Eigen::Index length_ = 0, first_bin_ = 1;
  Eigen::VectorXd frequencies_hz_;
  std::vector<Eigen::Index> firsts_;  ///< samples at which windows begin
};

}  // namespace dsp
