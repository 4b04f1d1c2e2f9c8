#include "dsp/samples/fill_gaps.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "dsp/filter/burg.hpp"

namespace dsp {
namespace {

// In order; touching ones joined, empty ones left out.
std::vector<IndexRange> gaps_in_samples(const std::vector<Interval>& intervals, double sample_rate_hz,
                                        Eigen::Index size) {
  // The first sample not before a time; a thousandth of a sample is rounding.
  const auto index = [&](double time_s) {
    return static_cast<Eigen::Index>(
        std::clamp(std::ceil(time_s * sample_rate_hz - 1e-3), 0.0, static_cast<double>(size)));
  };
  std::vector<IndexRange> gaps, joined;
  for (const auto& interval : intervals) gaps.push_back({index(interval.from_s), index(interval.to_s)});
  std::sort(gaps.begin(), gaps.end(), [](const IndexRange& a, const IndexRange& b) { return a.first < b.first; });
  for (const auto& gap : gaps) {
    if (gap.last <= gap.first) continue;
    if (joined.empty() || gap.first > joined.back().last)
      joined.push_back(gap);
    else
      joined.back().last = std::max(joined.back().last, gap.last);
  }
  return joined;
}

// The `count` samples after x, predicted about its mean.
Eigen::VectorXd predicted(const Eigen::Ref<const Eigen::VectorXd>& x, Eigen::Index count, Eigen::Index order) {
  const double mean = x.mean();
  const Eigen::VectorXd centred = x.array() - mean;
  const auto possible = std::min(order, x.size() / 3);  // a longer predictor would be fitted to its own noise
  return predict_forward(centred, burg(centred, possible), count).array() + mean;
}

// Fills [first, last) from num_before and num_after samples.
void fill(Eigen::Ref<Eigen::VectorXd> samples, const IndexRange& gap, Eigen::Index num_before, Eigen::Index num_after,
          Eigen::Index order, bool line) {
  const auto count = gap.last - gap.first;
  const auto from = [&](const Eigen::Ref<const Eigen::VectorXd>& x) -> Eigen::VectorXd {
    return line ? Eigen::VectorXd::Constant(count, x(x.size() - 1)).eval() : predicted(x, count, order);
  };
  Eigen::VectorXd forward, backward;
  if (num_before > 0) forward = from(samples.segment(gap.first - num_before, num_before));
  if (num_after > 0) backward = from(samples.segment(gap.last, num_after).reverse()).reverse();
  if (num_before == 0) forward = backward;
  if (num_after == 0) backward = forward;
  for (Eigen::Index i = 0; i < count; ++i) {
    const double u = static_cast<double>(i + 1) / static_cast<double>(count + 1);
    const double fade = line ? u : u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
    samples(gap.first + i) = (1.0 - fade) * forward(i) + fade * backward(i);
  }
}

}  // namespace

void fill_gaps(Eigen::Ref<Eigen::VectorXd> samples, double sample_rate_hz, const std::vector<Interval>& gaps,
               const FillOptions& options) {
  const auto ranges = gaps_in_samples(gaps, sample_rate_hz, samples.size());
  const auto order =
      options.order > 0 ? options.order : std::clamp<Eigen::Index>(std::llround(sample_rate_hz), 64, 256);
  const auto fit = std::max<Eigen::Index>(1, std::llround(options.fit_s * sample_rate_hz));
  // First each from what was measured behind it and all before, which is filled by then; where little was measured
  // before the next gap, from before alone. Those are filled once more when the gaps behind them are.
  for (const bool again : {false, true})
    for (std::size_t g = 0; g < ranges.size(); ++g) {
      const auto& gap = ranges[g];
      const auto next = g + 1 < ranges.size() ? ranges[g + 1].first : samples.size();
      const bool line = static_cast<double>(gap.last - gap.first) > options.max_gap_s * sample_rate_hz;
      const bool crowded = !line && next < samples.size() && next - gap.last < fit;
      if (again && !crowded) continue;
      const auto num_before = std::min(fit, gap.first);
      auto num_after = std::min(fit, (again ? samples.size() : next) - gap.last);
      if (!again && crowded && 4 * num_after < num_before) num_after = 0;
      if (num_before + num_after == 0) throw std::invalid_argument("fill_gaps: the gap is all there is");
      fill(samples, gap, num_before, num_after, order, line);
    }
}

}  // namespace dsp
