#include "dsp/reversals.hpp"

#include <algorithm>
#include <cmath>

#include "dsp/order_statistics.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double brief_depth = 0.6;
constexpr double deep = 0.5;                  // a dip that only a halt makes
constexpr double normal_deviations = 1.4826;  // in a median absolute deviation

std::vector<Index> sign_changes(const VectorXd& v) {
  std::vector<Index> found;
  for (Index i = 1; i < v.size(); ++i)
    if ((v(i) >= 0.0) != (v(i - 1) >= 0.0)) found.push_back(i);
  return found;
}

// Robust deviation of a's means, from how far three in a row about reversals are from a straight line.
template <class Mean>
double noise_of(const std::vector<Index>& places, Index length, const Mean& mean) {
  std::vector<double> bends;
  for (const Index i : places)
    for (Index k = i - 4 * length; k <= i + 4 * length; k += length)
      bends.push_back(std::abs(mean(k - length) - 2.0 * mean(k) + mean(k + length)));
  return normal_deviations * quantile(std::move(bends), 0.5) / std::sqrt(6.0);
}

}  // namespace

std::vector<Reversal> reversals(const VectorXd& v, const VectorXd& a, Index samples_per_period) {
  const Index beside = samples_per_period / 8, half = std::max<Index>(1, samples_per_period / 120),
              length = 2 * half + 1, about = std::max<Index>(2, samples_per_period / 40),
              apart = samples_per_period / 6, from_end = std::max(samples_per_period / 4, 6 * length);
  const auto mean_over = [&](Index i, Index reach) { return a.segment(i - reach, 2 * reach + 1).mean(); };
  const auto mean = [&](Index i) { return mean_over(i, half); };
  std::vector<Index> places = sign_changes(v);
  std::erase_if(places, [&](Index i) { return i < from_end || i + from_end >= v.size(); });
  struct Turn {
    Index at;
    double least, longer, beside;  // accelerations towards the new sign; longer: the least over three times as long
  };
  std::vector<Turn> turns;
  std::vector<double> levels;
  for (std::size_t p = 0; p < places.size(); ++p) {
    const Index i = places[p];
    if (p > 0 && i - places[p - 1] < apart) continue;
    if (p + 1 < places.size() && places[p + 1] - i < apart) continue;
    const double sign = v(i) >= 0.0 ? 1.0 : -1.0;
    double before = 0.0, after = 0.0, least = INFINITY;
    Index dip = i;
    for (Index k = 0; k <= beside; ++k) {
      const double earlier = sign * mean(i - k), later = sign * mean(i + k);
      before = std::max(before, earlier);
      after = std::max(after, later);
      if (k > about) continue;
      if (earlier < least) least = earlier, dip = i - k;
      if (later < least) least = later, dip = i + k;
    }
    levels.push_back(std::min(before, after));
    turns.push_back({i, least, sign * mean_over(dip, 3 * half + 1), levels.back()});
  }
  const double clear = std::max(4.0 * noise_of(places, length, mean), 0.05 * quantile(levels, 0.95));
  std::erase_if(turns, [&](const Turn& turn) { return turn.beside <= clear; });
  std::vector<double> shares, longer_shares;
  for (const Turn& turn : turns) {
    shares.push_back(turn.least / turn.beside);
    longer_shares.push_back(turn.longer / turn.beside);
  }
  const double usual = quantile(shares, 0.5), usual_longer = quantile(longer_shares, 0.5);
  std::vector<Reversal> result;
  for (std::size_t k = 0; k < turns.size(); ++k)
    result.push_back({turns[k].at, shares[k], usual_longer - longer_shares[k] < brief_depth * (usual - shares[k])});
  return result;
}

double halting_share(const std::vector<Reversal>& reversals) {
  constexpr double most = 0.8, deviations = 9.0;
  std::vector<double> shares;
  for (const Reversal& reversal : reversals)
    if (reversal.acceleration_share > deep) shares.push_back(reversal.acceleration_share);
  const double centre = quantile(shares, 0.5);
  for (double& share : shares) share = std::abs(share - centre);
  return std::clamp(centre - deviations * normal_deviations * quantile(std::move(shares), 0.5), 0.0, most);
}

bool is_halt(const Reversal& reversal, double halting_share) {
  return reversal.acceleration_share < halting_share && (reversal.brief || reversal.acceleration_share < deep);
}

}  // namespace dsp
