#include "dsp/regimes/reversals.hpp"

#include <algorithm>
#include <cmath>

#include "dsp/filter/short_low_pass.hpp"
#include "dsp/order_statistics.hpp"
#include "dsp/regimes/halt_fit.hpp"
#include "dsp/regimes/halt_rows.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double least_waves_per_period = 12.0;  // else a half wave of the motion is too short for the fit
constexpr double worth_looking = 0.92;    // of the acceleration beside it: what a halt of a fiftieth of a wave leaves
constexpr double std_of_normal = 1.4826;  // in median absolute deviations
constexpr double at_rest = 0.05, middling = 1.1;  // of the largest accelerations, of their median

// Of a reversal: the acceleration about it, low-passed and towards the new sign.
struct ReversalCourse {
  Index at;
  double beside;  // smaller of the largest before and after
  double least;   // least value at it
};

class Look {
 public:
  Look(const VectorXd& v, const VectorXd& a, double sample_rate_hz, double cutoff_hz, Index beside)
      : v_(v),
        a_(a),
        low_pass_(cutoff_hz, sample_rate_hz),
        fit_(low_pass_, cutoff_hz / sample_rate_hz),
        wave_(sample_rate_hz / cutoff_hz),
        beside_(std::max({beside, fit_.before(), fit_.after()})) {}

  [[nodiscard]] Index from_end() const { return beside_ + low_pass_.reach() + 1; }

  [[nodiscard]] ReversalCourse at(Index reversal) const {
    const VectorXd course = about(reversal, beside_, beside_);
    const auto early = static_cast<Index>(std::lround(0.45 * wave_)), late = static_cast<Index>(std::lround(wave_));
    return {.at = reversal,
            .beside = std::min(course.head(beside_).maxCoeff(), course.tail(beside_).maxCoeff()),
            .least = course.segment(beside_ - early, early + late + 1).minCoeff()};
  }

  /// Of what a halt that is none explains by noise of this rms; behind the low-pass two samples a wave are independent.
  [[nodiscard]] double gain_std(double noise) const { return noise * std::sqrt(wave_ / 2.0); }
  /// Of a halt of a wave between such accelerations.
  [[nodiscard]] double most_gain(double beside) const { return beside * std::sqrt(wave_); }
  [[nodiscard]] HaltFit::Result fit(Index reversal) const { return fit_(about(reversal, fit_.before(), fit_.after())); }

 private:
  [[nodiscard]] VectorXd about(Index reversal, Index before, Index after) const {
    const VectorXd course = low_pass_(a_, reversal - before, before + after + 1);
    return v_(reversal) >= 0.0 ? course : -course;
  }

  const VectorXd &v_, &a_;
  ShortLowPass low_pass_;
  HaltFit fit_;
  double wave_;
  Index beside_;
};

double level(const std::vector<ReversalCourse>& courses, double fraction) {
  std::vector<double> levels;
  for (const ReversalCourse& reversal : courses) levels.push_back(reversal.beside);
  return quantile(std::move(levels), fraction);
}

/// What a halt that is none seems to gain at the record's reversals: the median, and by how much they differ.
struct ChanceGain {
  double usual = 0.0, std = INFINITY;
};

ChanceGain chance_gain(const std::vector<Index>& indices, const Look& look) {
  constexpr std::size_t fewest = 10, most = 256;
  if (indices.size() < fewest) return {};
  std::vector<double> gains, rests;
  for (const Index index : drawn_evenly(indices, most)) {
    const HaltFit::Result fitted = look.fit(index);
    gains.push_back(fitted.gain);
    rests.push_back(fitted.rms);
  }
  const double usual = quantile(gains, 0.5);
  for (double& gain : gains) gain = std::abs(gain - usual);
  return {usual,
          std::max(std_of_normal * quantile(std::move(gains), 0.5), look.gain_std(quantile(std::move(rests), 0.5)))};
}

}  // namespace

Index sign_change_margin(Index samples_per_period) {
  return samples_per_period / 4;
}

std::vector<Index> sign_changes(const VectorXd& v, Index samples_per_period) {
  const Index together = samples_per_period / 12, apart = samples_per_period / 6,
              from_end = sign_change_margin(samples_per_period);
  struct Group {
    Index first, last, count;
  };
  std::vector<Group> groups;
  for (Index i = 1; i < v.size(); ++i) {
    if ((v(i) >= 0.0) == (v(i - 1) >= 0.0)) continue;
    if (!groups.empty() && i - groups.back().last <= together)
      groups.back() = {groups.back().first, i, groups.back().count + 1};
    else
      groups.push_back({i, i, 1});
  }
  std::vector<Index> reversal_indices;
  for (std::size_t k = 0; k < groups.size(); ++k) {
    const Group& group = groups[k];
    const bool alone = (k == 0 || group.first - groups[k - 1].last >= apart) &&
                       (k + 1 == groups.size() || groups[k + 1].first - group.last >= apart);
    if (alone && group.count % 2 == 1 && group.first >= from_end && group.last + from_end < v.size())
      reversal_indices.push_back(group.first);
  }
  return reversal_indices;
}

std::vector<Reversal> reversals(const std::vector<Index>& reversal_indices, const VectorXd& v, const VectorXd& a,
                                const ReversalOptions& options) {
  const double rate_hz = options.sample_rate_hz, cutoff_hz = options.cutoff_hz;
  if (cutoff_hz * static_cast<double>(options.samples_per_period) < least_waves_per_period * rate_hz ||
      cutoff_hz >= 0.4 * rate_hz)
    return {};
  const Look look(v, a, rate_hz, cutoff_hz, options.samples_per_period / 8);
  std::vector<ReversalCourse> seen;
  for (const Index reversal : reversal_indices)
    if (reversal >= look.from_end() && reversal + look.from_end() < v.size()) seen.push_back(look.at(reversal));
  // A halt begins where the pull falls to static friction: at the record's smaller accelerations. In larger ones other
  // forces bend the course more than the fit can follow; the smallest are what is left of rest.
  std::erase_if(seen, [clear = at_rest * level(seen, 0.95)](const ReversalCourse& one) { return one.beside <= clear; });
  std::erase_if(seen, [large = middling * level(seen, 0.5)](const ReversalCourse& one) { return one.beside > large; });
  std::vector<Index> indices;
  for (const ReversalCourse& reversal : seen) indices.push_back(reversal.at);
  const ChanceGain chance = chance_gain(indices, look);
  if (!std::isfinite(chance.std)) return {};

  std::vector<Reversal> result;
  for (const ReversalCourse& reversal : seen) {
    HaltFit::Result fit;  // it gains zero where it does not dip
    if (reversal.least < worth_looking * reversal.beside) fit = look.fit(reversal.at);
    const double std = std::max(chance.std, look.gain_std(fit.rms));
    result.push_back({.at = reversal.at,
                      .halt_s = fit.halt_samples / rate_hz,
                      .log_ratio = log_ratio_of_halt(fit.gain - chance.usual, std, look.most_gain(reversal.beside))});
  }
  return result;
}

}  // namespace dsp
