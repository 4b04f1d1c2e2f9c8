#pragma once
#include <string>
#include <vector>

#include "apps/paper/paper_tables.hpp"
#include "apps/paper/replicate_case.hpp"

namespace apps {

/// A printed number beside ours.
struct Comparison {
  int table = 0;
  std::string row, term, method;  ///< method: "fast_rvm", "slow_rvm" or "sindy", as printed
  std::string quantity;           ///< "mean", "cov", "free_run" (NMSE of the signal `term`) or "seconds"
  double paper = 0.0;             ///< of free runs ours of the printed equation, the paper gives none; NaN: it diverges
  double expected = 0.0;          ///< what the stated method gives without the luck of a draw; NaN: not known
  double ours = 0.0;      ///< mean over the seeds that keep the term, of free runs their median; NaN: there is none
  double ours_std = 0.0;  ///< mean posterior standard deviation; NaN for covs and seconds
  PaperVerdict verdict;
  double ratio = 0.0;  ///< omega / omega_n of a free run
};

/// All printed numbers of the case's table. The verdicts hold the print against the noise it states, 10 %, whatever
/// noise ours were made with: expected values come from noise-free columns and targets.
[[nodiscard]] std::vector<Comparison> compare_with_paper(const CaseReplication& replication);

}  // namespace apps
