#include "ident/records/record.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <new>
#include <utility>

#include "dsp/regimes/regime.hpp"
#include "dsp/regimes/regime_signs.hpp"
#include "dsp/values/fault.hpp"
#include "dsp/values/for_each_index.hpp"
#include "dsp/values/memory_limit.hpp"
#include "dsp/values/signals.hpp"
#include "ident/records/left_out.hpp"
#include "ident/switches/held_by_ground.hpp"

namespace ident {
namespace {

bool has(const Record& record, dsp::Regime regime) {
  return std::find(record.regimes.begin(), record.regimes.end(), regime) != record.regimes.end();
}

std::vector<dsp::Regime> moving_regimes(const Record& record) {
  std::vector<dsp::Regime> found;
  for (const dsp::RegimeInfo& known : dsp::regime_table())
    if (known.moving && has(record, known.regime)) found.push_back(known.regime);
  return found;
}

/// Regimes of which a person would want an equation of their own. What moves for less than a tenth of the time is a
/// passage of the rest, and has too few rows for an equation.
std::vector<dsp::Regime> lasting(const std::vector<dsp::Regime>& moving, const Record& record) {
  constexpr double least_fraction = 0.1;
  if (!record.segmentation.mount) return moving;  // segments that a person gave
  const dsp::Motion& signals = record.prepared.signals;
  const auto edge = std::min(signals.edge_samples, signals.num_samples() / 2);
  const auto samples = [&](dsp::Regime regime) {
    return static_cast<double>(std::count(record.regimes.begin() + edge, record.regimes.end() - edge, regime));
  };
  double all = 0.0;
  for (const dsp::Regime regime : moving) all += samples(regime);
  std::vector<dsp::Regime> found;
  for (const dsp::Regime regime : moving)
    if (samples(regime) >= least_fraction * all) found.push_back(regime);
  return found;
}

/// No equation holds where friction holds the payload, and what is filtered holds some of that as far as the filter
/// reaches: rows closer to a stop, wherever it may end, are of the stop, too.
void widen_stops(Record& record) {
  constexpr double reach_periods = 3.0, stds = 4.0;  // of the cut-off
  const dsp::Prepared& prepared = record.prepared;
  const double rate_hz = prepared.signals.sample_rate_hz, stop_rate_hz = prepared.intermediate.sample_rate_hz,
               cutoff_hz = prepared.options.cutoff_hz;
  const auto reach_s = [&](double std_s) {
    return (cutoff_hz > 0.0 ? reach_periods / cutoff_hz : 0.0) + (std_s > 0.0 ? stds * std_s : 0.0);
  };
  const double last_row = static_cast<double>(record.regimes.size()) - 1.0;
  for (const dsp::Segment& stop : record.segmentation.segments) {
    if (stop.regime != dsp::Regime::stick) continue;
    const double from_s = static_cast<double>(stop.first) / stop_rate_hz - reach_s(stop.first_std_s),
                 to_s = static_cast<double>(stop.last) / stop_rate_hz + reach_s(stop.last_std_s);
    const auto first = static_cast<std::size_t>(std::max(0.0, std::ceil(from_s * rate_hz))),
               end = static_cast<std::size_t>(std::min(last_row, std::floor(to_s * rate_hz)) + 1.0);
    for (std::size_t i = first; i < end; ++i)
      if (record.regimes[i] != dsp::Regime::excluded) record.regimes[i] = dsp::Regime::stick;
  }
}

/// A warning where everything that moves lies within the filters' reach of something excluded, as free decays do.
void warn_if_nothing_moves(Record& record) {
  if (!has(record, dsp::Regime::stick) || !has(record, dsp::Regime::excluded) || !moving_regimes(record).empty())
    return;
  const auto& signals = record.prepared.signals;
  record.prepared.checks.push_back(
      {.name = "regime.no_motion",
       .status = dsp::CheckStatus::warning,
       .message = fmt::format("only rest is left: whatever moves lies within {:.2g} s, the filters' reach, of samples "
                              "that are excluded. A higher prepare.rate_hz and prepare.cutoff_hz reach less far",
                              static_cast<double>(signals.edge_samples) / signals.sample_rate_hz)});
}

/// The ranges of a record for which nobody named any.
std::vector<Range> ranges_of(const Record& record, int recording, bool alone) {
  const std::string name = alone ? "" : std::filesystem::path(record.prepared.name).replace_extension().string();
  const auto range = [&](const std::string& label, const dsp::RegimeSet& regime) {
    Range result{{}, recording, regime};
    result.spec.name = alone ? label : regime.any() ? name : name + " " + label;
    return result;
  };
  const std::vector<dsp::Regime> moving = moving_regimes(record), own = lasting(moving, record);
  const bool sticks = has(record, dsp::Regime::stick);
  if (moving.empty() || (own.size() < 2 && !sticks)) return {range("all", {})};
  std::vector<Range> ranges;
  if (own.size() < moving.size()) return {range(dsp::RegimeSet::mixed().name(), dsp::RegimeSet::mixed())};
  for (const dsp::Regime regime : moving) ranges.push_back(range(std::string(to_string(regime)), regime));
  if (moving.size() > 1) ranges.push_back(range(dsp::RegimeSet::mixed().name(), dsp::RegimeSet::mixed()));
  return ranges;
}

/// Signals that drive the motion from outside in one of the records.
std::vector<std::string> inputs_of(const std::vector<const Record*>& records) {
  std::vector<std::string> inputs;
  for (const Record* record : records)
    for (const dsp::Signal& signal : record->prepared.signals.signals)
      if (acts_from_outside(signal) && std::find(inputs.begin(), inputs.end(), signal.name) == inputs.end())
        inputs.push_back(signal.name);
  return inputs;
}

/// Records without this signal.
std::vector<std::string> lacking(const std::vector<const Record*>& records, const std::string& signal) {
  std::vector<std::string> names;
  for (const Record* record : records)
    if (record->prepared.signals.find(signal) == nullptr) names.push_back(record->prepared.name);
  return names;
}

/// What a recording takes while it is fitted: signals at the intermediate rate and filtered, the column of every term,
/// once as they are formed and once more for the range that is fitted, which moves switches in its own; and some sixty
/// for regimes, noise, residuals, what else may explain them and free runs (measured: 80 + 1.96 a term for eight
/// signals and three methods); speeds with their kinks, the signs of switches and a column on its way are four.
double fit_bytes(const dsp::Motion& signals, std::size_t num_terms) {
  const double columns = 2.0 * static_cast<double>(signals.signals.size() + num_terms) + 64.0;
  return sizeof(double) * columns * static_cast<double>(signals.num_samples());
}

/// The payload's signals as its body moves, where the mount of its sensors rings.
void undo_mount(Record& record) {
  dsp::Prepared& prepared = record.prepared;
  if (!prepared.equalised()) return;
  const dsp::Motion& intermediate = prepared.intermediate;
  const auto& known = record.segmentation.mount;
  record.mount = known ? *known : dsp::regime_signs(intermediate).mount;
  if (record.mount.is_rigid()) return;
  for (dsp::Motion* motion : {&prepared.intermediate, &prepared.signals})
    dsp::undo_mount(*motion, record.mount, mount_band(prepared));
  const dsp::Mount& mount = record.mount;
  prepared.checks.push_back(
      {.name = "sensors.mount",
       .status = dsp::CheckStatus::note,
       .value = mount.frequency_hz,
       .message = fmt::format("the mount of the payload's sensors rings at {:.4g} +- {:.2g} Hz, damping {:.3g} +- "
                              "{:.1g}; the payload's signals are corrected for it",
                              mount.frequency_hz, mount.frequency_std_hz, mount.damping, mount.damping_std)});
}

/// Sensitivity of the base's correction to the mount's frequency and damping, where both bodies move as one.
void note_how_mount_acts(Record& record, const dsp::Segmentation& inside, const dsp::CommonMotion& found,
                         double weight_of_lead) {
  const dsp::Motion& motion = record.prepared.intermediate;
  const dsp::Mount& mount = record.mount;
  for (const auto parameter : {dsp::MountParameter::frequency, dsp::MountParameter::damping}) {
    const double step = parameter == dsp::MountParameter::frequency ? mount.frequency_std_hz : mount.damping_std;
    dsp::Motion other = motion;
    for (dsp::Signal& signal : other.signals)
      if (signal.name == "y")
        signal.values += step * dsp::mount_sensitivity(signal.values, motion.sample_rate_hz, mount, parameter,
                                                       mount_band(record.prepared));
    const auto then = dsp::find_common_motion(other, inside);
    if (!then) continue;
    record.base_by_mount[static_cast<std::size_t>(parameter)] = {(then->gain - found.gain) / (found.gain * step),
                                                                 weight_of_lead * (then->lead_s - found.lead_s) / step};
  }
}

/// The base's signals in the scale and on the clock of the payload's, from where both move as one.
void adopt_common_motion(Record& record) {
  dsp::Prepared& prepared = record.prepared;
  if (!prepared.equalised() || !prepared.x_is_difference) return;
  // Of what a file of segments would say: as far as the signals at the regression rate go.
  const double edge_s = static_cast<double>(prepared.signals.edge_samples) / prepared.signals.sample_rate_hz;
  const auto edge = static_cast<Eigen::Index>(std::lround(edge_s * prepared.intermediate.sample_rate_hz));
  dsp::Segmentation inside = record.segmentation;
  for (dsp::Segment& segment : inside.segments) {
    segment.first = std::max(segment.first, edge);
    segment.last = std::max(segment.first, std::min(segment.last, prepared.intermediate.num_samples() - edge));
  }
  std::optional<dsp::CommonMotion> found = dsp::find_common_motion(prepared.intermediate, inside);
  if (!found || !(std::abs(found->gain - 1.0) <= dsp::largest_gain_error)) return;
  // Where both have an accelerometer beside them, it is known from those already that there is none, to the standard
  // deviations of both relations.
  const auto& relations = prepared.relations;
  double weight = 1.0;
  if (relations.size() == 2 && std::all_of(relations.begin(), relations.end(), dsp::can_be_corrected)) {
    const double related_s = std::hypot(relations[0].lag_std_s, relations[1].lag_std_s);
    weight = std::pow(related_s / std::hypot(related_s, found->lead_std_s), 2);
  }
  if (!record.mount.is_rigid()) note_how_mount_acts(record, inside, *found, weight);
  found->lead_s *= weight;
  found->lead_std_s *= std::sqrt(weight);
  for (dsp::Motion* motion : {&prepared.intermediate, &prepared.signals})
    dsp::adopt(*motion, found->gain, found->lead_s);
  prepared.checks.push_back(
      {.name = "sensors.common_motion",
       .status = dsp::CheckStatus::note,
       .value = found->gain,
       .message =
           fmt::format("for {:.3g} s base and payload move as one: y reads {:.6g} +- {:.1g} times what r reads, {:.3g} "
                       "+- {:.2g} us earlier; the base's signals are corrected for it",
                       found->duration_s, found->gain, found->gain_std, 1e6 * found->lead_s, 1e6 * found->lead_std_s)});
  record.common_motion = found;
}

}  // namespace

dsp::SpectralBand mount_band(const dsp::Prepared& prepared) {
  // Speeds reach up to the state band's end and are to agree with the displacements up to there.
  const double end_hz = prepared.options.state_cutoff_hz;
  return {end_hz, std::min(1.5 * end_hz, 0.5 * prepared.intermediate.sample_rate_hz)};
}

namespace {

/// `absolute`: the payload's absolute regimes, where they were found already.
void set_regimes(Record& record, dsp::Segmentation segmentation, std::optional<dsp::Segmentation> absolute) {
  record.segmentation = std::move(segmentation);
  undo_mount(record);
  const bool absolute_holds = absolute && record.mount.is_rigid();  // only a mount changes the payload's signals
  adopt_common_motion(record);
  record.regimes = dsp::regimes_at(record.segmentation, record.prepared.intermediate, record.prepared.signals);
  widen_stops(record);
  record.prepared.checks.push_back(left_out(record));
  warn_if_nothing_moves(record);
  if (!absolute_holds) absolute = absolute_regimes_in_place(record.prepared.intermediate);
  if (absolute)
    if (const auto check = held_by_ground(record.prepared, *absolute)) record.prepared.checks.push_back(*check);
  if (record.prepared.raw_v.size() == 0) return;
  record.power = dsp::power_check(record.prepared, record.regimes);
  record.prepared.checks.push_back(check_of(*record.power, record.prepared.relations));
}

}  // namespace

void set_regimes(Record& record, dsp::Segmentation segmentation) {
  set_regimes(record, std::move(segmentation), std::nullopt);
}

void find_regimes(Record& record, const dsp::SegmentOptions& options, int num_threads) {
  const dsp::Motion& motion = record.prepared.intermediate;
  dsp::Segmentation relative;
  std::optional<dsp::Segmentation> absolute;
  constexpr double columns_at_work = 12.0;  // of the payload's own motion: its signals, two spectra, densities
  const int at_work = dsp::threads_within_memory(
      sizeof(double) * columns_at_work * static_cast<double>(motion.num_samples()), std::min(num_threads, 2));
  dsp::for_each_index(static_cast<std::size_t>(at_work), at_work, [&](std::size_t i) {
    if (i == 0)
      relative = dsp::segment_regimes(motion, options);
    else
      absolute = absolute_regimes(motion);
  });
  set_regimes(record, std::move(relative), std::move(absolute));
}

Record find_regimes(dsp::Prepared prepared, const dsp::SegmentOptions& options) {
  Record record{.prepared = std::move(prepared)};
  find_regimes(record, options);
  return record;
}

std::vector<Range> default_ranges(const std::vector<const Record*>& records) {
  std::vector<Range> ranges;
  bool named = false, of_regimes = false;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const int recording = static_cast<int>(i) + 1;
    for (const dsp::RangeSpec& spec : records[i]->ranges) ranges.push_back({spec, recording, {}});
    named = named || !records[i]->ranges.empty();
    if (!records[i]->ranges.empty()) continue;
    for (Range& range : ranges_of(*records[i], recording, records.size() == 1)) {
      const bool taken = std::any_of(ranges.begin(), ranges.end(),
                                     [&](const Range& other) { return other.spec.name == range.spec.name; });
      if (taken) range.spec.name += fmt::format("-{}", recording);
      of_regimes = of_regimes || !range.regime.any();
      ranges.push_back(std::move(range));
    }
  }
  if (records.size() > 1 && !named) {
    ranges.push_back({{}, 0, of_regimes ? dsp::RegimeSet::mixed() : dsp::RegimeSet()});
    ranges.back().spec.name = "all recordings";
  }
  return ranges;
}

