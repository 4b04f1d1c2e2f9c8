#include "dsp/prepare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "dsp/filter/decimate.hpp"
#include "dsp/filter/filter_design.hpp"
#include "dsp/prepare/intermediate_recorder.hpp"
#include "dsp/prepare/motion_band.hpp"
#include "dsp/prepare/prepare_filters.hpp"
#include "dsp/prepare/recorded_derivatives.hpp"
#include "dsp/values/for_each_index.hpp"
#include "dsp/values/memory_limit.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

SpectralBand state_band(const PrepareOptions& o) {
  return {o.state_rolloff_hz, o.state_cutoff_hz};
}

MotionOptions motion_options(const PrepareOptions& o, const SpectralBand& band) {
  return {.band = band, .acceleration = o.acceleration, .integrate_from_hz = o.integrate_from_hz};
}

// Both filters as one, from the recording to the regression rate.
std::optional<FilterSheet> whole_sheet(const PrepareOptions& o, double sample_rate_hz, const ColumnFilter& filter,
                                       const std::optional<FilterSheet>& raw) {
  const auto last = to_regression(o);
  if (!last) return raw;
  if (!raw) return filter.sheet();
  std::vector<FilterStage> stages = raw->stages;
  stages.insert(stages.end(), filter.sheet().stages.begin(), filter.sheet().stages.end());
  return measure(std::move(stages), sample_rate_hz, *last);
}

VectorXd clock(Index n, double rate_hz) {
  return VectorXd::LinSpaced(n, 0.0, static_cast<double>(n - 1)) / rate_hz;
}

// Every signal through the filter; t is a clock, not a signal.
Motion filtered(const Motion& intermediate, const ColumnFilter& filter, int num_threads) {
  Motion out{.sample_rate_hz = filter.output_rate_hz()};
  for (const auto& signal : intermediate.signals) out.signals.push_back({signal.name, signal.unit, {}});
  for_each_index(out.signals.size(), num_threads, [&](std::size_t i) {
    if (out.signals[i].name != "t") out.signals[i].values = filter.apply(intermediate.signals[i].values);
  });
  const Index n = out.signals.back().values.size();
  out.signals.front().values = clock(n, out.sample_rate_hz);
  out.excluded.assign(static_cast<std::size_t>(n), 0);
  out.dropped_power_fraction = intermediate.dropped_power_fraction;
  out.uncalibrated = intermediate.uncalibrated;
  return out;
}

// The recording through the filter, channel by channel, for recipe "paper".
Recording filtered(const Recording& intermediate, const ColumnFilter& filter) {
  Recording out{
      .name = intermediate.name, .sample_rate_hz = filter.output_rate_hz(), .channels = intermediate.channels};
  for (Index c = 0; c < intermediate.samples.cols(); ++c) {
    const VectorXd column = filter.apply(intermediate.samples.col(c));
    if (c == 0) out.samples.resize(column.size(), intermediate.samples.cols());
    out.samples.col(c) = column;
  }
  return out;
}

// Velocity and acceleration as the sensors gave them, where both sorts of sensor are there.
void keep_raw(Prepared& prepared, const Recording& intermediate) {
  const Index y = intermediate.find(Role::y), r = intermediate.find(Role::r), ddy = intermediate.find(Role::ddy),
              ddr = intermediate.find(Role::ddr);
  if (y < 0 || ddy < 0 || (r < 0) != (ddr < 0)) return;
  VectorXd x = intermediate.samples.col(y), a = intermediate.samples.col(ddy);
  if (r >= 0) x -= intermediate.samples.col(r), a -= intermediate.samples.col(ddr);
  prepared.raw_v =
      ExtendedSpectrum(prepared.filter.apply(x), prepared.options.rate_hz).derivative(1, column_band(prepared.options));
  prepared.raw_a = prepared.filter.apply(a);
}

std::vector<unsigned char> mask(const std::vector<Interval>& bad, Index n, double rate_hz) {
  Motion marked{.sample_rate_hz = rate_hz};
  marked.excluded.assign(static_cast<std::size_t>(n), 0);
  for (const auto& interval : bad) mark(marked, interval);
  return marked.excluded;
}

void equalise(Prepared& prepared, const Recording& intermediate, ColumnSpectra& spectra,
              const std::vector<unsigned char>& excluded, int num_threads) {
  keep_raw(prepared, intermediate);
  Equalised equal = equalise_sensors(spectra, excluded, prepared.options.scale, num_threads);
  restore_low_frequencies(spectra, equal.highpass_hz, num_threads);
  spectra.store(num_threads);
  prepared.relations = std::move(equal.relations);
  if (equal.highpass_hz.empty()) return;
  prepared.filter = prepared.filter.with_highpass(equal.highpass_hz);
  prepared.highpass_hz = std::move(equal.highpass_hz);
}

