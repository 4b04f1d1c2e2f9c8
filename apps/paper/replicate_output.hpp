#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "apps/paper/paper_comparison.hpp"
#include "apps/paper/replicate_case.hpp"

namespace apps {

/// A case as it goes to the files.
struct ReplicatedCase {
  CaseReplication replication;
  std::vector<Comparison> comparisons;
};

/// replicate.json of the contract: fits, free_run, paper; and with them one_step and bands at the held-out ratios.
[[nodiscard]] nlohmann::ordered_json replicate_json(const std::vector<ReplicatedCase>& cases,
                                                    const ReplicateOptions& options);

/// A row of its "paper".
[[nodiscard]] nlohmann::ordered_json comparison_json(const Comparison& comparison);

/// Our table beside the paper's, as text: every printed number with ours and the verdict, what was found how often.
[[nodiscard]] std::string replicate_table(const ReplicatedCase& replicated, const ReplicateOptions& options);

/// The paper's figure of the case: true against identified responses at the held-out ratios, as SVG.
[[nodiscard]] std::string replicate_figure(const ReplicatedCase& replicated);

}  // namespace apps
