#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

namespace ident::state_space {

/// The inputs of a record at any time, t among them as the last: between samples the polynomial through the six
/// nearest, at either end of a record continued by the cubic through its last four.
class Inputs {
 public:
  /// `samples`: samples x inputs, 4 rows at least.
  Inputs(const Eigen::MatrixXd& samples, Eigen::Index num_samples, double sample_rate_hz);
  /// What the samples about sample k count for at k + fraction, 0 <= fraction <= 1, and in the slope there.
  struct Place {
    explicit Place(double fraction);
    double fraction;
    std::array<double, 6> weight{}, slope{};
  };
  /// There, 0 <= k < samples: values of all, and their rates where asked for, `apart` doubles apart.
  void at(Eigen::Index k, const Place& place, double* values, double* rates, int apart) const;
  [[nodiscard]] Eigen::Index size() const { return num_samples_; }

 private:
  Eigen::Index num_samples_;
  int num_inputs_;
  double sample_rate_hz_;
  std::vector<double> padded_;  ///< row after row, beginning `before` samples before the record
};

}  // namespace ident::state_space