void exclude(Prepared& prepared, const std::vector<Interval>& bad, double reach_s, double duration_s) {
  for (const auto& interval : bad) {
    const double from_s = std::max(0.0, interval.from_s - reach_s),
                 to_s = std::min(duration_s, interval.to_s + reach_s);
    auto& all = prepared.excluded;
    if (!all.empty() && all.back().why == interval.why && from_s <= all.back().to_s && from_s >= all.back().from_s)
      all.back().to_s = std::max(all.back().to_s, to_s);  // one crest after the other
    else
      all.push_back({from_s, to_s, interval.why});
  }
  if (!prepared.highpass_hz.empty())
    prepared.excluded.push_back(
        {0.0, std::min(duration_s, 2.0 / *std::min_element(prepared.highpass_hz.begin(), prepared.highpass_hz.end())),
         "start: the high-pass of the sensors' coupling has not settled"});
  std::stable_sort(prepared.excluded.begin(), prepared.excluded.end(),
                   [](const Interval& a, const Interval& b) { return a.from_s < b.from_s; });
  for (const auto& interval : prepared.excluded) {
    mark(prepared.intermediate, interval);
    mark(prepared.signals, interval);
  }
}

Check edge_check(const Motion& signals) {
  const double seconds = static_cast<double>(signals.edge_samples) / signals.sample_rate_hz;
  return {.name = "prepare.edges",
          .status = CheckStatus::note,
          .value = seconds,
          .message = fmt::format("{} samples ({:.3g} s) at either end depend on samples predicted beyond the record",
                                 signals.edge_samples, seconds)};
}

// A quarter of the shortest period in the band is bridged with an error far below the motion, which is in the noise.
std::optional<Check> keep_bridged(std::vector<Interval>& bad, double cutoff_hz) {
  const double longest_s = 0.25 / cutoff_hz;
  constexpr double rounding = 1e-9;
  const auto is_kept = [&](const Interval& gap) {
    return gap.is_bridged && gap.to_s - gap.from_s <= longest_s * (1.0 + rounding);
  };
  const auto kept = std::erase_if(bad, is_kept);
  if (kept == 0) return std::nullopt;
  return Check{.name = "prepare.bridged",
               .status = CheckStatus::note,
               .value = static_cast<double>(kept),
               .message = fmt::format("{} gaps are kept, bridged: they are no longer than {:.3g} s, a quarter of "
                                      "the shortest period in the band",
                                      kept, longest_s)};
}

/// A size that no vibration has, and the unit in which it would be usual.
struct Oversize {
  double value = 0.0, most = 0.0;
  std::string words;
  std::string_view unit;
};

double root_mean_square(const VectorXd& values) {
  return std::sqrt(values.squaredNorm() / static_cast<double>(std::max<Index>(values.size(), 1)));
}

std::optional<Oversize> oversize(const Prepared& prepared, const Channel& channel) {
  constexpr double most_m_per_s2 = 1000.0;  // rms: a hundred times gravity, which shocks reach for milliseconds only
  constexpr double most_m = 1.0;            // rms: of what swings so far the unit is no question
  constexpr double most_rad = 2.0 * std::numbers::pi;
  const SignalInfo& signal = info_of(channel.role);
  if (signal.order < 0) return std::nullopt;
  const Signal* moving = prepared.signals.find(motion_signal(signal.body, 0).name);
  const Signal* accelerating = prepared.signals.find(motion_signal(signal.body, 2).name);
  if (signal.order == 0 && channel.unit == "rad" && moving != nullptr) {
    const double most = moving->values.cwiseAbs().maxCoeff();
    if (most > most_rad) return Oversize{most, most_rad, fmt::format("it turns by up to {:.3g} rad", most), "deg"};
  }
  if (signal.order == 0 && channel.unit == "m" && moving != nullptr) {
    const double size = root_mean_square(moving->values.array() - moving->values.mean());
    if (size > most_m) return Oversize{size, most_m, fmt::format("it moves by {:.3g} m rms", size), "mm"};
  }
  if (!channel.unit_is_assumed || accelerating == nullptr || channel.unit.starts_with("rad")) return std::nullopt;
  const double size = root_mean_square(accelerating->values);
  if (size > most_m_per_s2)
    return Oversize{size, most_m_per_s2, fmt::format("it accelerates by {:.3g} m/s^2 rms", size),
                    signal.order == 0   ? "mm"
                    : signal.order == 1 ? "mm/s"
                                        : "mm/s^2"};
  return std::nullopt;
}

