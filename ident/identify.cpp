#include "ident/identify.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "dsp/values/for_each_index.hpp"
#include "dsp/values/memory_limit.hpp"
#include "ident/equation/interval_95.hpp"
#include "ident/evidence/settle_columns.hpp"
#include "ident/judgement/judge.hpp"
#include "ident/judgement/judged_fit.hpp"
#include "ident/records/terms_by_record.hpp"
#include "ident/regression/methods.hpp"
#include "ident/validate/exchanged_roles.hpp"

namespace ident {
namespace {

using Clock = std::chrono::steady_clock;
using Eigen::Index;

/// What the config left open, where one recording settles it: the end, and where testing begins.
void fill_in(dsp::RangeSpec& spec, const RangeRows& rows, int recording, const std::vector<Columns>& recordings) {
  if (recording == 0 && recordings.size() > 1) return;
  const dsp::Motion& signals = *recordings[recording == 0 ? 0 : static_cast<std::size_t>(recording) - 1].signals;
  spec.to_s = std::min(spec.to_s, static_cast<double>(signals.num_samples()) / signals.sample_rate_hz);
  if (!spec.train_to_s)
    spec.train_to_s =
        rows.test.empty() ? spec.to_s : static_cast<double>(rows.test.front().sample) / signals.sample_rate_hz;
}

/// Rows that count as fewer than they are: the same coefficients, wider intervals.
RFactor thinned(RFactor data, double fraction) {
  data.R *= std::sqrt(fraction);
  data.num_samples = std::lround(fraction * static_cast<double>(data.num_samples));
  return data;
}

/// Of rows as evidence, what the colour that is left beside the sensors makes of them in the intervals of the first fit
/// that weighs them.
double uncounted_fraction(const RangeResult& result, const EvidenceData& evidence) {
  const auto weighed = std::find_if(result.fits.begin(), result.fits.end(),
                                    [](const JudgedFit& fit) { return !fit.sensors.empty() && fit.fit.selection; });
  if (weighed == result.fits.end()) return 1.0;
  return std::min(1.0, weighed->independent_fraction / evidence.size.fraction());
}

bool input_recorded(const Range& range, const std::vector<Columns>& recordings) {
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const auto& signals = recordings[r].signals->signals;
    if (range.covers(r) && std::any_of(signals.begin(), signals.end(), acts_from_outside)) return true;
  }
  return false;
}

/// On the candidates that are linear.
Model linear_model(const RangeData& range, const CandidateLibrary& library, const IdentifyOptions& options) {
  std::vector<Index> positions;
  for (std::size_t i = 0; i < range.terms.size(); ++i) {
    const Term& term = library.terms[static_cast<std::size_t>(range.terms[i])];
    const std::vector<std::string>& signals = term.expression.signals();
    if (term.name == "1" || (signals.size() == 1 && signals.front() == term.name))
      positions.push_back(static_cast<Index>(i));
  }
  Fit fit = fit_ols(range.data, positions);
  renumber(fit, range.terms, std::ssize(library.terms));
  return make_model(library, fit, options.target, options.target_unit, range.scale, {});
}

/// The columns of the recordings that a range covers, with switches to be placed for it alone.
std::vector<Columns> columns_for(const Range& range, const std::vector<Columns>& recordings) {
  std::vector<Columns> own;
  for (std::size_t r = 0; r < recordings.size(); ++r)
    own.push_back(range.covers(r) ? with_own_switches(recordings[r])
                                  : Columns{.name = recordings[r].name, .signals = recordings[r].signals});
  return own;
}

/// The zero of x where a fit has it further off than what is known of it allows by noise alone; null: nowhere.
const SensorEstimate* far_zero(const RangeResult& result) {
  if (result.fits.empty()) return nullptr;
  const std::vector<SensorEstimate>& sensors = result.fits.front().sensors;
  const auto far = std::find_if(sensors.begin(), sensors.end(), [](const SensorEstimate& one) {
    return one.name.ends_with("zero of x") && std::abs(one.mean) > interval_95 * one.prior_std;
  });
  return far == sensors.end() ? nullptr : &*far;
}

/// Of the free run of the first method, or of its predicted target where neither result has one.
std::pair<double, double> held_out_errors(const RangeResult& a, const RangeResult& b) {
  const JudgedFit &one = a.fits.front(), &other = b.fits.front();
  const auto error = [](const JudgedFit& fit) {
    const double run = fit.free_run.larger_nmse();
    return std::isfinite(run) ? run : std::numeric_limits<double>::infinity();
  };
  const std::pair<double, double> of_runs{error(one), error(other)};
  return std::isfinite(std::min(of_runs.first, of_runs.second))
             ? of_runs
             : std::pair{one.test_centred.value, other.test_centred.value};
}

/// A zero of x that is far off does what a term of even degree does, or what such a term would do is taken for it: the
/// reading that comes closer to the rows which were not fitted is kept, and the other one is named.
RangeResult with_better_zero(const Range& range, const std::vector<Columns>& recordings,
                             const CandidateLibrary& library, const IdentifyOptions& options) {
  std::vector<Columns> own = columns_for(range, recordings);
  RangeResult found = identify(range, own, library, options);
  const SensorEstimate* const zero = far_zero(found);
  if (zero == nullptr) return found;
  own = columns_for(range, recordings);
  for (Columns& columns : own)
    std::erase_if(columns.sensors, [](const SensorParameter& one) { return one.coordinate == Coordinate::zero_of_x; });
  RangeResult as_taken = identify(range, own, library, options);
  const auto [error, error_as_taken] = held_out_errors(found, as_taken);
  const bool moves = !(error_as_taken < error);
  const auto on_test_rows = [](double nmse) {
    return std::isfinite(nmse) ? fmt::format("has an NMSE of {:.2g}", nmse) : std::string("runs away");
  };
  const std::string remark = fmt::format(
      "two readings: x = 0 is {:.3g} {} from where it was taken to be, {:.2g} standard deviations of what is known of "
      "it, or it is there and {}. On what was not fitted the first {}, the second {}: the {} was kept",
      -zero->mean, zero->unit, std::abs(zero->mean) / zero->prior_std, to_text(as_taken.fits.front().model),
      on_test_rows(error), on_test_rows(error_as_taken), moves ? "first" : "second");
  RangeResult& kept = moves ? found : as_taken;
  for (JudgedFit& fit : kept.fits) fit.fit.remarks.push_back(remark);
  return std::move(kept);
}

/// What the largest of the ranges takes while it is at work.
double bytes_at_work(const std::vector<Range>& ranges, const std::vector<Columns>& recordings) {
  constexpr double columns_at_work = 8.0;  // at the intermediate rate: speeds, kinks, columns on their way (measured)
  double largest = 0.0;
  for (const Range& range : ranges) {
    double bytes = 0.0;
    for (std::size_t r = 0; r < recordings.size(); ++r) {
      if (!range.covers(r)) continue;
      const Columns& own = recordings[r];
      bytes += sizeof(double) * static_cast<double>(own.phi.size());
      if (own.prepared != nullptr)
        bytes += sizeof(double) * columns_at_work * static_cast<double>(own.prepared->intermediate.num_samples());
    }
    largest = std::max(largest, bytes);
  }
  return largest;
}

}  // namespace

