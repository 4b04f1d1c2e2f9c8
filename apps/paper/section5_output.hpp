#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "apps/paper/section5_comparison.hpp"

namespace apps {

/// Table 9: errors by regime and method, the paper's beside ours by every way, with free runs and what differs.
[[nodiscard]] std::string section5_errors_table(const Section5Replication& replication,
                                                const std::vector<const Section5Case*>& cases,
                                                const Section5Options& options);
/// Tables 10-12: a regime's coefficients at unit maximum beside the paper's and in SI beside the truth, times, reasons.
[[nodiscard]] std::string section5_table(const Section5Replication& replication, const Section5Case& definition,
                                         const Section5Options& options);

/// Fig. 11: amplitude against frequency of both twins, up and down.
[[nodiscard]] std::string section5_sweeps_figure();
/// Fig. 12: the measured states of each regime.
[[nodiscard]] std::string section5_states_figure(const Section5Replication& replication);
/// Fig. 13: measured and identified acceleration of each regime, by the paper's recipe on T1, whole and a few seconds
/// of the test part.
[[nodiscard]] std::string section5_responses_figure(const Section5Replication& replication);

/// Puts the regimes' rows into replicate.json's "fits", "free_run" and "paper", and "sensors".
void append_section5(nlohmann::ordered_json& document, const Section5Replication& replication,
                     const std::vector<const Section5Case*>& cases, const Section5Options& options);

}  // namespace apps
