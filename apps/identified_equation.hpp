#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "ident/verdict.hpp"

namespace apps {

/// An equation of motion as a finished run left it.
struct IdentifiedEquation {
  std::string range, method, target, text;
  ident::Verdict verdict = ident::Verdict::undecided;  ///< whether it describes its record
  std::vector<std::string> terms;
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;  ///< of the coefficients; the one that does not assume a white residual where known
  std::string covariance_of;   ///< what it is: "noise and sensors", "robust", "white noise"
  Eigen::VectorXd scale;       ///< largest magnitude of each term over the training rows; NaN: not known
  bool base_measured = false;  ///< the record has a base: x is relative to it
};

/// Reads the equation of a range and method from a run folder's equation.json. Left out, each is as
/// the run chose it, or the first. Throws dsp::Fault: "run.incomplete",
/// "run.damaged" (input), "run.no_such_equation" (usage) with what there is.
[[nodiscard]] IdentifiedEquation read_equation(const std::filesystem::path& run, const std::string& range,
                                               const std::string& method);

/// Coefficients drawn from their posterior: mean + root z, z normal, the symmetric root of the covariance. The same
/// seed and draw give the same coefficients.
[[nodiscard]] Eigen::VectorXd drawn_coefficients(const IdentifiedEquation& equation, std::uint64_t seed,
                                                 std::uint64_t draw);

}  // namespace apps