RangeResult identify(const Range& range, std::vector<Columns>& recordings, const CandidateLibrary& library,
                     const IdentifyOptions& options) {
  RangeResult result;
  result.spec = range.spec;
  result.recording = range.recording;
  result.regime = range.regime;
  result.rows = range_rows(range, recordings);
  fill_in(result.spec, result.rows, range.recording, recordings);
  if (!input_recorded(range, recordings)) result.crests = crests_of(result.rows, recordings);
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    if (!range.covers(r)) continue;
    result.dropped.insert(result.dropped.end(), recordings[r].dropped.begin(), recordings[r].dropped.end());
    for (const std::string& channel : recordings[r].signals->uncalibrated)
      result.uncalibrated.push_back(recordings[r].name + ": " + channel);
    if (recordings[r].power)
      result.power_balance = std::fmax(
          result.power_balance, largest_balance(*recordings[r].power, range.regime, &dsp::RegimePower::corrected));
  }
  const auto start = Clock::now();
  const RangeData data = iterate_columns(range, result, recordings, library, options);
  result.accumulate_s = std::chrono::duration<double>(Clock::now() - start).count();
  result.target.resize(data.train.size() + data.test.size());
  result.target << data.train, data.test;
  for (const Term& term : library.terms) result.terms.push_back(term.name);
  for (const Term& term : data.library.terms) result.labels.push_back(term.label());
  result.orbit = closed_orbit(result.rows.train, recordings, data.terms);
  if (options.target == "a") result.along_motion = share_along_motion(result.rows.train, recordings);
  if (options.target == "a" && !result.orbit) result.exchanged = exchanged_roles(result.rows.train, recordings);
  result.linear = linear_model(data, data.library, options);
  for (const MethodOptions& method : options.methods) {
    if (options.poll) options.poll();
    result.fits.push_back(judged_fit(method, result, data, recordings, data.library, options));
  }
  columns_of_library(recordings);
  result.factors = data.factors;
  result.factors.evidence = thinned(data.factors.evidence, uncounted_fraction(result, data.evidence));
  if (options.most_blocks > 0)
    result.factors.blocks =
        factor_blocks(result.rows.train, recordings, result.factors.terms, options.most_blocks, options.poll);
  return result;
}

