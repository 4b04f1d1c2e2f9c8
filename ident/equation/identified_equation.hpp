#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "ident/equation/verdict.hpp"

namespace ident {

/// An equation of motion as a finished identification left it.
struct IdentifiedEquation {
  std::string range, method, target, text;
  Verdict verdict = Verdict::undecided;  ///< whether it describes its record
  std::vector<std::string> terms;
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;  ///< of the coefficients; where they differ by recording, of the mean of theirs
  std::string coordinates;     ///< a sentence on where its x is 0; empty: not known
  bool base_measured = false;  ///< the record has a base: x is relative to it
  std::string x_unit = "m";
  double largest_x = 0.0;  ///< |x| over the training rows; 0: not known
  /// Relative standard deviations of the calibration that no covariance holds: of displacements, and of f.
  double displacement_std = 0.0, force_std = 0.0;
};

/// Coefficients drawn from their posterior: mean + root z, z normal, the symmetric root of the covariance. The same
/// seed and draw give the same coefficients.
[[nodiscard]] Eigen::VectorXd drawn_coefficients(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance,
                                                 std::uint64_t seed, std::uint64_t draw);

}  // namespace ident
