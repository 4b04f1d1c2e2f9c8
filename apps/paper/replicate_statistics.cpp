#include "apps/paper/replicate_statistics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "dsp/order_statistics.hpp"

namespace apps {
namespace {

using Eigen::Index;

std::string error_text(const CaseReplication& replication, double noise) {
  int covered = 0, total = 0;
  double largest = 0.0;
  std::map<std::pair<std::string, Index>, std::vector<double>> errors;  // in standard deviations expected of the noise
  for (const CaseFit& fit : replication.fits) {
    const Section4Row& row = replication.row_of(fit);
    if (fit.method != "fast_rvm" || !row.truth_known || !fit.error.exact()) continue;
    const Eigen::VectorXd expected =
        unit_stds(replication.study.regressions[fit.regression], fit.fit.relevant) * noise * row.std;
    for (std::size_t i = 0; i < fit.fit.relevant.size(); ++i) {
      const auto j = static_cast<Index>(i);
      const double error = std::abs(fit.fit.mean(j) - row.truth(fit.fit.relevant[i]));
      const double num_stds = error / std::sqrt(fit.fit.interval_covariance()(j, j));
      covered += num_stds <= 1.959964;
      ++total;
      largest = std::max(largest, num_stds);
      errors[{row.label(), fit.fit.relevant[i]}].push_back(error / expected(j));
    }
  }
  if (total == 0) return {};
  double least = HUGE_VAL, most = 0.0;
  for (const auto& [term, values] : errors) {
    least = std::min(least, dsp::median(values));
    most = std::max(most, dsp::median(values));
  }
  return fmt::format(
      "95 % intervals hold {} of {} coefficients; largest error {:.2f} standard deviations\n"
      "median errors of {} coefficients: {:.2f} to {:.2f} of the standard deviation the noise allows (0.67 expected)\n",
      covered, total, largest, errors.size(), least, most);
}

std::string band_text(const CaseReplication& replication) {
  ident::BandFractions sum;
  for (const HeldOutBands& band : replication.bands) {
    sum.within_50 += band.fractions.within_50;
    sum.within_90 += band.fractions.within_90;
    sum.within_95 += band.fractions.within_95;
  }
  const double fraction = 100.0 / static_cast<double>(replication.bands.size());
  return fmt::format(
      "bands at held-out ratios, {} records: {:.1f}, {:.1f} and {:.1f} % inside the 50, 90 and 95 % bands\n",
      replication.bands.size(), fraction * sum.within_50, fraction * sum.within_90, fraction * sum.within_95);
}

}  // namespace

std::string statistics_text(const CaseReplication& replication, double noise) {
  std::string text;
  if (noise > 0.0) text += error_text(replication, noise);
  if (!replication.bands.empty()) text += band_text(replication);
  double solve = 0.0;
  std::set<std::uint64_t> seeds;
  for (const CaseFit& fit : replication.fits)
    if (fit.method == "fast_rvm") solve += fit.seconds, seeds.insert(fit.seed);
  return text + fmt::format("F-RVM of all rows from R: {:.2f} ms; all columns and targets to R: {:.2f} ms\n",
                            1e3 * solve / static_cast<double>(seeds.size()), 1e3 * replication.accumulate_seconds);
}

}  // namespace apps
