#include "ident/equation/verdict.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace ident {
namespace {
constexpr std::array<std::pair<Verdict, std::string_view>, 4> words{{{Verdict::describes, "describes"},
                                                                     {Verdict::in_part, "in_part"},
                                                                     {Verdict::does_not, "does_not"},
                                                                     {Verdict::undecided, "undecided"}}};
constexpr std::array<std::pair<Cause, std::string_view>, 9> causes{{{Cause::not_found, "not_found"},
                                                                    {Cause::missing_input, "missing_input"},
                                                                    {Cause::missing_term, "missing_term"},
                                                                    {Cause::wide_band, "wide_band"},
                                                                    {Cause::noise, "noise"},
                                                                    {Cause::switch_variable, "switch_variable"},
                                                                    {Cause::late_input, "late_input"},
                                                                    {Cause::exchanged_roles, "exchanged_roles"},
                                                                    {Cause::imposed_motion, "imposed_motion"}}};
}  // namespace

std::string_view to_string(Cause cause) {
  return std::find_if(causes.begin(), causes.end(), [&](const auto& row) { return row.first == cause; })->second;
}

std::string_view to_string(Verdict verdict) {
  return std::find_if(words.begin(), words.end(), [&](const auto& row) { return row.first == verdict; })->second;
}

std::optional<Verdict> verdict_from_string(std::string_view word) {
  const auto found = std::find_if(words.begin(), words.end(), [&](const auto& row) { return row.second == word; });
  return found == words.end() ? std::nullopt : std::optional(found->first);
}

}  // namespace ident
