#include "dsp/regimes/reversals.hpp"

#include <algorithm>
#include <cmath>

#include "dsp/filter/short_low_pass.hpp"
#include "dsp/regimes/halt_fit.hpp"
#include "dsp/regimes/halt_rows.hpp"
#include "dsp/regimes/harmonics.hpp"
#include "dsp/values/order_statistics.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double std_of_normal = 1.4826;  // in median absolute deviations

/// What a halt at a reversal gains, beside the smaller of the largest accelerations before and after.
struct Look {
  Index at = 0;
  double beside = 0.0;
  HaltFit::Result fit;
};

std::vector<double> of_all(const std::vector<Look>& looks, double (*value)(const Look&)) {
  std::vector<double> values;
  for (const Look& look : looks) values.push_back(value(look));
  return values;
}

/// What a halt that is none seems to gain at the record's reversals: the median, and by how much they differ.
struct ChanceGain {
  double usual = 0.0, std = 0.0;
};

ChanceGain chance_gain(const std::vector<Look>& looks, double per_rms) {
  std::vector<double> gains = of_all(looks, [](const Look& look) { return look.fit.gain; });
  const double usual = median(gains);
  for (double& gain : gains) gain = std::abs(gain - usual);
  return {usual, std::max(std_of_normal * median(std::move(gains)),
                          per_rms * median(of_all(looks, [](const Look& look) { return look.fit.rms; })))};
}

}  // namespace

Index sign_change_margin(Index samples_per_period) {
  return static_cast<Index>(static_cast<double>(samples_per_period) / waves_per_period);
}

std::vector<Index> sign_changes(const VectorXd& v, Index samples_per_period) {
  const Index wave = sign_change_margin(samples_per_period);
  struct Group {
    Index first, last, count;
  };
  std::vector<Group> groups;
  for (Index i = 1; i < v.size(); ++i) {
    if ((v(i) >= 0.0) == (v(i - 1) >= 0.0)) continue;
    if (!groups.empty() && 2 * (i - groups.back().last) <= wave)
      groups.back() = {groups.back().first, i, groups.back().count + 1};
    else
      groups.push_back({i, i, 1});
  }
  std::vector<Index> reversal_indices;
  for (std::size_t k = 0; k < groups.size(); ++k) {
    const Group& group = groups[k];
    const bool alone = (k == 0 || group.first - groups[k - 1].last >= wave) &&
                       (k + 1 == groups.size() || groups[k + 1].first - group.last >= wave);
    if (alone && group.count % 2 == 1 && group.first >= wave && group.last + wave < v.size())
      reversal_indices.push_back(group.first);
  }
  return reversal_indices;
}

std::vector<Reversal> reversals(const std::vector<Index>& reversal_indices, const VectorXd& v, const VectorXd& a,
                                const ReversalOptions& options) {
  const double rate_hz = options.sample_rate_hz, cutoff_hz = options.cutoff_hz;
  const ShortLowPass low_pass(cutoff_hz, rate_hz);
  const double wave = rate_hz / cutoff_hz;
  const HaltFit fit(low_pass, 1.0 / wave);
  const Index reach = fit.reach(), from_end = reach + low_pass.reach() + 1;
  std::vector<Look> looks;
  for (const Index reversal : reversal_indices) {
    if (reversal < from_end || reversal + from_end >= v.size()) continue;
    VectorXd course = low_pass(a, reversal - reach, 2 * reach + 1);
    if (v(reversal) < 0.0) course = -course;
    looks.push_back({reversal, std::min(course.head(reach).maxCoeff(), course.tail(reach).maxCoeff()), fit(course)});
  }
  // A halt begins where the pull falls to static friction: at the record's smaller accelerations. In those larger than
  // usual other forces bend the course more than the fit can follow; the smallest are what is left of rest.
  constexpr double tolerance = 0.1;
  const double usual = quantile(of_all(looks, [](const Look& look) { return look.beside; }), 0.5);
  std::erase_if(looks, [&](const Look& look) {
    return look.beside > (1.0 + tolerance) * usual || look.beside < tolerance * usual;
  });
  if (looks.empty()) return {};
  const ChanceGain chance = chance_gain(looks, std::sqrt(wave / 2.0));
  std::vector<Reversal> result;
  for (const Look& look : looks) {
    // Of what a halt that is none explains by noise; behind the low-pass two samples a wave are independent.
    const double std = std::max(chance.std, look.fit.rms * std::sqrt(wave / 2.0)),
                 most = look.beside * std::sqrt(wave);  // of a halt of a wave between such accelerations
    result.push_back({.at = look.at,
                      .halt_s = look.fit.halt_samples / rate_hz,
                      .log_ratio = log_ratio_of_halt(look.fit.gain - chance.usual, std, most)});
  }
  return result;
}

}  // namespace dsp
