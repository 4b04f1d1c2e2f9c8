#include "ident/ranges/ranges.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "dsp/values/fault.hpp"

namespace ident {
namespace {

using Eigen::Index;

dsp::Fault range_fault(const dsp::RangeSpec& spec, std::string name, const std::string& what,
                       dsp::FaultKind kind = dsp::FaultKind::usage) {
  const std::string place = spec.place.empty() ? "" : spec.place + ": ";
  return {kind, std::move(name), fmt::format("{}range '{}': {}.", place, spec.name, what)};
}

/// The samples of one recording between two times of the range, those that may be used at all, and those `where` keeps.
struct Samples {
  std::vector<Index> usable, kept;
};

Samples samples_of(const Range& range, const Columns& columns, const std::vector<unsigned char>& where) {
  const dsp::RangeSpec& spec = range.spec;
  const dsp::Motion& signals = *columns.signals;
  Samples result;
  const Index length = signals.num_samples();
  for (Index i = signals.edge_samples; i < length - signals.edge_samples; ++i) {
    const double t = static_cast<double>(i) / signals.sample_rate_hz;
    const auto index = static_cast<std::size_t>(i);
    if (t < spec.from_s || t >= spec.to_s || (!signals.excluded.empty() && signals.excluded[index] != 0)) continue;
    if (!columns.regimes.empty() && !range.regime.holds(columns.regimes[index])) continue;
    result.usable.push_back(i);
    if (where.empty() || where[index] != 0) result.kept.push_back(i);
  }
  return result;
}

/// The condition of a range; what goes wrong with it in `use` gets its place put before it.
template <class Use>
auto with_condition(const dsp::RangeSpec& spec, const dsp::Motion& signals, Use&& use) {
  std::vector<std::string> names;
  for (const dsp::Signal& signal : signals.signals) names.push_back(signal.name);
  try {
    return use(Expression(spec.where, names));
  } catch (const dsp::Fault& fault) {
    throw dsp::Fault(fault.kind(), fault.name(), fmt::format("{}: where: {}", spec.place, fault.what()));
  }
}

std::vector<unsigned char> condition_rows(const dsp::RangeSpec& spec, const dsp::Motion& signals) {
  if (spec.where.empty()) return {};
  return with_condition(spec, signals, [&](const Expression& condition) { return rows_where(condition, signals); });
}

/// First sample that is tested: train_to, or the first after the training fraction of the rows.
Index split_sample(const Range& range, const dsp::Motion& signals, const std::vector<Index>& kept) {
  const dsp::RangeSpec& spec = range.spec;
  if (spec.train_to_s) return static_cast<Index>(std::ceil(*spec.train_to_s * signals.sample_rate_hz - 1e-9));
  const auto num_train =
      static_cast<std::size_t>(std::llround(range.train_fraction * static_cast<double>(kept.size())));
  return num_train < kept.size() ? kept[num_train] : signals.num_samples();
}

void add_intervals(const std::vector<Index>& samples, Index from, Index to, double rate_hz,
                   std::vector<dsp::Interval>& into) {
  Index previous = -2;
  for (const Index i : samples) {
    if (i < from || i >= to) continue;
    if (i != previous + 1) into.push_back({static_cast<double>(i) / rate_hz, 0.0, {}});
    into.back().to_s = static_cast<double>(i + 1) / rate_hz;
    previous = i;
  }
}

}  // namespace

std::vector<std::pair<std::size_t, std::size_t>> overlaps(const std::vector<Range>& ranges, std::size_t most) {
  std::vector<std::size_t> by_begin(ranges.size());
  std::iota(by_begin.begin(), by_begin.end(), std::size_t{0});
  std::stable_sort(by_begin.begin(), by_begin.end(),
                   [&](std::size_t a, std::size_t b) { return ranges[a].spec.from_s < ranges[b].spec.from_s; });
  using Kind = std::tuple<int, std::string, std::string>;  // recording, where, regimes
  std::map<Kind, std::vector<std::size_t>> begun;
  std::vector<dsp::RegimeSet> sets;
  for (const std::string& name : dsp::regime_set_names()) sets.push_back(dsp::regime_set_from_string(name));
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (const std::size_t next : by_begin) {
    const Range& range = ranges[next];
    for (const dsp::RegimeSet& regime : sets) {
      if (!regime.meets(range.regime)) continue;
      auto& others = begun[{range.recording, range.spec.where, regime.name()}];
      std::erase_if(others, [&](std::size_t other) { return ranges[other].spec.to_s <= range.spec.from_s; });
      for (const std::size_t other : others) pairs.emplace_back(std::max(next, other), std::min(next, other));
    }
    if (pairs.size() >= most) break;
    begun[{range.recording, range.spec.where, range.regime.name()}].push_back(next);
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.resize(std::min(pairs.size(), most));
  return pairs;
}

std::vector<Range> split_by_direction(const std::vector<Range>& ranges) {
  std::vector<Range> halves;
  for (const Range& range : ranges)
    for (const auto& [sign, condition] : {std::pair{"+", "v > 0"}, std::pair{"-", "v < 0"}}) {
      Range half = range;
      half.spec.name += sign;
      half.spec.where = range.spec.where.empty() ? condition : fmt::format("({}) && {}", range.spec.where, condition);
      halves.push_back(std::move(half));
    }
  return halves;
}

void require_condition(const Range& range, const dsp::Motion& signals) {
  if (!range.spec.where.empty()) with_condition(range.spec, signals, [](const Expression&) {});
}

RangeRows range_rows(const Range& range, const std::vector<Columns>& recordings) {
  const dsp::RangeSpec& spec = range.spec;
  RangeRows result;
  result.usable.resize(recordings.size());
  double longest_s = 0.0;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    if (!range.covers(r)) continue;
    const dsp::Motion& signals = *recordings[r].signals;
    longest_s = std::max(longest_s, static_cast<double>(signals.num_samples()) / signals.sample_rate_hz);
    const Samples samples = samples_of(range, recordings[r], condition_rows(spec, signals));
    const Index split = split_sample(range, signals, samples.kept);
    for (const Index i : samples.kept) (i < split ? result.train : result.test).push_back({r, i});
    add_intervals(samples.usable, 0, split, signals.sample_rate_hz, result.train_s);
    add_intervals(samples.usable, split, signals.num_samples(), signals.sample_rate_hz, result.test_s);
    result.usable[r] = samples.usable;
  }
  if (spec.from_s >= longest_s || (std::isfinite(spec.to_s) && spec.to_s > longest_s * (1.0 + 1e-9) + 1e-9))
    throw range_fault(spec, "range.outside",
                      fmt::format("got {:g} to {:g} s, want it inside the recording, 0 to {:.9g} s", spec.from_s,
                                  spec.to_s, longest_s));
  if (result.train.empty())  // of a range that nobody asked for: the record itself gives no more
    throw range_fault(
        spec, "range.empty",
        spec.place.empty()
            ? "no training row is left; the check regime.left_out says what takes the time and what to try"
            : "no training row is left. Widen it, lower what `where` asks, or move train_to",
        spec.place.empty() ? dsp::FaultKind::input : dsp::FaultKind::usage);
  return result;
}

Eigen::Index end_of_stretch(const std::vector<Row>& rows, Eigen::Index first, Eigen::Index end) {
  const auto row = [&](Eigen::Index i) -> const Row& { return rows[static_cast<std::size_t>(i)]; };
  const auto goes_on_to = [&](Eigen::Index i) {
    return row(i).recording == row(first).recording && row(i).sample == row(first).sample + i - first;
  };
  if (goes_on_to(end - 1)) return end;  // samples of a recording ascend: nothing is missing between
  Eigen::Index next = first + 1;
  while (goes_on_to(next)) ++next;
  return next;
}

dsp::Motion some_samples(const std::vector<Row>& rows, std::size_t recording, const std::vector<Columns>& recordings,
                         std::size_t most) {
  const std::size_t step = rows.size() / most + 1;
  std::vector<Eigen::Index> samples;
  for (std::size_t i = 0; i < rows.size(); i += step)
    if (rows[i].recording == recording) samples.push_back(rows[i].sample);
  dsp::Motion motion{.sample_rate_hz = recordings[recording].signals->sample_rate_hz};
  for (const dsp::Signal& signal : recordings[recording].signals->signals)
    motion.signals.push_back({signal.name, signal.unit, signal.values(samples)});
  return motion;
}

}  // namespace ident
