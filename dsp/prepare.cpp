#include "dsp/prepare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace dsp {
namespace {
using Eigen::Index;

[[noreturn]] void refuse(const char* name, const std::string& message) {
  throw Fault(FaultKind::usage, name, "prepare: " + message);
}

bool same_rate(double a, double b) {
  return std::abs(a - b) <= 1e-9 * a;
}

SpectralBand state_band(const PrepareOptions& o) {
  return {o.state_rolloff_hz, o.state_cutoff_hz};
}
SpectralBand column_band(const PrepareOptions& o) {
  return {o.rolloff_hz, o.cutoff_hz};
}

// Every signal through the column filter; t is a clock, not a signal.
Motion filtered(const Motion& bus, const ColumnFilter& filter) {
  Motion out{.sample_rate_hz = filter.output_rate_hz()};
  for (const auto& signal : bus.signals)
    out.signals.push_back({signal.name, signal.unit, signal.name == "t" ? signal.values : filter.apply(signal.values)});
  const Index n = out.signals.back().values.size();
  out.signals.front().values = Eigen::VectorXd::LinSpaced(n, 0.0, static_cast<double>(n - 1)) / out.sample_rate_hz;
  out.excluded.assign(static_cast<std::size_t>(n), 0);
  out.dropped_power_fraction = bus.dropped_power_fraction;
  out.edge_samples = std::min(n / 2, static_cast<Index>(std::ceil(filter.edge_s() * out.sample_rate_hz)));
  return out;
}

// The recording through the column filter, channel by channel, for recipe "paper".
Recording filtered(const Recording& bus, const ColumnFilter& filter) {
  Recording out{.name = bus.name, .sample_rate_hz = filter.output_rate_hz(), .channels = bus.channels, .bad = bus.bad};
  for (Index c = 0; c < bus.samples.cols(); ++c) {
    const Eigen::VectorXd column = filter.apply(bus.samples.col(c));
    if (c == 0) out.samples.resize(column.size(), bus.samples.cols());
    out.samples.col(c) = column;
  }
  return out;
}

void exclude(Prepared& prepared, const std::vector<Interval>& bad, double duration_s) {
  const double margin_s =
      prepared.filter.edge_s() + 1.0 / (prepared.options.state_cutoff_hz - prepared.options.state_rolloff_hz);
  for (const auto& interval : bad)
    prepared.excluded.push_back(
        {std::max(0.0, interval.from_s - margin_s), std::min(duration_s, interval.to_s + margin_s), interval.why});
  for (const auto& interval : prepared.excluded) {
    mark(prepared.bus, interval);
    mark(prepared.signals, interval);
  }
}

Check edge_check(const Motion& signals) {
  const double seconds = static_cast<double>(signals.edge_samples) / signals.sample_rate_hz;
  return {.name = "prepare.edges",
          .status = CheckStatus::note,
          .value = seconds,
          .message = fmt::format("{} samples ({:.3g} s) at either end lean on samples predicted beyond the record",
                                 signals.edge_samples, seconds)};
}
}  // namespace

PrepareOptions resolved(const PrepareOptions& options, double sample_rate_hz) {
  PrepareOptions o = options;
  if (o.rate_hz == 0.0) o.rate_hz = sample_rate_hz;
  if (!(o.rate_hz > 0.0) || (o.rate_hz > sample_rate_hz && !same_rate(o.rate_hz, sample_rate_hz)))
    refuse("prepare.rate",
           fmt::format("rate_hz must be in (0, {}], the record's own rate; got {}", sample_rate_hz, o.rate_hz));
  if (o.bus_rate_hz == 0.0) o.bus_rate_hz = sample_rate_hz;
  if (o.cutoff_hz == 0.0) o.cutoff_hz = 0.4 * o.rate_hz;
  if (!(o.cutoff_hz > 0.0) || !(o.cutoff_hz < o.rate_hz / 2.0))
    refuse("prepare.cutoff",
           fmt::format("cutoff_hz must be in (0, {}), half of rate_hz; got {}", o.rate_hz / 2.0, o.cutoff_hz));
  if (o.rolloff_hz == 0.0) o.rolloff_hz = 0.78125 * o.cutoff_hz;
  if (!(o.rolloff_hz > 0.0) || !(o.rolloff_hz < o.cutoff_hz))
    refuse("prepare.rolloff",
           fmt::format("rolloff_hz must be in (0, {}), below cutoff_hz; got {}", o.cutoff_hz, o.rolloff_hz));
  if (o.state_cutoff_hz == 0.0)
    o.state_cutoff_hz = std::max(o.cutoff_hz, std::min(20.0 / 10.24 * o.cutoff_hz, 0.49 * o.bus_rate_hz));
  if (!(o.state_cutoff_hz >= o.cutoff_hz) || !(o.state_cutoff_hz <= o.bus_rate_hz / 2.0))
    refuse("prepare.state_cutoff",
           fmt::format("state_cutoff_hz must be in [{}, {}], from cutoff_hz to half of the bus rate; got {}",
                       o.cutoff_hz, o.bus_rate_hz / 2.0, o.state_cutoff_hz));
  if (o.state_rolloff_hz == 0.0) o.state_rolloff_hz = 0.64 * o.state_cutoff_hz;
  if (!(o.state_rolloff_hz > 0.0) || !(o.state_rolloff_hz < o.state_cutoff_hz))
    refuse("prepare.state_rolloff", fmt::format("state_rolloff_hz must be in (0, {}), below state_cutoff_hz; got {}",
                                                o.state_cutoff_hz, o.state_rolloff_hz));
  return o;
}

Prepared prepare(const Recording& recording, const PrepareOptions& options) {
  Prepared prepared{
      .name = recording.name, .options = resolved(options, recording.sample_rate_hz), .checks = recording.checks};
  const auto& o = prepared.options;
  if (recording.samples.rows() < 8)
    throw Fault(FaultKind::input, "sample.too_few",
                fmt::format("{}: {} samples, at least 8 are needed", recording.name, recording.samples.rows()));
  if (!same_rate(o.rate_hz, recording.sample_rate_hz))
    refuse("prepare.rate",
           fmt::format("rate_hz must be the record's own, {}; got {}", recording.sample_rate_hz, o.rate_hz));
  prepared.filter = ColumnFilter::taper(recording.sample_rate_hz, column_band(o));
  prepared.bus = relative_motion(recording, {.band = state_band(o), .acceleration = o.acceleration});
  prepared.signals = o.recipe == Recipe::matched
                         ? filtered(prepared.bus, prepared.filter)
                         : relative_motion(filtered(recording, prepared.filter),
                                           {.band = column_band(o), .acceleration = o.acceleration});
  exclude(prepared, recording.bad, recording.duration_s());
  prepared.checks.push_back(edge_check(prepared.signals));
  return prepared;
}

void set_displacement_zero(Prepared& prepared, double zero_m) {
  const auto x_of = [](Motion& motion) -> Eigen::VectorXd& {
    return std::find_if(motion.signals.begin(), motion.signals.end(), [](const Signal& s) { return s.name == "x"; })
        ->values;
  };
  Eigen::VectorXd& x = x_of(prepared.bus);
  x.array() -= zero_m;
  if (prepared.options.recipe == Recipe::matched)
    x_of(prepared.signals) = prepared.filter.apply(x);
  else
    x_of(prepared.signals).array() -= zero_m;
}

}  // namespace dsp
