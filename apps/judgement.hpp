#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "apps/identify.hpp"

namespace apps {

enum class Trust { yes, with_care, no };
/// "trusted", "to be taken with care", "not to be trusted".
[[nodiscard]] std::string_view to_string(Trust trust);
/// Of a document; `no` for a word that is none of these.
[[nodiscard]] Trust trust_from_string(std::string_view text);

/// Whether an equation describes its record, in sentences for a person: what speaks against it first, then what it
/// rests on. Never empty.
struct Judgement {
  Trust trust = Trust::yes;
  std::vector<std::string> remarks;
};
[[nodiscard]] Judgement judge(const JudgedFit& fit);

/// What the equations of two ranges, found by one method from one library, do not agree on.
struct RangeDisagreement {
  std::string method, range_a, range_b;
  std::vector<ident::Disagreement> terms;
};
/// Every pair of ranges that disagree.
[[nodiscard]] std::vector<RangeDisagreement> compare_ranges(const std::vector<RangeResult>& ranges);

}  // namespace apps
