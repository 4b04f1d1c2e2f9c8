#include "apps/page/power_spectrum.hpp"

#include <algorithm>
#include <cmath>

#include "dsp/filter/fft.hpp"

namespace apps {

using Eigen::Index;
using Eigen::VectorXd;

PowerSpectrum power_spectrum_db(const Eigen::Ref<const VectorXd>& values, double sample_rate_hz) {
  constexpr Index longest = 2048, least_segments = 8, shortest = 32;
  constexpr double most_missing = 0.1;
  Index size = longest;
  while (size > shortest && values.size() < size * least_segments / 2) size /= 2;
  const VectorXd window = dsp::hann_window(size);
  const dsp::RealFft fft(size);
  VectorXd sum = VectorXd::Zero(size / 2 + 1);
  double count = 0.0;
  Eigen::VectorXcd spectrum;
  for (Index first = 0; first + size <= values.size(); first += size / 2) {
    VectorXd segment = values.segment(first, size);
    const auto missing = static_cast<double>((!segment.array().isFinite()).count());
    if (missing > most_missing * static_cast<double>(size)) continue;
    segment = segment.unaryExpr([](double value) { return std::isfinite(value) ? value : 0.0; });
    fft.forward((segment.array() * window.array()).matrix(), spectrum);
    sum += spectrum.cwiseAbs2();
    count += 1.0;
  }
  if (count == 0.0 || !(sum.maxCoeff() > 0.0)) return {};
  const double scale = 2.0 / (count * sample_rate_hz * window.squaredNorm());
  const double floor = 1e-30 * scale * sum.maxCoeff();
  return {VectorXd::LinSpaced(sum.size(), 0.0, 0.5 * sample_rate_hz).tail(sum.size() - 1),
          (scale * sum.tail(sum.size() - 1)).unaryExpr([=](double power) {
            return 10.0 * std::log10(std::max(power, floor));
          })};
}

}  // namespace apps