// Numbers that would be no vibration in their unit are a question.
std::optional<Check> size_question(const Prepared& prepared) {
  for (const Channel& channel : prepared.channels)
    if (const auto found = oversize(prepared, channel))
      return Check{.name = "sample.size",
                   .channel = channel.name,
                   .status = CheckStatus::warning,
                   .value = found->value,
                   .limit = found->most,
                   .message = fmt::format("in {}{}, {}. Is it in another unit, such as {}? Write unit = \"{}\" under "
                                          "its [[channel]] in the sidecar",
                                          channel.unit, channel.unit_is_assumed ? ", which was assumed" : "",
                                          found->words, found->unit, found->unit)};
  return std::nullopt;
}

// From the intermediate rate on: everything that does not depend on where its samples came from.
void finish(Prepared& prepared, Recording intermediate, const std::optional<FilterSheet>& raw, int most_threads) {
  constexpr double columns_at_work = 8.0;  // spectra of a pair, their products, the signals before and behind
  const int num_threads = threads_within_memory(
      sizeof(double) * columns_at_work * static_cast<double>(intermediate.samples.rows()), most_threads);
  const auto& o = prepared.options;
  const std::vector<Interval> bad = intermediate.bad;
  const double duration_s = intermediate.duration_s();
  const ColumnFilter low_pass = prepared.filter;
  {
    const auto excluded = mask(intermediate.bad, intermediate.samples.rows(), intermediate.sample_rate_hz);
    ColumnSpectra spectra(intermediate);
    prepared.derivatives = relate_derivatives(spectra, excluded);
    if (prepared.equalised())
      equalise(prepared, intermediate, spectra, excluded, num_threads);
    else
      prepared.relations = relate_pairs(spectra, excluded, num_threads);
  }
  intermediate.bad.clear();
  if (o.recipe == Recipe::paper)
    prepared.signals = relative_motion(filtered(intermediate, low_pass), motion_options(o, column_band(o)));
  prepared.intermediate = relative_motion(std::move(intermediate), motion_options(o, state_band(o)));
  if (o.recipe == Recipe::matched) prepared.signals = filtered(prepared.intermediate, low_pass, num_threads);
  // Of derivatives by their band; of integrals longer, by how slow they begin, but what a short record can spare.
  double motion_s = 1.0 / (o.state_cutoff_hz - o.state_rolloff_hz);
  if (prepared.integrated())
    motion_s =
        std::max(motion_s, std::min(integral_reach_periods / o.integrate_from_hz, most_lost_to_integral * duration_s));
  const double reach_s = (raw ? raw->edge_s : 0.0) + low_pass.edge_s() + motion_s;
  if (auto question = size_question(prepared)) prepared.checks.push_back(std::move(*question));
  prepared.signals.edge_samples =
      std::min(prepared.signals.num_samples() / 2, static_cast<Index>(std::ceil(reach_s * o.rate_hz)));
  exclude(prepared, bad, reach_s, duration_s);
  prepared.checks.push_back(edge_check(prepared.signals));
}

void settle_integration(Prepared& prepared, double drift_to_hz) {
  double& from_hz = prepared.options.integrate_from_hz;
  if (from_hz == 0.0) from_hz = drift_to_hz;
  if (!(from_hz > 0.0)) {
    const bool some = std::any_of(prepared.channels.begin(), prepared.channels.end(), [](const Channel& channel) {
      const Body body = info_of(channel.role).body;
      return body == Body::relative || body == Body::payload;
    });
    if (!some) return;  // relative_motion says what is missing
    throw Fault(FaultKind::input, "prepare.integrate_from",
                fmt::format("{}: not every displacement was recorded, and no motion faster than a few cycles of the "
                            "record was found to integrate. Set prepare.integrate_from_hz, or record the displacement",
                            prepared.name));
  }
  if (from_hz >= 0.5 * prepared.options.rolloff_hz)
    throw Fault(
        FaultKind::usage, "prepare.integrate_from",
        fmt::format("{}: there is no displacement, and integration from {:.3g} Hz leaves nothing of a band that "
                    "ends at {:.3g} Hz. Set prepare.cutoff_hz = {:.3g} and leave rate_hz out",
                    prepared.name, from_hz, prepared.options.cutoff_hz, 4.0 * from_hz));
  prepared.checks.push_back(
      {.name = "prepare.integrated",
       .status = CheckStatus::note,
       .value = from_hz,
       .message = fmt::format("not every displacement was recorded: x is integrated above {:.3g} Hz. Slower motion and "
                              "the zero of x are not known, so even powers of x cannot be trusted",
                              from_hz)});
}

