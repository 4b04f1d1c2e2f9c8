#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "apps/identify.hpp"

namespace apps {

enum class Describes { yes, in_part, no, unknown };
/// "yes", "in part", "no", "unknown".
[[nodiscard]] std::string_view to_string(Describes describes);

/// Whether an equation describes its record, as one sentence for a person, and what that rests on.
struct Verdict {
  Describes describes = Describes::unknown;
  std::string sentence;
};

/// Of fit `method` of range `range`. The free run decides: x followed to 2 % of its power is yes, to 10 % in part,
/// worse or diverged is no. A power balance beyond 0.02, a test error ten times the training error, or another equation
/// in another range takes a yes down to in part; without a free run it is unknown, and no where more than a tenth of
/// the target's power is left over. Ranges agree where the terms that matter (a twentieth of the target's largest or
/// more) are in both and within 10 %.
[[nodiscard]] Verdict verdict(const std::vector<RangeResult>& ranges, std::size_t range, std::size_t method);

}  // namespace apps
