// Pairs of channels of one body of which one may have been computed from the other: compared by sign and size alone.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "dsp/sensors/sensor_consistency.hpp"

namespace dsp {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

// Where the motion that a signal shows ends.
double highest_motion_hz(const ExtendedSpectrum& spectrum, double rate_hz) {
  constexpr double fraction_above = 0.01, resolution = 1e-3;
  double low_hz = 0.0, high_hz = 0.2 * rate_hz;  // twice that is free of the recorder's own filter
  if (spectrum.power_fraction_above(high_hz) > fraction_above) return high_hz;
  while (high_hz - low_hz > resolution * high_hz) {
    const double middle_hz = 0.5 * (low_hz + high_hz);
    (spectrum.power_fraction_above(middle_hz) > fraction_above ? low_hz : high_hz) = middle_hz;
  }
  return high_hz;
}

// Sums over the samples that count, away from the ends, where both are predicted.
struct Moments {
  double dd = 0.0, da = 0.0, aa = 0.0, count = 0.0;
};
Moments moments(const VectorXd& d, const VectorXd& a, Index edge, const std::vector<unsigned char>& excluded) {
  Moments sums;
  double d_sum = 0.0, a_sum = 0.0;
  for (Index i = edge; i + edge < d.size(); ++i) {
    if (i < std::ssize(excluded) && excluded[static_cast<std::size_t>(i)] != 0) continue;
    d_sum += d(i), a_sum += a(i), sums.count += 1.0;
    sums.dd += d(i) * d(i), sums.da += d(i) * a(i), sums.aa += a(i) * a(i);
  }
  if (sums.count == 0.0) return sums;
  sums.dd -= d_sum * d_sum / sums.count, sums.da -= d_sum * a_sum / sums.count, sums.aa -= a_sum * a_sum / sums.count;
  return sums;
}

SensorRelation relate_derivative(ColumnSpectra& spectra, Index lower, Index higher, int order,
                                 const std::vector<unsigned char>& excluded) {
  const double rate_hz = spectra.recording().sample_rate_hz;
  SensorRelation relation;
  relation.order = order;
  relation.sign_and_unit_only = true;
  const double edge_hz = highest_motion_hz(spectra.of(higher), rate_hz);
  const SpectralBand band{1.5 * edge_hz, 2.0 * edge_hz};  // wide enough for the skirts of what ends there
  const VectorXd d = spectra.of(lower).derivative(order, band), a = spectra.of(higher).derivative(0, band);
  const auto ends = static_cast<Index>(std::min(rate_hz / (0.5 * edge_hz), 0.25 * static_cast<double>(d.size())));
  const Moments sums = moments(d, a, ends, excluded);
  const double correlation = sums.dd > 0.0 && sums.aa > 0.0 ? sums.da / std::sqrt(sums.dd * sums.aa) : 0.0;
  constexpr double least_correlation = 0.7;  // half of the power at least is common to both
  if (std::abs(correlation) < least_correlation) {
    relation.reason = "the two do not describe one motion";
    return relation;
  }
  relation.sign = correlation < 0.0 ? -1.0 : 1.0;
  relation.gain = std::sqrt(sums.aa / sums.dd);
  relation.residual = std::sqrt(std::max(0.0, 1.0 - correlation * correlation));
  // As many independent values as twice the band times the time.
  const double values = std::max(1.0, 2.0 * edge_hz * sums.count / rate_hz);
  relation.gain_std = relation.gain * relation.residual / std::sqrt(values);
  return relation;
}

}  // namespace

std::vector<SensorRelation> relate_derivatives(ColumnSpectra& spectra, const std::vector<unsigned char>& excluded) {
  constexpr Index least_samples = 64;  // fewer show no motion
  constexpr std::array<std::array<Role, 3>, 3> bodies{
      {{Role::x, Role::v, Role::a}, {Role::r, Role::dr, Role::ddr}, {Role::y, Role::dy, Role::ddy}}};
  const Recording& recording = spectra.recording();
  std::vector<SensorRelation> relations;
  for (const auto& roles : bodies)
    for (const auto& [from, to] : {std::pair{0, 2}, std::pair{0, 1}, std::pair{1, 2}}) {
      const auto lower = static_cast<std::size_t>(from), higher = static_cast<std::size_t>(to);
      const Index d = recording.find(roles[lower]), a = recording.find(roles[higher]);
      const bool related_elsewhere = roles[0] != Role::x && to - from == 2;
      if (d < 0 || a < 0 || related_elsewhere || (from == 1 && recording.find(roles[0]) >= 0) ||
          recording.samples.rows() < least_samples)
        continue;
      SensorRelation relation = relate_derivative(spectra, d, a, to - from, excluded);
      relation.from_order = from;
      relation.name = std::string(to_string(roles[lower])) + " and " + std::string(to_string(roles[higher]));
      relation.displacement = recording.channels[static_cast<std::size_t>(d)].name;
      relation.acceleration = recording.channels[static_cast<std::size_t>(a)].name;
      relation.calibration_std = std::hypot(recording.channels[static_cast<std::size_t>(d)].sensitivity_uncertainty,
                                            recording.channels[static_cast<std::size_t>(a)].sensitivity_uncertainty);
      relations.push_back(std::move(relation));
    }
  return relations;
}

}  // namespace dsp
