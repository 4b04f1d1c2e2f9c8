#pragma once
#include <vector>

#include "apps/paper/paper_comparison.hpp"
#include "apps/paper/replicate_case.hpp"

namespace apps {

/// The printed equations run free at the held-out ratios, every state and method: quantity "free_run", ours beside
/// them. expected: the mean NMSE over draws of the stated noise, to first order in it: that of the expected equations
/// (PrintedRow) and what a standard deviation of each independent error adds. Within noise up to stds_allowed^2 times
/// that, unless all our equations of that method lack a true term that is printed.
[[nodiscard]] std::vector<Comparison> compare_free_runs(const CaseReplication& replication);

}  // namespace apps
