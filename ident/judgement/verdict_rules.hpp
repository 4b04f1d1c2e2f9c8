#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ident/judgement/findings.hpp"
#include "ident/judgement/range_agreement.hpp"
#include "ident/validate/range_result.hpp"

// What takes the verdict of an equation down that its free run has: one rule a row, from which judgement, remedies,
// help and docs/method.md are made.

namespace ident {

/// What the rules look at: a fit, beside those of other ranges. Nothing is owned.
struct Evidence {
  const RangeResult& range;
  const JudgedFit& fit;
  Findings found;
  Agreement others;
  /// One with more rows whose own equation by the same method does not describe it; null: none.
  const RangeResult* larger = nullptr;
};

struct VerdictRule {
  std::string_view name;       ///< "out_of_step"
  Verdict at_most;             ///< where it holds (Judgement, preference)
  std::string_view condition;  ///< in words, with its threshold
  std::string_view reason;     ///< of the threshold
  std::string_view remedy;     ///< a sentence; empty: it follows from the cause
  /// What holds is its own cause, and its clause says it, ahead of others; no other is looked for where there is no
  /// other rule.
  bool is_cause = false;
  bool only_alone = false;  ///< a doubt that does not matter where another rule holds
  bool (*holds)(const Evidence&) = nullptr;
  /// Of the judgement's sentence; null or an empty text: the judgement says it elsewhere. Of a rule that is no cause
  /// it says as well that nothing is wrong.
  std::string (*clause)(const Evidence&) = nullptr;
};

/// In the order of their clauses.
[[nodiscard]] std::span<const VerdictRule> verdict_rules();

/// The greater, the rather an equation speaks for its record: does not, undecided, in part, describes.
[[nodiscard]] int preference(Verdict verdict);

}  // namespace ident
