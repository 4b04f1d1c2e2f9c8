#pragma once
#include <span>
#include <string>
#include <string_view>

namespace apps {

/// One coefficient of Tables 1-8 and 10-12 of [QZS23] as printed, in our terms and signs; NaN: not printed. Those of
/// Tables 10-12 belong to columns of unit maximum. Text damage of the source (x^2/|x| for |v|, lost bars) is repaired;
/// in Table 4 the two terms with lost bars are x|v| and |x||v|, the only pair of products that a least-squares fit of
/// the printed equation allows.
struct PaperTerm {
  int table = 0, row = 0;
  const char* where = "";  ///< condition on the rows, as in Section4Row
  const char* term = "";
  double fast_rvm = 0.0, slow_rvm = 0.0, sindy = 0.0;
  double cov_fast_rvm = 0.0, cov_slow_rvm = 0.0;  ///< coefficients of variation beneath them
  /// The coefficient by "fast_rvm", "slow_rvm" or "sindy".
  [[nodiscard]] double printed(std::string_view method) const;
};
[[nodiscard]] std::span<const PaperTerm> paper_terms();

/// CPU seconds printed for the same case, on an i9-12950HX, whatever they contain.
struct PaperSeconds {
  int table = 0;
  double fast_rvm = 0.0, slow_rvm = 0.0, sindy = 0.0;
};
[[nodiscard]] std::span<const PaperSeconds> paper_seconds();

/// Table 9: NMSE of the acceleration by F-RVM, S-RVM and SINDy, for the regime whose equation is in `table`.
struct PaperErrors {
  int table = 0;
  double train[3] = {}, test[3] = {};
};
[[nodiscard]] std::span<const PaperErrors> paper_errors();

/// How a printed number relates to what the stated method gives.
struct PaperVerdict {
  std::string verdict;  ///< "within noise", "misprint" or "not reproducible"
  std::string reason;   ///< empty within noise
};

/// A printed coefficient against the expected one: within noise if no further off than five standard deviations `se`
/// of an estimate under the stated noise. expected 0: the term is not in the true equation.
inline constexpr double stds_allowed = 5.0;
[[nodiscard]] PaperVerdict judge_coefficient(double printed, double expected, double se);

/// Coefficient of variation of an RVM posterior whose mean was printed as `mean`, for a least-squares standard
/// deviation `se`: the prior at its best alpha shrinks mean and variance by gamma = 1 - 1/t^2.
[[nodiscard]] double expected_cov(double mean, double se);

/// A printed coefficient of variation against the expected one: within noise to 5 % (the print has two digits),
/// misprint if powers of ten or one digit explain the rest, which is inference.
[[nodiscard]] PaperVerdict judge_cov(double printed, double expected);

}  // namespace apps
