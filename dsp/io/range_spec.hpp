#pragma once
#include <limits>
#include <optional>
#include <string>

namespace dsp {

/// One [[range]] of a sidecar or a config, seconds from the first sample.
struct RangeSpec {
  std::string name;
  double from_s = 0.0, to_s = std::numeric_limits<double>::infinity();  ///< infinity: to the end
  std::optional<double> train_to_s;
  std::string where;  ///< condition, empty: all samples
  std::string place;
};

}  // namespace dsp
