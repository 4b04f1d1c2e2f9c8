#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ident {

/// Whether an equation describes the record it was identified from.
enum class Verdict { describes, in_part, does_not, undecided };
/// "describes", "in_part", "does_not", "undecided".
[[nodiscard]] std::string_view to_string(Verdict verdict);
/// Nothing for another word.
[[nodiscard]] std::optional<Verdict> verdict_from_string(std::string_view word);

/// Why an equation does not describe its record, or in part only; named where a test found it.
enum class Cause {
  not_found,
  missing_input,    ///< something drives the motion that is not in the equation
  missing_term,     ///< what is left over is a function of the state, or of its past
  wide_band,        ///< noise above the motion's frequencies is let in
  noise,            ///< of a derivative or of a regressor
  switch_variable,  ///< a sign is that of the wrong motion
  late_input,       ///< what drives the motion arrives late, and not as a delay would have it: an actuator's lag
  exchanged_roles,  ///< what is called the base moves as a payload would
  imposed_motion    ///< a recorded force follows x and v, as where a machine imposes the motion
};
/// "not_found", "missing_input", ...
[[nodiscard]] std::string_view to_string(Cause cause);

/// Something that is not in an equation and explains part of what that leaves over.
struct Explanation {
  std::string what;  ///< "f", "sgn(dy)"
  Cause cause = Cause::not_found;
  double fraction = 0.0;    ///< of the residual's power
  bool is_recorded = true;  ///< a signal; else a form that is commonly met
  bool candidate = false;   ///< it was one, and not taken
  bool at_motion = false;   ///< `fraction` is of what the residual has at the frequencies of the motion (MotionScore)
  bool is_term = true;      ///< a library can have it; else `what` is said in words
  /// Kept terms that only imitate it: an equation that has it in their place has the better evidence.
  std::vector<std::string> instead_of = {};
  std::vector<std::string> parts = {};  ///< terms that a library has in its place; empty: it is one
};

struct VerdictRule;  // judgement/verdict_rules.hpp

/// The one judgement of an equation: the verdict, the sentence that says it with what it rests on, and remarks on what
/// a reader of its coefficients must know.
struct Judgement {
  Verdict verdict = Verdict::undecided;
  std::vector<const VerdictRule*> rules = {};  ///< that took it down; of verdict_rules(), which outlive everything
  std::optional<Cause> cause = {};        ///< nothing where there is nothing to explain, or a term is in doubt only
  std::optional<Explanation> named = {};  ///< what the cause is, where it has a name
  std::string sentence;
  std::vector<std::string> remarks;
};

}  // namespace ident
