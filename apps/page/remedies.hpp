#pragma once
#include <string>
#include <vector>

#include "apps/page/run_results.hpp"

namespace apps {

/// Something a person should change, and the lines that do it.
struct Remedy {
  std::string why;                 ///< a sentence: what was found, and in which file the lines go
  std::vector<std::string> lines;  ///< to be pasted; none: there is no such line
  bool optional = false;           ///< the run does without
};

/// Whether a signal moves and is no motion of the system itself as far as its name says: what ident::acts_from_outside,
/// and every channel without a role.
[[nodiscard]] bool may_act(const dsp::Signal& signal);

/// Recorded signals beside `target` that may act on the motion and are in no candidate of a range.
[[nodiscard]] std::vector<std::string> inputs_not_tried(const ident::RangeResult& range, const dsp::Motion& signals,
                                                        const std::string& target);

/// What would make the run better, the most urgent first: what is wrong with the sensors and was not corrected; what
/// the judgement of the chosen equation found missing; other warnings on the data; sensors that were corrected here.
[[nodiscard]] std::vector<Remedy> remedies(const RunResults& results);

}  // namespace apps