/// The channels that record x or a derivative of it, or the others; null where there are none.
std::shared_ptr<const Recording> of_relative_motion(const Recording& all, const std::vector<Interval>& bad,
                                                    bool others) {
  const auto has = [&](Body body) {
    return std::any_of(all.channels.begin(), all.channels.end(),
                       [&](const Channel& channel) { return info_of(channel.role).body == body; });
  };
  const Body body = has(Body::relative) ? Body::relative : has(Body::base) ? Body::none : Body::payload;
  auto found = std::make_shared<Recording>();
  std::vector<Index> columns;
  for (Index j = 0; j < std::ssize(all.channels); ++j) {
    const Channel& channel = all.channels[static_cast<std::size_t>(j)];
    const bool records_x = info_of(channel.role).order >= 0 && info_of(channel.role).body == body;
    if (records_x == others) continue;
    columns.push_back(j);
    found->channels.push_back(channel);
  }
  if (columns.empty()) return nullptr;
  found->name = all.name, found->sample_rate_hz = all.sample_rate_hz, found->bad = bad;
  found->samples = all.samples(Eigen::all, columns);
  return found;
}

VectorXd& displacement_of(Motion& motion) {
  return std::find_if(motion.signals.begin(), motion.signals.end(), [](const Signal& s) { return s.name == "x"; })
      ->values;
}

}  // namespace

Prepared prepare(IntermediateRecording intermediate, const PrepareOptions& options, int num_threads) {
  const double rate_hz = intermediate.input_rate_hz;
  Prepared prepared{.name = intermediate.recording.name, .options = resolved(options, rate_hz)};
  if (to_intermediate(prepared.options, rate_hz) != intermediate.filter)
    throw std::invalid_argument("prepare: the recording was filled for other options");
  prepared.filter = column_filter(prepared.options);
  prepared.decimation = whole_sheet(prepared.options, rate_hz, prepared.filter, intermediate.sheet);
  const Recording& known = intermediate.recording;
  prepared.channels = known.channels;
  prepared.x_is_difference = known.find(Role::x) < 0 && known.find(Role::y) >= 0 && known.find(Role::r) >= 0;
  prepared.clipped = std::move(intermediate.clipped);
  prepared.checks = intermediate.recording.checks;
  const auto folding =
      intermediate.spectrum.checks(intermediate.recording.channels, prepared.options.rate_hz, prepared.decimation);
  prepared.checks.insert(prepared.checks.end(), folding.begin(), folding.end());
  std::vector<Interval> missing = intermediate.recording.bad;
  if (auto check = keep_bridged(intermediate.recording.bad, prepared.options.cutoff_hz))
    prepared.checks.push_back(std::move(*check));
  MotionBand band = motion_band_of_channels(known.channels, intermediate.spectrum);
  std::optional<RawSpectrum> slow;
  if (is_unresolved(band)) slow = spectrum_of_slow(known);
  if (slow) band = motion_band_of_channels(known.channels, *slow);
  if (!band.signal.empty()) prepared.checks.push_back(band_check(band, prepared.options.cutoff_hz));
  if (!has_displacement(known))
    settle_integration(prepared,
                       integration_from_hz(known.channels, slow ? *slow : intermediate.spectrum, known.duration_s()));
  remove_delays(intermediate.recording);
  for (Check& check :
       drop_unlike_derivatives(intermediate.recording, intermediate.spectrum, prepared.options.cutoff_hz))
    prepared.checks.push_back(std::move(check));
  for (std::size_t i = 0; i < prepared.channels.size(); ++i)
    prepared.channels[i].role = intermediate.recording.channels[i].role;
  if (prepared.options.recipe == Recipe::matched && !prepared.x_is_difference) {
    prepared.recorded = of_relative_motion(intermediate.recording, missing, false);
    if (prepared.integrated()) prepared.recorded_beside = of_relative_motion(intermediate.recording, missing, true);
  }
  finish(prepared, std::move(intermediate.recording), intermediate.sheet, num_threads);
  return prepared;
}

VectorXd regression_signal(const Prepared& prepared, std::string_view name) {
  const VectorXd& signal = prepared.signals.at(name);
  if (prepared.options.recipe == Recipe::paper || prepared.highpass_hz.empty()) return signal;
  // Behind a decimation only the high-pass is left to do; a taper does it in one with its own.
  const bool decimated = !prepared.filter.sheet().stages.empty();
  return decimated ? prepared.filter.high_passed(signal) : prepared.filter.apply(prepared.intermediate.at(name));
}

double mean_displacement(const Prepared& prepared, double from_s, double to_s) {
  const VectorXd& x = prepared.intermediate.at("x");
  double sum = 0.0;
  Index count = 0;
  for (Index i = 0; i < x.size(); ++i) {
    const double t = static_cast<double>(i) / prepared.intermediate.sample_rate_hz;
    if (t < from_s || t >= to_s || prepared.intermediate.excluded[static_cast<std::size_t>(i)] != 0) continue;
    sum += x(i);
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : 0.0;
}

void set_displacement_zero(Prepared& prepared, double zero_m) {
  displacement_of(prepared.intermediate).array() -= zero_m;
  displacement_of(prepared.signals).array() -= zero_m;
}

}  // namespace dsp
