#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "apps/paper/findings.hpp"
#include "apps/paper/section4.hpp"
#include "ident/equation/equation_of_motion.hpp"

namespace apps {

struct ReplicateOptions {
  int num_seeds = 1;
  std::uint64_t first_seed = 1;
  double noise = 0.1;  ///< fraction of each target's standard deviation; of the rig, times the sensors' own
  ident::Selection selection = ident::Selection::evidence_white;  ///< the paper counts every row in full
  double tau = -1.0;                                              ///< negative: the selection's own
};

/// A held-out record with the free run of the first seed's fast RVM over it.
struct HeldOutRun {
  Section4Record record;
  sim::Simulation identified;
};

struct CaseReplication {
  Section4Study study;
  std::vector<HeldOutRun> runs;
  /// The rows of replicate.json: "fits" of every equation by fast_rvm, slow_rvm, multi_rvm, sindy, sindy_raw, lasso and
  /// ols; "free_run" and "one_step" errors and "bands" at the held-out ratios; seconds to "accumulate".
  Json document;
};

/// Simulates a case, fits every row by every method for every seed, and runs the identified equations at the held-out
/// ratios: fast_rvm for every seed, slow_rvm and sindy for the first. Times are CPU seconds, of a fit from the R factor
/// on (multi_rvm: an equal fraction of the common fit). `between`: called now and then with the fraction done; may
/// throw to end it.
[[nodiscard]] CaseReplication replicate_case(const Section4Case& definition, const ReplicateOptions& options,
                                             const std::function<void(double)>& between = {});

/// These equations of a case's states run free from rest, driven by the force of a record, over that record's time.
/// Ends early (diverged) where a state grows beyond a hundred times the largest true one.
[[nodiscard]] sim::Simulation free_response(const Section4Case& definition,
                                            const std::vector<ident::StateEquation>& equations,
                                            const Section4Record& record);
/// NMSE of a state of such a run against the record; NaN where it diverged.
[[nodiscard]] double state_error(const sim::Simulation& run, const Section4Record& record, Eigen::Index state);
/// An equation of a row in terms of the library.
[[nodiscard]] ident::StateEquation state_equation(const Section4Study& study, const Section4Row& row,
                                                  const std::vector<Eigen::Index>& terms,
                                                  const Eigen::VectorXd& coefficients);

}  // namespace apps
