#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dsp/filter/filter_design.hpp"
#include "dsp/prepare/prepare_filters.hpp"

namespace dsp {
namespace {

void require(bool fits, const char* name, const std::string& message) {
  if (!fits) throw Fault(FaultKind::usage, name, "prepare: " + message);
}

// A multiple of the regression rate that divides the recording's, as near 10 times the former as there is one.
double intermediate_rate(double rate_hz, double sample_rate_hz) {
  const double ratio = sample_rate_hz / rate_hz;
  if (ratio < 10.0) return sample_rate_hz;
  double best = 0.0;
  for (int k = 5; k <= 20; ++k) {
    const double rest = ratio / k;
    if (std::abs(rest - std::round(rest)) > 1e-9 * rest) continue;
    if (best == 0.0 || std::abs(std::log(k / 10.0)) < std::abs(std::log(best / 10.0))) best = k;
  }
  if (best > 0.0) return sample_rate_hz / std::round(ratio / best);  // exactly the record's own where it is that one
  return ratio <= 20.0 ? sample_rate_hz : 10.0 * rate_hz;
}

// Everything chosen, each frequency in its place.
PrepareOptions completed(const PrepareOptions& options, double sample_rate_hz) {
  PrepareOptions o = options;
  const bool own_rate = o.rate_hz == 0.0 || std::abs(o.rate_hz - sample_rate_hz) <= 1e-9 * sample_rate_hz;
  if (own_rate) o.rate_hz = o.intermediate_rate_hz = sample_rate_hz;
  require(o.rate_hz > 0.0 && o.rate_hz <= sample_rate_hz, "prepare.rate",
          fmt::format("rate_hz must be in (0, {}], the record's own rate; got {}", sample_rate_hz, o.rate_hz));
  if (o.intermediate_rate_hz == 0.0) o.intermediate_rate_hz = intermediate_rate(o.rate_hz, sample_rate_hz);
  require(o.intermediate_rate_hz >= o.rate_hz && o.intermediate_rate_hz <= sample_rate_hz, "prepare.bus_rate",
          fmt::format("bus_rate_hz must be in [{}, {}], between rate_hz and the record's own rate; got {}", o.rate_hz,
                      sample_rate_hz, o.intermediate_rate_hz));
  if (o.cutoff_hz == 0.0) o.cutoff_hz = 0.4 * o.rate_hz;
  require(o.cutoff_hz > 0.0 && o.cutoff_hz < o.rate_hz / 2.0, "prepare.cutoff",
          fmt::format("cutoff_hz must be in (0, {}), below half of rate_hz; got {}", o.rate_hz / 2.0, o.cutoff_hz));
  if (o.rolloff_hz == 0.0) o.rolloff_hz = 0.78125 * o.cutoff_hz;
  require(o.rolloff_hz > 0.0 && o.rolloff_hz < o.cutoff_hz, "prepare.rolloff",
          fmt::format("rolloff_hz must be in (0, {}), below cutoff_hz; got {}", o.cutoff_hz, o.rolloff_hz));
  // Between the recording and the intermediate rate the decimator needs room for its transition.
  const double widest_hz = (o.intermediate_rate_hz < sample_rate_hz ? 0.4 : 0.49) * o.intermediate_rate_hz;
  // Without an intermediate rate there is nothing to gain from a narrow state band: the column filter takes the noise,
  // and a switch keeps its time the better the wider the band it is formed in.
  if (o.state_cutoff_hz == 0.0 && own_rate) {
    o.state_cutoff_hz = std::max(o.cutoff_hz, widest_hz);
    if (o.state_rolloff_hz == 0.0) o.state_rolloff_hz = 0.75 * o.state_cutoff_hz;
  }
  if (o.state_cutoff_hz == 0.0)
    o.state_cutoff_hz = std::max(o.cutoff_hz, std::min(20.0 / 10.24 * o.cutoff_hz, widest_hz));
  require(o.state_cutoff_hz >= o.cutoff_hz && o.state_cutoff_hz < o.intermediate_rate_hz / 2.0, "prepare.state_cutoff",
          fmt::format("state_cutoff_hz must be in [{}, {}), from cutoff_hz to half of the intermediate rate; got {}",
                      o.cutoff_hz, o.intermediate_rate_hz / 2.0, o.state_cutoff_hz));
  if (o.state_rolloff_hz == 0.0) o.state_rolloff_hz = 0.64 * o.state_cutoff_hz;
  require(o.state_rolloff_hz > 0.0 && o.state_rolloff_hz < o.state_cutoff_hz, "prepare.state_rolloff",
          fmt::format("state_rolloff_hz must be in (0, {}), below state_cutoff_hz; got {}", o.state_cutoff_hz,
                      o.state_rolloff_hz));
  return o;
}

bool has_filters(const PrepareOptions& o, double sample_rate_hz) {
  const auto first = to_intermediate(o, sample_rate_hz), second = to_regression(o);
  return (!first || is_designable(sample_rate_hz, *first)) &&
         (!second || is_designable(o.intermediate_rate_hz, *second));
}

// The nearest of the fractions of small terms that has filters; 0: none nearby has.
double nearest_rate(const PrepareOptions& options, double sample_rate_hz) {
  constexpr int largest_up = 256;
  const double most_hz = options.intermediate_rate_hz > 0.0 ? options.intermediate_rate_hz : sample_rate_hz;
  std::vector<double> rates;
  for (int up = 1; up <= largest_up; ++up) {
    const double down = std::max<double>(up, std::round(sample_rate_hz * up / options.rate_hz));
    const double rate_hz = sample_rate_hz * up / down;
    if (2.0 * options.cutoff_hz < rate_hz && rate_hz <= most_hz) rates.push_back(rate_hz);
  }
  std::sort(rates.begin(), rates.end(),
            [&](double a, double b) { return std::abs(a - options.rate_hz) < std::abs(b - options.rate_hz); });
  for (const double rate_hz : rates) {
    PrepareOptions other = options;
    other.rate_hz = rate_hz;
    if (has_filters(completed(other, sample_rate_hz), sample_rate_hz)) return rate_hz;
  }
  return 0.0;
}

}  // namespace

std::optional<DecimateOptions> to_intermediate(const PrepareOptions& o, double sample_rate_hz) {
  if (o.intermediate_rate_hz >= sample_rate_hz) return std::nullopt;
  const double pass_hz = std::max(o.state_cutoff_hz, std::min(1.5 * o.state_cutoff_hz, 0.4 * o.intermediate_rate_hz));
  return DecimateOptions{.output_rate_hz = o.intermediate_rate_hz,
                         .passband_end_hz = pass_hz,
                         .stopband_start_hz = o.intermediate_rate_hz - pass_hz};
}

std::optional<DecimateOptions> to_regression(const PrepareOptions& o) {
  if (o.rate_hz >= o.intermediate_rate_hz) return std::nullopt;
  return DecimateOptions{
      .output_rate_hz = o.rate_hz,
      .passband_end_hz = o.cutoff_hz,
      .stopband_start_hz = 1.25 * o.cutoff_hz < o.rate_hz / 2.0 ? 1.25 * o.cutoff_hz : o.rate_hz / 2.0};
}

ColumnFilter column_filter(const PrepareOptions& o) {
  const auto decimation = to_regression(o);
  return decimation ? ColumnFilter::decimation(o.intermediate_rate_hz, *decimation)
                    : ColumnFilter::taper(o.intermediate_rate_hz, column_band(o));
}

SpectralBand column_band(const PrepareOptions& o) {
  return {o.rolloff_hz, o.cutoff_hz};
}

PrepareOptions resolved(const PrepareOptions& options, double sample_rate_hz) {
  const PrepareOptions o = completed(options, sample_rate_hz);
  if (has_filters(o, sample_rate_hz)) return o;
  const auto first = to_intermediate(o, sample_rate_hz);
  require(
      options.intermediate_rate_hz == 0.0 || !first || is_designable(sample_rate_hz, *first), "prepare.bus_rate",
      fmt::format("from {} Hz to bus_rate_hz {} there is no filter of a reasonable length; leave it out, or ask for "
                  "a whole part of the record's own rate",
                  sample_rate_hz, o.intermediate_rate_hz));
  const double nearest_hz = nearest_rate(options, sample_rate_hz);
  require(nearest_hz > 0.0, "prepare.cutoff",
          fmt::format("no filter of a reasonable length leaves {} Hz and removes what folds at a rate of {} Hz; ask "
                      "for a lower cutoff_hz or another rate_hz",
                      o.cutoff_hz, o.rate_hz));
  throw Fault(FaultKind::usage, "prepare.rate",
              fmt::format("prepare: from {} Hz to {} Hz there is no filter of a reasonable length, the ratio being no "
                          "fraction of small numbers; the nearest possible rate_hz is {}",
                          sample_rate_hz, o.rate_hz, nearest_hz));
}

const Channel* Prepared::channel(Role role) const& {
  const auto found = std::find_if(channels.begin(), channels.end(), [&](const Channel& c) { return c.role == role; });
  return found == channels.end() ? nullptr : &*found;
}

bool Prepared::integrated() const {
  return options.integrate_from_hz > 0.0 && !has_displacement({.channels = channels});
}

}  // namespace dsp
