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

/// The one judgement of an equation: the verdict, the sentence that says it with what it rests on, and remarks on what
/// a reader of its coefficients must know.
struct Judgement {
  Verdict verdict = Verdict::undecided;
  std::string sentence;
  std::vector<std::string> remarks;
};

}  // namespace ident
