#include "apps/page/filter_response.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace apps {
namespace {

/// Mean over the phases, each advanced to the input sample it lies behind.
double gain(const dsp::FilterStage& stage, double frequency_hz) {
  const double cycles = frequency_hz / stage.input_rate_hz, middle = 0.5 * static_cast<double>(stage.taps.rows() - 1);
  std::complex<double> sum = 0.0;
  for (Eigen::Index p = 0; p < stage.taps.cols(); ++p)
    for (Eigen::Index i = 0; i < stage.taps.rows(); ++i) {
      const double offset = static_cast<double>(i) - middle - static_cast<double>(p) / stage.up;
      sum += std::polar(stage.taps(i, p), 2.0 * std::numbers::pi * cycles * offset);
    }
  return std::abs(sum) / static_cast<double>(stage.taps.cols());
}

}  // namespace

double gain_db(const dsp::FilterSheet& sheet, double frequency_hz) {
  constexpr double least_db = -200.0;
  double total = 0.0;
  for (const dsp::FilterStage& stage : sheet.stages)
    total += 20.0 * std::log10(std::max(gain(stage, frequency_hz), 1e-10));
  return std::max(total, least_db);
}

}  // namespace apps
