#pragma once
#include <string>
#include <vector>

#include "apps/paper/paper_data.hpp"
#include "apps/paper/replicate_case.hpp"

namespace apps {

/// What is known about a printed number.
struct Answer {
  double expected = missing;      ///< what the stated method gives without the luck of a draw; NaN: not known
  double expected_std = missing;  ///< unit of the print's tolerance
  double ours = missing, ours_std = missing;  ///< means over the seeds that keep the term
  std::string reason = {};                    ///< for a verdict that is not "within noise"
};
/// "within noise" where the print is no further from what is expected than its tolerance, in units of expected_std;
/// "misprint" where what it should be is; else "not reproducible", as is a print without tolerance. Where nothing is
/// expected ours is judged by its size within a factor of the tolerance, a coefficient also by its sign.
[[nodiscard]] std::string verdict_on(const Printed& print, const Answer& answer);
/// "same size" within a factor, else "larger" or "smaller" than printed; "none" where ours is no number.
[[nodiscard]] std::string judge_size(double paper, double ours, double factor);
/// Coefficients: "same sign and size", "same sign", "other sign", "not kept".
[[nodiscard]] std::string judge_scaled(double paper, double ours, double factor);
/// The row of "paper" in replicate.json.
[[nodiscard]] Json compared(const Printed& print, const Answer& answer);

/// Coefficient of variation of an RVM posterior whose mean was printed as `mean`, for a least-squares standard
/// deviation `se`: the prior at its best alpha shrinks mean and variance by gamma = 1 - 1/t^2.
[[nodiscard]] double expected_cov(double mean, double se);

/// Rows of "paper" for all printed numbers of the case's table, and for the printed equations run free at the held-out
/// ratios: their errors are ours, the paper has none; expected there is the mean NMSE over draws of the stated noise,
/// to first order in it, ours the median. The verdicts hold the print against the noise it states, whatever noise ours
/// were made with: expected values come from noise-free columns and targets.
[[nodiscard]] Json compare_with_paper(const CaseReplication& replication);

}  // namespace apps
