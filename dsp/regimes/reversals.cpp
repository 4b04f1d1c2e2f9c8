#include "dsp/regimes/reversals.hpp"

#include <algorithm>
#include <cmath>

#include "dsp/filter/short_low_pass.hpp"
#include "dsp/order_statistics.hpp"
#include "dsp/regimes/halt_fit.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double least_waves_per_period = 12.0;  // else a half wave of the motion is too short for the fit
constexpr double worth_looking = 0.92;    // of the acceleration beside it: what a halt of a fiftieth of a wave leaves
constexpr double std_of_normal = 1.4826;  // in median absolute deviations

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

struct Plain {
  double noise = 0.0;          ///< rms of what the fit leaves
  double level = 0.0;          ///< accelerations up to which friction counts for most
  double gain = INFINITY;      ///< more than a halt that is none gains by chance
  double row_gain = INFINITY;  ///< and more than the median of a row of them
};

// A halt begins where the pull falls to static friction: at the record's smaller accelerations. In larger ones other
// forces bend the course more than the fit can follow.
Plain plain_reversals(const std::vector<ReversalCourse>& courses, const Look& look) {
  const double clear = 0.05 * level(courses, 0.95);  // less is what is left of rest
  std::vector<ReversalCourse> moving = courses;
  std::erase_if(moving, [clear](const ReversalCourse& reversal) { return reversal.beside <= clear; });
  Plain plain{.level = 1.1 * level(moving, 0.5)};
  std::vector<Index> indices;
  for (const ReversalCourse& reversal : moving)
    if (reversal.beside <= plain.level) indices.push_back(reversal.at);
  constexpr std::size_t fewest = 10, most = 256;
  if (indices.size() < fewest) return plain;
  std::vector<double> gains, rests;
  for (const Index index : drawn_evenly(indices, most)) {
    const HaltFit::Result fitted = look.fit(index);
    gains.push_back(fitted.gain);
    rests.push_back(fitted.rms);
  }
  const double usual = quantile(gains, 0.5), noise = quantile(std::move(rests), 0.5);
  for (double& gain : gains) gain = std::abs(gain - usual);
  constexpr double stds = 4.0, row_stds = 3.0;
  plain.noise = noise;
  const double gain_std = std::max(std_of_normal * quantile(std::move(gains), 0.5), look.gain_std(noise));
  plain.gain = usual + stds * gain_std;
  plain.row_gain = usual + row_stds * gain_std;
  return plain;
}

// What the fit says of one reversal; zero where it was not asked.
struct Fitted {
  double halt_s = 0.0, gain = 0.0;
  bool asked = false;
};

// Where halts that are not clear each for itself come in rows: the median gain of seven to eleven such reversals,
// within three periods to either side, is more than chance; and from there on as long as at least every other reversal
// gains clearly, five at most.
std::vector<bool> in_rows(const std::vector<Reversal>& all, const std::vector<Fitted>& fitted, const Plain& plain,
                          Index reach) {
  const std::ptrdiff_t n = std::ssize(all), beside = 5;
  const auto at = [](auto& items, std::ptrdiff_t i) -> auto& {
    return items[static_cast<std::size_t>(i)];
  };
  const auto gains = [&](std::ptrdiff_t i) { return i >= 0 && i < n && at(fitted, i).gain >= 2.0 * plain.noise; };
  std::vector<bool> row(all.size(), false);
  for (std::ptrdiff_t k = 0; k < n; ++k) {
    std::vector<double> about;
    for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(0, k - beside); i <= std::min(k + beside, n - 1); ++i)
      if (at(fitted, i).asked && at(fitted, i).gain < plain.gain &&
          2 * std::abs(at(all, i).at - at(all, k).at) <= 3 * reach)
        about.push_back(at(fitted, i).gain);
    if (about.size() < 7 || quantile(std::move(about), 0.5) < plain.row_gain) continue;
    for (const std::ptrdiff_t step : {-1, 1})
      for (std::ptrdiff_t i = k; std::abs(i - k) <= beside && (gains(i) || gains(i + step)); i += step)
        if (i >= 0 && i < n) row[static_cast<std::size_t>(i)] = true;
  }
  return row;
}

// Halts come in rows, or where a standstill begins or ends; chance does not. `reach`: two periods.
void believe(std::vector<Reversal>& all, const std::vector<Fitted>& fitted, const Plain& plain, Index reach) {
  const std::vector<bool> row = in_rows(all, fitted, plain, reach);
  const auto halts = [&](std::size_t k) { return all[k].halt_s > 0.0 || fitted[k].gain >= plain.gain || row[k]; };
  std::vector<std::size_t> believed;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (fitted[k].halt_s == 0.0) continue;
    bool is = fitted[k].gain >= 2.0 * plain.gain;
    if (!is && fitted[k].gain >= plain.gain) {
      for (std::size_t i = k; i > 0 && all[k].at - all[i - 1].at <= reach; --i) is |= halts(i - 1);
      for (std::size_t i = k + 1; i < all.size() && all[i].at - all[k].at <= reach; ++i) is |= halts(i);
    }
    is |= row[k] && fitted[k].gain >= 1.5 * plain.noise;
    if (is) believed.push_back(k);
  }
  for (const std::size_t k : believed) all[k].halt_s = fitted[k].halt_s;
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

double shortest_halt_s(double cutoff_hz) {
  return HaltFit::shortest_halt_waves / cutoff_hz;
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
  std::erase_if(
      seen, [clear = 0.01 * level(seen, 0.95)](const ReversalCourse& reversal) { return reversal.beside <= clear; });
  const Plain plain = plain_reversals(seen, look);
  std::erase_if(seen, [&](const ReversalCourse& reversal) { return reversal.beside <= 4.0 * plain.noise; });

  std::vector<Reversal> result;
  std::vector<Fitted> fitted;
  for (const ReversalCourse& reversal : seen) {
    result.push_back({.at = reversal.at});
    fitted.push_back({.asked = reversal.beside <= plain.level});
    if (!fitted.back().asked || reversal.least >= worth_looking * reversal.beside) continue;  // it gains zero
    const HaltFit::Result fit = look.fit(reversal.at);
    fitted.back().halt_s = fit.halt_samples / rate_hz, fitted.back().gain = fit.gain;
  }
  believe(result, fitted, plain, 2 * options.samples_per_period);
  return result;
}

}  // namespace dsp
