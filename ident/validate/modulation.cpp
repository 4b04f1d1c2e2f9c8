#include "ident/validate/modulation.hpp"

#include <cmath>

#include "dsp/filter/fft.hpp"
#include "dsp/values/constants.hpp"

namespace ident {

using Eigen::Index;
using Eigen::VectorXd;

std::optional<double> modulation_rad_s(const Eigen::Ref<const VectorXd>& residual, const std::vector<Row>& rows,
                                       const std::vector<Columns>& recordings) {
  constexpr double by_chance = 1e-3, least_periods = 2.0;
  constexpr Index bins = 4, least_rows = 64;  // of a spectral line
  const dsp::Motion& motion = *recordings[rows.front().recording].signals;
  const dsp::Signal* const x = motion.find("x");
  if (x == nullptr || std::ssize(rows) < least_rows || rows.front().recording != rows.back().recording)
    return std::nullopt;
  const Index first = rows.front().sample, span = rows.back().sample - first + 1;
  VectorXd product = VectorXd::Zero(dsp::good_fft_size(bins * span));
  double of_x = 0.0;
  for (Index i = 0; i < residual.size(); ++i) {
    const Index sample = rows[static_cast<std::size_t>(i)].sample;
    product(sample - first) = residual(i) * x->values(sample);
    of_x += x->values(sample) * x->values(sample);
  }
  const VectorXd power = dsp::RealFft(product.size()).forward(product).cwiseAbs2();
  const double line = static_cast<double>(product.size()) / static_cast<double>(span);
  const auto lowest = static_cast<Index>(std::ceil(least_periods * line));
  if (lowest >= power.size()) return std::nullopt;
  Index at = 0;
  const double largest = power.tail(power.size() - lowest).maxCoeff(&at);
  const double of_noise = residual.squaredNorm() / static_cast<double>(residual.size()) * of_x;
  if (!(largest > of_noise * std::log(0.5 * static_cast<double>(span) / by_chance))) return std::nullopt;
  return dsp::two_pi * static_cast<double>(lowest + at) * motion.sample_rate_hz / static_cast<double>(product.size());
}

}  // namespace ident
