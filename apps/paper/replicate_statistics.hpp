#pragma once
#include <string>

#include "apps/paper/replicate_case.hpp"

namespace apps {

/// How well error bars and bands of the fast RVM hold over all seeds of a case, a line each: coverage of the 95 %
/// intervals and the largest error, on exact supports; median errors against those the noise allows; fractions of noisy
/// held-out targets inside their predictive bands; the times from R and to it.
[[nodiscard]] std::string statistics_text(const CaseReplication& replication, double noise);

}  // namespace apps