bool acts_from_outside(const dsp::Signal& signal) {
  const auto moves = [&] { return signal.values.size() > 0 && signal.values.maxCoeff() > signal.values.minCoeff(); };
  if (const dsp::SignalInfo* known = dsp::find_signal(signal.name)) return known->in_default_library && moves();
  constexpr std::array drives{"N", "N*m", "Pa", "V", "A"};
  return std::find(drives.begin(), drives.end(), signal.unit) != drives.end() && moves();
}

std::vector<std::string> default_terms(const std::vector<const Record*>& records) {
  std::vector<std::string> terms{"sgn(v)"};
  for (const std::string& input : inputs_of(records))
    if (lacking(records, input).empty()) terms.push_back(input);
  return terms;
}

std::vector<dsp::Check> inputs_of_some(const std::vector<const Record*>& records) {
  std::vector<dsp::Check> checks;
  for (const std::string& input : inputs_of(records)) {
    const std::vector<std::string> without = lacking(records, input);
    if (without.empty()) continue;
    checks.push_back(
        {.name = "input.not_everywhere",
         .channel = input,
         .status = dsp::CheckStatus::warning,
         .value = static_cast<double>(without.size()),
         .message = fmt::format("{} was not recorded in {}, so it can be in no equation of all recordings. "
                                "Leave those out, or identify each recording for itself",
                                input, fmt::join(without, ", "))});
  }
  return checks;
}

