#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/paper/section4.hpp"
#include "ident/validate/metrics.hpp"

namespace apps {

struct ReplicateOptions {
  int num_seeds = 1;
  std::uint64_t first_seed = 1;
  double noise = 0.1;
  ident::Selection selection = ident::Selection::evidence_white;  ///< the paper counts every row in full
  double tau = -1.0;                                              ///< negative: the selection's own
};

/// One regression of one row by one method.
struct CaseFit {
  std::uint64_t seed = 0;
  std::size_t regression = 0, row = 0;  ///< into the study
  std::string method;                   ///< "fast_rvm" "slow_rvm" "multi_rvm" "sindy" "sindy_raw" "lasso" "ols"
  ident::Fit fit;
  SupportError error;    ///< empty where no truth is known
  double seconds = 0.0;  ///< CPU, from the R factor on; multi_rvm: an equal fraction of the common fit
};

/// What identified equations say of a held-out record.
struct HeldOutScore {
  std::uint64_t seed = 0;
  std::string method, kind;  ///< kind: "free_run" or "one_step"
  double ratio = 0.0;
  std::string signal;
  double nmse = 0.0;   ///< NaN: there is none, see status
  std::string status;  ///< "finished", or why not and when
};

/// Fraction of noisy held-out targets inside the predictive bands.
struct HeldOutBands {
  std::uint64_t seed = 0;
  std::string row;
  double ratio = 0.0;
  ident::BandFractions fractions;
};

/// A held-out record with the free run of the first seed's fast RVM over it.
struct HeldOutRun {
  Section4Record record;
  sim::Simulation identified;
};

struct CaseReplication {
  Section4Study study;
  std::vector<CaseFit> fits;
  std::vector<HeldOutScore> scores;
  std::vector<HeldOutBands> bands;
  std::vector<HeldOutRun> runs;
  double accumulate_seconds = 0.0;  ///< CPU from columns and targets to R factors, mean over seeds
  [[nodiscard]] const Section4Row& row_of(const CaseFit& fit) const& {
    return study.regressions[fit.regression].rows[fit.row];
  }
  void row_of(const CaseFit&) const&& = delete;
};

/// Threshold on raw coefficients of "sindy_raw": 0.143 is the largest that keeps every term the paper's SINDy printed.
inline constexpr double raw_threshold = 0.1;

/// Simulates a case, fits every row by every method for every seed, and runs the identified equations at the held-out
/// ratios: fast_rvm for every seed, slow_rvm and sindy for the first. `between`: called now and then with the fraction
/// done; may throw to end it.
[[nodiscard]] CaseReplication replicate_case(const Section4Case& definition, const ReplicateOptions& options,
                                             const std::function<void(double)>& between = {});

}  // namespace apps
