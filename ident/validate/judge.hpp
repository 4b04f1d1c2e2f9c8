#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ident/identify.hpp"

namespace ident {

/// Judges every fit of every range and stores the result in its `judgement`; the fits of one range are compared with
/// those of the others by the same method. In this order:
/// Does not describe: something recorded explains more than a tenth of what is left over (explanation), noise of the
/// regressors biases a coefficient beyond its interval (regressor_noise), terms only imitate a form that is no
/// candidate (Explanations::better), or more than noise is left over and most of it is such a form (lacks_form). The
/// free run decides otherwise: x followed to 1 % of its power about the mean, beyond what
/// noise makes, is describes, to 10 % in part, worse or diverged does not describe; where nothing drives the equation,
/// the worse of its runs through training and test rows. Where there is none to be had it is undecided; and so it is
/// where no more than noise is left over and x is missed by what the coefficients' intervals leave open: within them it
/// is followed (closest_run). Of a law that is no equation of motion the error one step ahead decides, beyond that
/// noise. Where more than twice what the noise of the channels makes is left over, and more than the linearity of
/// sensors, an equation describes in part at best, and does not beyond 2 %; in part at best, too, where so much is left
/// over at the frequencies at which the target is more than noise, and where a term that is not in the equation may
/// show there (Explanations::may_lack_at_motion). (A table, whose noise is not known: where the residual is not white
/// and a thousandth of the target's power.) Describes is taken down to in part by a fit that did not converge, a tenth
/// of the target's power left over, a residual ten times larger on test rows, a power balance beyond 0.02, a form with
/// which the equation is better, an equation that nothing drives or damps, or another equation in another range; and by
/// a term whose coefficient may be zero by noise alone (Findings::doubtful), which has no cause. Ranges agree where the
/// terms that matter (a twentieth of the target's largest or more) are in both and within 10 %. A cause is named where
/// a test found it (cause_of in findings.hpp).
void judge(std::vector<RangeResult>& ranges);

/// The greater, the rather an equation speaks for its record: does not, undecided, in part, describes.
[[nodiscard]] int preference(Verdict verdict);

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
