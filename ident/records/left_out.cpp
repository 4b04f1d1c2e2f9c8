#include "ident/records/left_out.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>

#include "ident/equation/percent.hpp"

namespace ident {
namespace {

using Eigen::Index;

constexpr const char* ends = "ends of the record, within the filters' reach";

/// Why a sample at the regression rate is not used; nullptr: it is.
std::vector<const char*> reasons(const Record& record) {
  const dsp::Motion& signals = record.prepared.signals;
  const Index count = signals.num_samples();
  std::vector<const char*> why(static_cast<std::size_t>(count), nullptr);
  const auto fill = [&](Index first, Index last, const char* reason) {
    for (Index i = std::max<Index>(0, first); i < std::min(count, last); ++i)
      if (why[static_cast<std::size_t>(i)] == nullptr) why[static_cast<std::size_t>(i)] = reason;
  };
  for (const dsp::Interval& interval : record.prepared.excluded)
    fill(static_cast<Index>(std::ceil(interval.from_s * signals.sample_rate_hz)),
         static_cast<Index>(std::floor(interval.to_s * signals.sample_rate_hz)) + 1, interval.why.c_str());
  fill(0, signals.edge_samples, ends);
  fill(count - signals.edge_samples, count, ends);
  for (std::size_t i = 0; i < record.regimes.size(); ++i)
    if (why[i] == nullptr && record.regimes[i] == dsp::Regime::stick) why[i] = "stops";
  return why;
}

/// Reasons and how many samples each takes, the most first.
using Losses = std::vector<std::pair<std::string, double>>;

void add_loss(Losses& losses, const char* reason, double samples) {
  auto at = std::find_if(losses.begin(), losses.end(), [&](const auto& one) { return one.first == reason; });
  if (at == losses.end()) at = losses.insert(losses.end(), {reason, 0.0});
  at->second += samples;
}

void sort_losses(Losses& losses) {
  std::stable_sort(losses.begin(), losses.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
}

/// Of the whole record, as fractions of it.
Losses fractions(const Record& record) {
  Losses found;
  const auto why = reasons(record);
  for (const char* reason : why)
    if (reason != nullptr) add_loss(found, reason, 1.0);
  for (auto& [reason, samples] : found) samples /= static_cast<double>(why.size());
  sort_losses(found);
  return found;
}

/// Samples of a record that a range was given, those of them that are left, and what takes the others.
struct TimeOfRange {
  double given = 0.0, left = 0.0;
  Losses lost;
};

TimeOfRange time_of(const Range& range, const Record& record) {
  TimeOfRange time;
  const auto why = reasons(record);
  for (std::size_t i = 0; i < why.size(); ++i) {
    const double t = static_cast<double>(i) / record.prepared.signals.sample_rate_hz;
    if (t < range.spec.from_s || t >= range.spec.to_s) continue;
    // A range by time takes stops in; of another branch's samples nobody expects that they are in a range of this.
    const bool stops = i < record.regimes.size() && record.regimes[i] == dsp::Regime::stick;
    if (why[i] == nullptr && !range.regime.any() && i < record.regimes.size() && !range.regime.holds(record.regimes[i]))
      continue;
    time.given += 1.0;
    if (why[i] == nullptr || (stops && range.regime.any()))
      time.left += 1.0;
    else
      add_loss(time.lost, why[i], 1.0);
  }
  sort_losses(time.lost);
  return time;
}

std::string remedy(const std::string& reason, const Record& record) {
  if (reason == "stops" && !record.segmentation.mount) return "If it moves there, label it low or high in segment.file";
  if (reason == "stops") {
    const auto& signals = record.prepared.signals.signals;
    const bool driven = std::any_of(signals.begin(), signals.end(), acts_from_outside);
    return fmt::format(
        "{}, set segment.stick_speed_m_per_s below {:.2g} m/s",
        driven ? "If it moves there" : "Where a motion only fades into its noise nothing is lost; if it moves on there",
        record.segmentation.options.stick_speed_m_per_s);
  }
  const dsp::PrepareOptions& options = record.prepared.options;
  if (reason == ends && record.prepared.integrated())
    return fmt::format(
        "x is integrated above {:.3g} Hz, which reaches so far: of a longer record it takes a smaller "
        "part, with a displacement sensor none",
        options.integrate_from_hz);
  if (reason == ends) {
    constexpr double highest = 0.4;  // of the rate
    const double cutoff_hz = std::min(2.0 * options.cutoff_hz, highest * record.prepared.intermediate.sample_rate_hz);
    return cutoff_hz > options.cutoff_hz
               ? fmt::format("They reach less far with prepare.cutoff_hz = {:.3g} and rate_hz left out", cutoff_hz)
               : "Of a longer record they take a smaller part";
  }
  if (reason.starts_with("no values in ") || reason == "gap in the clock")
    return fmt::format(
        "Gaps up to {:.3g} s, a quarter of the shortest period in the band, are bridged and kept; a "
        "lower prepare.cutoff_hz keeps longer ones",
        0.25 / options.cutoff_hz);
  if (reason.ends_with(": held") || reason.ends_with(": dropout") || reason.ends_with(": clipped"))
    return "Its sensor did not show the motion there: mend it and record again, or leave the channel out where the "
           "motion is known without it";
  return "If it is good data, change what excludes it: [[bad]] in the sidecar, or segment.file";
}

}  // namespace

dsp::Check left_out(const Record& record) {
  constexpr double most = 0.25;
  dsp::Check check{.name = "regime.left_out", .status = dsp::CheckStatus::note, .limit = most};
  const auto found = fractions(record);
  std::vector<std::string> parts;
  for (const auto& [reason, fraction] : found) {
    check.value += fraction;
    const bool stops = reason == "stops";
    parts.push_back(fmt::format("{} {}{}", percent(fraction), reason,
                                stops && record.prepared.x_is_difference
                                    ? " (at rest against the base: the friction that holds it is of v, sgn(v))"
                                    : ""));
  }
  if (parts.empty())
    check.message = "no sample is left out";
  else
    check.message = fmt::format("{} of the record is left out: {}", percent(check.value), fmt::join(parts, ", "));
  if (check.value > most) {
    check.status = dsp::CheckStatus::warning;
    check.message += ". " + remedy(found.front().first, record);
  }
  return check;
}

std::vector<RangeCheck> scarce_ranges(const std::vector<Range>& ranges, const std::vector<const Record*>& records) {
  constexpr double least = 0.1;
  std::vector<RangeCheck> checks;
  for (const Range& range : ranges) {
    TimeOfRange whole;
    std::size_t worst = 0;
    double most_lost = 0.0;
    std::string reason;
    for (std::size_t r = 0; r < records.size(); ++r) {
      if (!range.covers(r)) continue;
      const TimeOfRange own = time_of(range, *records[r]);
      whole.given += own.given;
      whole.left += own.left;
      if (own.lost.empty() || own.lost.front().second <= most_lost) continue;
      worst = r;
      std::tie(reason, most_lost) = own.lost.front();
    }
    if (whole.given == 0.0 || whole.left >= least * whole.given) continue;
    checks.push_back(
        {worst,
         {.name = "range.scarce",
          .status = dsp::CheckStatus::warning,
          .value = whole.left / whole.given,
          .limit = least,
          .message = fmt::format("range {}: {} of its time is left. Most is lost to {}. {}", range.spec.name,
                                 percent(whole.left / whole.given), reason, remedy(reason, *records[worst]))}});
  }
  return checks;
}

}  // namespace ident