std::vector<RangeResult> identify(const std::vector<Range>& ranges, const std::vector<Columns>& recordings,
                                  const CandidateLibrary& library, const IdentifyOptions& options) {
  constexpr double most_beside = 32e6;  // of half an hour at 25.6 kHz a second range would take a third more memory
  const int at_work = dsp::threads_within_memory(bytes_at_work(ranges, recordings), options.num_threads, most_beside);
  const int together = std::max(1, std::min(static_cast<int>(std::ssize(ranges)), at_work));
  std::vector<RangeResult> results(ranges.size());
  std::vector<std::size_t> order(ranges.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto duration_s = [&](std::size_t i) { return ranges[i].spec.to_s - ranges[i].spec.from_s; };
  if (together > 1)  // the longest first: no thread is left with it in the end
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return duration_s(a) > duration_s(b); });
  const auto begin = [&](std::size_t i) {
    if (options.before_range) options.before_range(ranges[i]);
  };
  const auto end = [&](std::size_t i) {
    if (options.after_range) options.after_range(results[i]);
  };
  dsp::for_each_index(ranges.size(), together, [&](std::size_t k) {
    const std::size_t i = order[k];
    if (together == 1) begin(i);
    IdentifyOptions of_one = options;  // threads that find no further range help the last ones
    of_one.num_threads = options.num_threads / std::min(together, static_cast<int>(ranges.size() - k));
    results[i] = with_better_zero(ranges[i], recordings, library, of_one);
    if (together == 1) end(i);
  });
  for (std::size_t i = 0; i < ranges.size() && together > 1; ++i) begin(i), end(i);
  judge(results);
  return results;
}

std::vector<RangeResult> identify(Record record, const LibraryOptions& library, IdentifyOptions options) {
  const std::vector<Range> ranges = default_ranges({&record});
  if (record.prepared.x_is_difference)
    dsp::set_displacement_zero(record.prepared, mean_of_first_range(record, ranges, 1));
  const CandidateLibrary compiled = record_library(library, options.target, record.prepared);
  options.target_unit = record.prepared.signals.find(options.target)->unit;
  std::vector<Columns> columns;
  columns.push_back(
      record_columns(compiled, options.target, record, dsp::StreamOptions{}.max_memory_bytes, options.poll));
  return identify(ranges, columns, compiled, options);
}

}  // namespace ident
