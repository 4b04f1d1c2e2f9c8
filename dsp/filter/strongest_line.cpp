#include "dsp/filter/strongest_line.hpp"

#include <algorithm>

#include "dsp/filter/fft.hpp"

namespace dsp {

using Eigen::Index;

SpectralLine strongest_line(const Eigen::Ref<const Eigen::VectorXd>& signal, double sample_rate_hz) {
  const Eigen::VectorXd power = RealFft(signal.size()).forward(signal.array() - signal.mean()).cwiseAbs2();
  Index k = 0;
  power.tail(power.size() - 1).maxCoeff(&k);
  ++k;
  const Index low = std::max<Index>(k - 2, 1), high = std::min(k + 3, power.size());
  return {static_cast<double>(k) * sample_rate_hz / static_cast<double>(signal.size()),
          power.segment(low, high - low).sum() / power.tail(power.size() - 1).sum()};
}

}  // namespace dsp
