#include "ident/records/clipped_training.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "dsp/values/fault.hpp"

namespace ident {
namespace {

struct Clipped {
  double seconds = 0.0, first_s = 0.0;
};

std::map<std::string, Clipped> clipped_within(const std::vector<dsp::Interval>& clipped, double from_s, double to_s) {
  std::map<std::string, Clipped> by_channel;
  for (const dsp::Interval& interval : clipped) {
    const double begin = std::max(interval.from_s, from_s), end = std::min(interval.to_s, to_s);
    if (begin >= end) continue;
    Clipped& channel = by_channel[interval.why];
    if (channel.seconds == 0.0) channel.first_s = begin;
    channel.seconds += end - begin;
  }
  return by_channel;
}

}  // namespace

void require_unclipped(const Range& range, const std::vector<const Record*>& records, double max_fraction) {
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (!range.covers(i)) continue;
    const dsp::Prepared& prepared = records[i]->prepared;
    const double end_s = static_cast<double>(prepared.signals.num_samples()) / prepared.signals.sample_rate_hz;
    const double from_s = range.spec.from_s, to_s = std::min(range.spec.to_s, end_s);
    const double train_to_s = range.spec.train_to_s.value_or(from_s + range.train_fraction * (to_s - from_s));
    for (const auto& [channel, clipped] : clipped_within(prepared.clipped, from_s, train_to_s)) {
      const double fraction = clipped.seconds / (train_to_s - from_s);
      if (fraction > max_fraction)
        throw dsp::Fault(
            dsp::FaultKind::input, "sample.clipped",
            fmt::format("{}: range '{}': {} is clipped for {:.3g} s of the {:.6g} s to train on, first at {:.6g} s: "
                        "{:.2g} %, at most {:.2g} % are allowed. Train elsewhere, leave the channel out, or raise "
                        "prepare.max_clipped.",
                        prepared.name, range.spec.name, channel, clipped.seconds, train_to_s - from_s, clipped.first_s,
                        100.0 * fraction, 100.0 * max_fraction));
    }
  }
}

}  // namespace ident
