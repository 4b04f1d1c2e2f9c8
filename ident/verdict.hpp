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
  missing_input,   ///< something drives the motion that is not in the equation
  missing_term,    ///< what is left over is a function of the state, or of its past
  wide_band,       ///< noise above the motion's frequencies is let in
  noise,           ///< of a derivative or of a regressor
  switch_variable  ///< a sign is that of the wrong motion
};
/// "not_found", "missing_input", ...
[[nodiscard]] std::string_view to_string(Cause cause);

/// The one judgement of an equation: the verdict, the sentence that says it with what it rests on, and remarks on what
/// a reader of its coefficients must know.
struct Judgement {
  Verdict verdict = Verdict::undecided;
  std::optional<Cause> cause = {};  ///< nothing where there is nothing to explain
  std::string sentence;
  std::vector<std::string> remarks;
};

}  // namespace ident
