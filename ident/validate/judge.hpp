#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ident/identify.hpp"

namespace ident {

/// Judges every fit of every range and stores the result in its `judgement`; the fits of one range are compared with
/// those of the others by the same method. The free run decides: x followed to 2 % of its power is describes, to 10 %
/// in part, worse or diverged is does not describe. Describes is taken down to in part by a fit that did not converge,
/// structure in a residual of more than a thousandth of the target's power, a power balance beyond 0.02, a test error
/// ten times the training error, or another equation in another range. Without a free run it is undecided, and does
/// not describe where more than a tenth of the target's power is left over. Ranges agree where the terms that matter
/// (a twentieth of the target's largest or more) are in both and within 10 %.
void judge(std::vector<RangeResult>& ranges);

/// The equation that speaks for a run: the one with the best verdict (describes, in part, undecided, does not). Among
/// equals that of the range with the most rows, then fast_rvm's, then the first. Nothing if there is no fit.
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
