#pragma once
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "ident/validate/range_result.hpp"

// What speaks for an equation and against it, and why it fails: what judge.hpp puts into words.

namespace ident {

/// A smaller part, of the target's power or of what is left of it, does not matter.
inline constexpr double matters_to_power = 0.1;

/// Standard deviations of what is known beforehand that are too many: a normal variate exceeds them once in 16,000.
inline constexpr double far_off = 4.0;

/// Of a fit on a range, apart from other ranges.
struct Findings {
  Verdict by_run = Verdict::undecided;
  double run_error = std::numeric_limits<double>::quiet_NaN();    ///< NMSE of the free run beyond what noise makes;
                                                                  ///< NaN: none
  double unexplained = std::numeric_limits<double>::quiet_NaN();  ///< of the target's variation one step ahead, beyond
                                                                  ///< the noise of the channels
  bool noise_is_known = false;
  double noise_share = 0.0;  ///< of the power of what is left on the training rows, at most
  bool is_noise = false;     ///< what is left on the training rows is the noise of the channels
  bool residual_negligible =
      false;                   ///< what is left on the training rows is what sensors make that are not quite linear
  bool above_noise = false;    ///< what is left on the training rows is more than noise
  bool misses_motion = false;  ///< and so is what lies where the target is more than noise, whatever noise is beside
  bool may_lack_at_motion = false;  ///< a term that is not in the equation may show there
  bool shows_at_motion = false;     ///< one does, beyond chance
  bool too_sensitive = false;  ///< x is missed by a run whose errors grow tenfold and again, with noise alone left over
  bool is_buried = false;      ///< most of x is its noise: following it shows nothing
  bool is_conservative = false;  ///< nothing drives the equation or damps it: every steady motion of its period will do
  bool fitted_to_its_rows = false;
  /// Terms whose 95 % interval includes zero by noise alone, sensors and terms that were left out aside, in a fit of
  /// this range to the same terms; of coefficients of each recording where all do.
  std::vector<std::string> doubtful;
  std::string biased;  ///< a term whose interval misses by noise of the regressors
  /// A term that may be missing at the frequencies of the motion is all that was found against it.
  [[nodiscard]] bool only_doubt_is_missing_term() const;
  /// The free run follows x, in part at least.
  [[nodiscard]] bool follows_roughly() const { return run_error <= follows_in_part; }
};
[[nodiscard]] Findings findings_of(const RangeResult& range, const JudgedFit& fit);

/// NMSE about the mean, of the test rows where there are any: of a force about its rest the mean is most of the power
/// and none of the news.
[[nodiscard]] Figure error_of(const JudgedFit& fit);
/// The training residual is not white.
[[nodiscard]] bool is_structured(const JudgedFit& fit);
/// Most of what is in the band of the target is noise.
[[nodiscard]] bool has_wide_band(const RegressorNoise& noise);
/// And what it leaves over matters: a lower cut-off takes most of it away.
[[nodiscard]] bool lower_band_helps(const JudgedFit& fit);
/// Something recorded that is not in the equation explains a part that matters of what is left over beside noise.
[[nodiscard]] bool leaves_out_recorded(const JudgedFit& fit, const Findings& found);

/// Kept terms only imitate a form that is no candidate.
[[nodiscard]] bool imitates(const JudgedFit& fit);
/// A usual form that is no candidate explains most of what is left over beside noise: the record itself shows the term
/// that is missing, however well the rest is followed.
[[nodiscard]] bool lacks_form(const JudgedFit& fit, const Findings& found);
/// With a form that is no candidate the equation is better, and kept terms only imitate it, or what is left over
/// without it is more than sensors that are not linear make.
[[nodiscard]] bool better_term_exists(const JudgedFit& fit, const Findings& found);

/// By how much the motion answers late what drives it in the equation, where that is far beyond what its sensors may be
/// out of step by; nothing elsewhere.
[[nodiscard]] std::optional<double> lateness_s(const JudgedFit& fit);

/// Why an equation does not describe its record.
struct NamedCause {
  Cause cause = Cause::not_found;
  std::optional<Explanation> explanation = {};  ///< what the cause is, where it has a name
};
/// Named where a test found it. In this order: something recorded explains what is left over; noise biases a
/// coefficient; kept terms imitate a form; amplitude comes back that was lost, though nothing drives the equation; a
/// term shows at the frequencies of the motion and is most of what is left over there, or all that speaks against an
/// equation that is followed; what is left over is noise; a form that is no candidate explains most of it; the motion
/// answers late; but for noise it comes back with the state, or nothing in the equation drives the motion and it does
/// not.
[[nodiscard]] NamedCause cause_of(const RangeResult& range, const JudgedFit& fit, const Findings& found);
/// Of a record for which no equation was found.
[[nodiscard]] NamedCause cause_of_none(const RangeResult& range, const JudgedFit& fit);

}  // namespace ident
