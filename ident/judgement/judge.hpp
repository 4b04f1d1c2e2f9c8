#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ident/judgement/verdict_rules.hpp"
#include "ident/validate/range_result.hpp"

namespace ident {

/// Judges every fit of every range and stores the result in its `judgement`; the fits of one range are compared with
/// those of the others by the same method. The free run decides: x followed to 1 % of its power about the mean, beyond
/// what noise makes, is describes, to 10 % in part, worse or diverged does not describe; where nothing drives the
/// equation, the worse of its runs through training and test rows. Where there is none to be had it is undecided, and
/// so it is where errors grow tenfold and again within the record and no more than noise is left over. Of a law that is
/// no equation of motion the error one step ahead decides, beyond that noise. What takes that down are the rules of
/// verdict_rules.hpp. A cause is named where a test found it (cause_of in findings.hpp), and none where rules that are
/// their own cause took it down.
void judge(std::vector<RangeResult>& ranges);

/// The equation that speaks for a run: of each range that of fast_rvm, one method for all, since the best of several
/// verdicts is better than any of them is worth. Where it found none, the one with the best verdict (describes, in
/// part, undecided, does not), then the first. Among ranges that with the best verdict, then with the most rows.
/// Nothing if there is no fit.
struct ChosenFit {
  std::size_t range = 0, method = 0;
};
[[nodiscard]] std::optional<ChosenFit> chosen_fit(const std::vector<RangeResult>& ranges);
/// The same within one range.
[[nodiscard]] std::size_t chosen_method(const RangeResult& range);

/// What the equations of two ranges, found by one method from one library, do not agree on.
struct RangeDisagreement {
  std::string method, range_a, range_b;
  std::vector<Disagreement> terms;
};
/// Every pair of ranges that disagree.
[[nodiscard]] std::vector<RangeDisagreement> compare_ranges(const std::vector<RangeResult>& ranges);

}  // namespace ident
