#pragma once
#include <string>
#include <vector>

#include "apps/page/run_results.hpp"

namespace apps {

/// Something a person should change, and the lines that do it.
struct Remedy {
  std::string why;                 ///< a sentence: what was found, and in which file the lines go
  std::vector<std::string> lines;  ///< to be pasted; none: there is no such line
};

/// What would make the run better, the most urgent first: what is wrong with the sensors and was not corrected; what
/// the judgement of the chosen equation found missing; other warnings on the data; sensors that were corrected here.
[[nodiscard]] std::vector<Remedy> remedies(const RunResults& results);

}  // namespace apps
