#include "dsp/values/recording.hpp"

namespace dsp {
Eigen::Index Recording::find(Role role) const {
  for (std::size_t i = 0; i < channels.size(); ++i)
    if (channels[i].role == role) return static_cast<Eigen::Index>(i);
  return -1;
}

}  // namespace dsp
