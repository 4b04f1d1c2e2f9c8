#pragma once
#include "apps/paper/replicate_case.hpp"

// The system of Table 4 of [QZS23] as it is, not as an equivalent equation: its third state is found from two.

namespace apps {

/// For a case with a state that was not measured: the training records of the others, with white noise of
/// options.noise times each state's standard deviation, identified with that state (ident/bodies), and its equations
/// run free at the held-out ratios, from rest. Into document, of the first seed: "inner_terms" with the truth,
/// "inner_runs" with the NMSE of x, "inner_fit" with the reason where nothing was found. Nothing for other cases, or
/// without noise.
void replicate_inner_state(CaseReplication& replication, const ReplicateOptions& options);

/// The same as text; empty where there is none.
[[nodiscard]] std::string inner_state_text(const CaseReplication& replication);

}  // namespace apps
