#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

namespace ident::state_space {

/// The inputs of a record at any time, t among them as the last: band-limited between samples, as signals of up to 0.8
/// of half the rate are. At either end, where too few samples are on one side, the polynomial through the six nearest,
/// continued by the cubic through the last four.
class Inputs {
 public:
  /// `samples`: samples x inputs, 4 rows at least; `begin_s`: t of the first.
  Inputs(const Eigen::MatrixXd& samples, Eigen::Index num_samples, double sample_rate_hz, double begin_s = 0.0);
  /// What the values on the finer grid about sample k count for at k + fraction, 0 <= fraction <= 1, and in the slope.
  struct Place {
    explicit Place(double fraction);
    double fraction;
    std::size_t first;  ///< of six, from two before sample k
    std::array<double, 6> weight{}, slope{};
  };
  /// There, 0 <= k < samples: values of all, and their rates where asked for, `apart` doubles apart.
  void at(Eigen::Index k, const Place& place, double* values, double* rates, int apart) const;
  [[nodiscard]] Eigen::Index size() const { return num_samples_; }

 private:
  Eigen::Index num_samples_;
  int num_inputs_;
  double sample_rate_hz_, begin_s_;
  std::vector<double> padded_;  ///< row after row of the finer grid, from two of its rows before the record
};

}  // namespace ident::state_space
