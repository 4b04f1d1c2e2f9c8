#pragma once
#include <string>
#include <vector>

#include "ident/joint_fit.hpp"

namespace apps {

/// For each range: the joint equations, coefficients with both standard deviations, and what each record says of them:
/// the records that say most first, no more than `most_records`.
[[nodiscard]] std::string joint_text(const std::vector<ident::JointResult>& results, std::size_t most_records = 20);

/// The fit that speaks for all: of the first method that keeps a term; nullptr: none does.
[[nodiscard]] const ident::JointFit* shown_fit(const ident::JointResult& result);
void shown_fit(const ident::JointResult&&) = delete;

/// Records by falling error of the equation that the others give; those without one last.
[[nodiscard]] std::vector<const ident::RecordCheck*> worst_first(const ident::JointFit& fit);

/// {"ranges": [{"name", "records", "left_out", "methods": [{"method", "status", "text", "terms": [{"name", "recording"
/// (of a term of one record), "mean",
/// "std", "std_over_records", "unit"}], "covariance", "records": [{"record", "nmse", "nmse_left_out",
/// "left_out_text"}]}]}]}
[[nodiscard]] std::string joint_json(const std::vector<ident::JointResult>& results);

/// Of records of any ranges: those of each range name together, in order of appearance. What cannot be fitted together
/// throws, as joint_fit and dsp::Fault (input, "factors.twice") for one recording counted twice in a range.
[[nodiscard]] std::vector<ident::JointResult> joint_fits(const std::vector<ident::RecordFactors>& records,
                                                         const std::vector<ident::MethodOptions>& methods,
                                                         const ident::Poll& poll);

/// What a person should know of records that are fitted together though they were not prepared alike; empty: nothing.
[[nodiscard]] std::vector<std::string> differences(const std::vector<ident::RecordFactors>& records);

}  // namespace apps