double mean_of_first_range(const Record& record, const std::vector<Range>& ranges, int recording) {
  const dsp::Prepared& prepared = record.prepared;
  const auto first = std::find_if(ranges.begin(), ranges.end(), [&](const Range& range) {
    return range.recording == 0 || range.recording == recording;
  });
  if (first == ranges.end()) return dsp::mean_displacement(prepared, 0.0, INFINITY);
  double from_s = first->spec.from_s, to_s = first->spec.to_s;
  for (const dsp::Segment& segment : record.segmentation.segments) {
    const double begin_s = static_cast<double>(segment.first) / prepared.intermediate.sample_rate_hz,
                 end_s = static_cast<double>(segment.last) / prepared.intermediate.sample_rate_hz;
    if (first->regime.any() || !first->regime.holds(segment.regime) || begin_s >= to_s || end_s <= from_s) continue;
    from_s = std::max(from_s, begin_s), to_s = std::min(to_s, end_s);
    break;
  }
  return dsp::mean_displacement(prepared, from_s, to_s);
}

Columns record_columns(const CandidateLibrary& library, const std::string& target, const Record& record,
                       std::size_t max_memory_bytes, const std::function<void()>& poll, int num_threads) {
  const dsp::Prepared& prepared = record.prepared;
  dsp::require_memory(prepared.name, fit_bytes(prepared.signals, library.terms.size()), max_memory_bytes);
  try {
    Columns columns = form_columns(library, target, prepared, poll, num_threads);
    columns.regimes = record.regimes;
    columns.power = record.power;
    columns.zero = record.zero;
    columns.sensors = sensor_parameters(record);
    return columns;
  } catch (const std::bad_alloc&) {
    throw dsp::Fault(
        dsp::FaultKind::numerics, "memory.exhausted",
        fmt::format("{}: no memory for {} columns, {:.1f} MB. Use fewer terms or a lower rate.", prepared.name,
                    library.terms.size(), 1e-6 * column_bytes(prepared.signals, library.terms.size())));
  }
}

}  // namespace ident
