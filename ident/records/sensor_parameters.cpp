#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <utility>

#include "dsp/filter/spectral.hpp"
#include "ident/records/record.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Changes = std::vector<dsp::Signal>;

using dsp::Body;

/// A change of base or payload; the relative motion goes with the payload and against the base.
void add(Changes& changes, const dsp::Motion& motion, Body body, int order, const VectorXd& change) {
  const std::string own(dsp::motion_signal(body, order).name);
  const std::string of_x(dsp::motion_signal(Body::relative, order).name);
  if (motion.find(own) != nullptr) changes.push_back({own, "", change});
  if (motion.find(of_x) != nullptr) changes.push_back({of_x, "", body == Body::base ? VectorXd(-change) : change});
}

std::shared_ptr<const SensorShape> shape(std::function<SignalChange(const dsp::Motion&)> change,
                                         bool of_accelerations = false) {
  return std::make_shared<const SensorShape>(SensorShape{std::move(change), of_accelerations});
}

const VectorXd& of(const dsp::Motion& motion, Body body, int order) {
  return motion.at(dsp::motion_signal(body, order).name);
}

SensorParameter relative_gain(double std) {
  return {
      .name = "relative gain of the base's displacement",
      .source = "relative gain of the base's displacement",
      .unit = "1",
      .std = std,
      .shape = shape([](const dsp::Motion& motion) -> SignalChange {
        std::array<double, 3> mean{};
        for (int order = 0; order < 3; ++order)
          mean[static_cast<std::size_t>(order)] = of(motion, Body::base, order).mean();
        return [&motion, mean](Index first, Index count) {
          Changes changes;
          for (int order = 0; order < 3; ++order)
            add(changes, motion, Body::base, order,
                of(motion, Body::base, order).segment(first, count).array() - mean[static_cast<std::size_t>(order)]);
          return changes;
        };
      })};
}

/// The same change of x and, where nothing measures a base, of y, which is x then.
Changes of_x(const dsp::Motion& motion, VectorXd change) {
  Changes changes{{"x", "", std::move(change)}};
  if (motion.find("r") == nullptr && motion.find("y") != nullptr) changes.push_back({"y", "", changes[0].values});
  return changes;
}

SensorParameter zero_of_x(double std, const std::string& unit) {
  return {.name = "zero of x",
          .source = "zero of x",
          .unit = unit,
          .std = std,
          .shape = shape([](const dsp::Motion& motion) -> SignalChange {
            return [&motion](Index, Index count) { return of_x(motion, VectorXd::Ones(count)); };
          }),
          .coordinate = Coordinate::zero_of_x};
}

constexpr double drift_step_s = 300.0;

SensorParameter drift_of_x(const SensorParameter& zero, double centre_s, double std) {
  return {.name = fmt::format("drift of x at {:.0f} s", centre_s),
          .source = "drift of x",
          .unit = zero.unit,
          .std = std,
          .from_s = centre_s - drift_step_s,
          .to_s = centre_s + drift_step_s,
          .shape = zero.shape,
          .course = [centre_s](double t_s) { return 1.0 - std::abs(t_s - centre_s) / drift_step_s; }};
}

/// Of these bodies' displacements by the same time.
SensorParameter lag(const std::vector<Body>& bodies, const std::string& channel, double std_s) {
  return {.name = "lag of " + channel,
          .source = "lag of " + channel,
          .unit = "s",
          .std = std_s,
          .shape = shape([bodies](const dsp::Motion& motion) -> SignalChange {
            return [bodies, &motion](Index first, Index count) {
              Changes changes;
              for (const Body body : bodies)
                for (int order = 0; order < 2; ++order)
                  add(changes, motion, body, order, of(motion, body, order + 1).segment(first, count));
              return changes;
            };
          })};
}

SensorParameter accelerometer_gain(Body body, const dsp::SensorRelation& relation) {
  return {.name = "gain of " + relation.acceleration,
          .source = "gain of " + relation.acceleration,
          .unit = "1",
          .std = relation.gain_std / relation.gain,
          .shape = shape(
              [body](const dsp::Motion& motion) -> SignalChange {
                return [body, &motion](Index first, Index count) {
                  Changes changes;
                  add(changes, motion, body, 2, of(motion, body, 2).segment(first, count));
                  return changes;
                };
              },
              true)};
}

/// What was divided by i f / (f_c + i f) above the passage to the displacement: one hertz more of the sum of cut-offs
/// is sum (1 / n) / (f_c + i f) more of the signal.
SensorParameter coupling(Body body, const dsp::SensorRelation& relation, double passage_hz) {
  return {.name = "coupling of " + relation.acceleration,
          .source = "coupling of " + relation.acceleration,
          .unit = "Hz",
          .std = relation.highpass_sum_std_hz,
          .shape = shape(
              [body, passage_hz, cutoffs = relation.highpass_hz](const dsp::Motion& motion) -> SignalChange {
                const dsp::SpectralBand low{passage_hz / 2.0, passage_hz};
                const dsp::ExtendedSpectrum spectrum(of(motion, body, 2), motion.sample_rate_hz);
                VectorXd whole = spectrum.filtered([&](double f) {
                  std::complex<double> sum = 0.0;
                  for (const double cutoff : cutoffs)
                    sum +=
                        (1.0 - low.gain(f)) / (static_cast<double>(cutoffs.size()) * std::complex<double>(cutoff, f));
                  return sum;
                });
                return [body, &motion, whole = std::move(whole)](Index first, Index count) {
                  Changes changes;
                  add(changes, motion, body, 2, whole.segment(first, count));
                  return changes;
                };
              },
              true)};
}

SensorParameter lag_of_force(double std_s) {
  return {.name = "lag of f",
          .source = "lag of f",
          .unit = "s",
          .std = std_s,
          .shape = shape([](const dsp::Motion& motion) -> SignalChange {
            // To Nyquist, where a derivative must be zero, within the fifth of the band that the columns' filter stops.
            const double end_hz = 0.5 * motion.sample_rate_hz;
            const dsp::ExtendedSpectrum spectrum(motion.at("f"), motion.sample_rate_hz);
            return [slope = spectrum.derivative(1, {0.8 * end_hz, end_hz})](Index first, Index count) {
              return Changes{{"f", "", slope.segment(first, count)}};
            };
          }),
          .coordinate = Coordinate::lead_of_f};
}

/// Of the recording itself.
double sample_interval_s(const dsp::Prepared& prepared) {
  const bool decimated = prepared.decimation && !prepared.decimation->stages.empty();
  return 1.0 / (decimated ? prepared.decimation->stages.front().input_rate_hz : prepared.intermediate.sample_rate_hz);
}

/// Where base and payload are seen to move as one the base's signals follow the payload's.
SensorParameter of_mount(dsp::MountParameter which, const Record& record) {
  const dsp::Mount& mount = record.mount;
  const bool damping = which == dsp::MountParameter::damping;
  const std::string name = damping ? "damping of the mount" : "frequency of the mount";
  return {.name = name,
          .source = name,
          .unit = damping ? "1" : "Hz",
          .std = damping ? mount.damping_std : mount.frequency_std_hz,
          .shape = shape([which, mount, band = mount_band(record.prepared),
                          with_it = record.base_by_mount[static_cast<std::size_t>(which)]](
                             const dsp::Motion& motion) -> SignalChange {
            std::array<VectorXd, 3> whole;
            for (int order = 0; order < 3; ++order)
              if (motion.find(dsp::motion_signal(Body::relative, order).name) != nullptr)
                whole[static_cast<std::size_t>(order)] = dsp::mount_sensitivity(
                    dsp::payload_signal(motion, order), motion.sample_rate_hz, mount, which, band);
            return [&motion, whole = std::move(whole), with_it](Index first, Index count) {
              Changes changes;
              for (int order = 0; order < 3; ++order) {
                const VectorXd& all = whole[static_cast<std::size_t>(order)];
                if (all.size() > 0) add(changes, motion, Body::payload, order, all.segment(first, count));
                if (with_it.gain == 0.0) continue;
                VectorXd follows = with_it.gain * of(motion, Body::base, order).segment(first, count);
                if (order < 2) follows += with_it.lead_s * of(motion, Body::base, order + 1).segment(first, count);
                add(changes, motion, Body::base, order, follows);
              }
              return changes;
            };
          })};
}

/// How far x, averaged over a minute of motion, wanders about its mean.
double observed_wander(const Record& record) {
  constexpr double average_s = 60.0;  // some fifty periods, whose own means are next to nothing
  const dsp::Motion& signals = record.prepared.signals;
  const VectorXd& x = signals.at("x");
  const auto block = std::max<Index>(1, static_cast<Index>(average_s * signals.sample_rate_hz));
  std::vector<double> means;
  for (Index first = 0; first + block <= x.size(); first += block) {
    const auto moves = [&](Index i) {
      const auto n = static_cast<std::size_t>(i);
      const bool moving =
          record.regimes.empty() || record.regimes[n] == dsp::Regime::low || record.regimes[n] == dsp::Regime::high;
      return moving && signals.excluded[n] == 0;
    };
    bool whole = true;
    for (Index i = first; whole && i < first + block; ++i) whole = moves(i);
    if (whole) means.push_back(x.segment(first, block).mean());
  }
  if (means.size() < 2) return 0.0;
  const Eigen::Map<const VectorXd> all(means.data(), std::ssize(means));
  return std::sqrt((all.array() - all.mean()).square().sum() / static_cast<double>(means.size() - 1));
}

double extent(const VectorXd& values) {
  return values.maxCoeff() - values.minCoeff();
}

/// `two`: x is the difference of two sensors, whose zeros are arbitrary. A single one has its own zero unless it is to
/// be fitted.
void append_displacements(const Record& record, bool two, std::vector<SensorParameter>& parameters) {
  constexpr double unknown_zero = 0.01;  // of its range
  const dsp::Prepared& prepared = record.prepared;
  const dsp::Motion& signals = prepared.signals;
  double gain_std = 0.0, zero_m = 0.0, drift_m = 0.0;
  for (const auto& [role, name] :
       {std::pair{dsp::Role::r, "r"}, std::pair{dsp::Role::y, "y"}, std::pair{dsp::Role::x, "x"}}) {
    const dsp::Channel* channel = prepared.channel(role);
    if (channel == nullptr) continue;
    gain_std = std::hypot(gain_std, channel->sensitivity_uncertainty);
    const double range = channel->range > 0.0           ? channel->range
                         : two || record.zero_is_fitted ? extent(signals.at(name))
                                                        : 0.0;
    zero_m = std::hypot(zero_m, unknown_zero * range);
    drift_m = std::hypot(drift_m, channel->drift);
  }
  if (record.common_motion) gain_std = std::min(gain_std, record.common_motion->gain_std);
  const std::string& unit = signals.find("x")->unit;
  if (prepared.x_is_difference && gain_std > 0.0) parameters.push_back(relative_gain(gain_std));
  const SensorParameter zero = zero_of_x(zero_m, unit);
  if (zero_m > 0.0 && !record.zero_is_known) parameters.push_back(zero);
  const double duration_s = static_cast<double>(signals.num_samples()) / signals.sample_rate_hz;
  if (drift_m == 0.0 && two) drift_m = observed_wander(record);
  if (drift_m == 0.0) return;
  for (int k = 0; static_cast<double>(k - 1) * drift_step_s < duration_s; ++k)
    parameters.push_back(drift_of_x(zero, static_cast<double>(k) * drift_step_s, drift_m));
}

}  // namespace

std::vector<SensorParameter> sensor_parameters(const Record& record) {
  const dsp::Prepared& prepared = record.prepared;
  const auto& relations = prepared.relations;
  std::vector<SensorParameter> parameters;
  if (!prepared.equalised() || prepared.options.scale != dsp::ScaleReference::displacement ||
      !std::all_of(relations.begin(), relations.end(), dsp::can_be_corrected))
    return parameters;
  const dsp::Motion& signals = prepared.signals;
  const bool two = prepared.x_is_difference && signals.find("r") != nullptr && signals.find("y") != nullptr;
  const bool lone = signals.find("r") == nullptr &&
                    (prepared.channel(dsp::Role::x) != nullptr) != (prepared.channel(dsp::Role::y) != nullptr);
  if (two || lone) append_displacements(record, two, parameters);
  // Channels scanned one after the other are apart by some fraction of a sample interval, any with equal probability.
  if (prepared.channel(dsp::Role::f) != nullptr)
    parameters.push_back(lag_of_force(sample_interval_s(prepared) / std::sqrt(12.0)));
  const dsp::Signal* a = signals.find("a");
  if (a == nullptr || std::isfinite(a->flat_to_hz)) return parameters;
  double passage_hz = 0.0;
  for (const double cutoff : prepared.highpass_hz) passage_hz = std::max(passage_hz, cutoff);
  for (const dsp::SensorRelation& relation : relations) {
    const Body body = relation.name.starts_with("r ") ? Body::base : Body::payload;
    const bool of_base_clock =
        body == Body::base && record.common_motion.has_value();  // the payload's clock, but for what is left
    const double lag_std_s = of_base_clock ? record.common_motion->lead_std_s : relation.lag_std_s;
    const bool leads = body == Body::payload && record.common_motion.has_value();
    if (lag_std_s > 0.0)
      parameters.push_back(
          lag(leads ? std::vector{Body::base, Body::payload} : std::vector{body}, relation.displacement, lag_std_s));
    if (relation.highpass_sum_std_hz > 0.0) parameters.push_back(coupling(body, relation, passage_hz));
    if (relation.gain_std > 0.0 && dsp::gain_is_plausible(relation))
      parameters.push_back(accelerometer_gain(body, relation));
  }
  if (!record.mount.is_rigid())
    for (const dsp::MountParameter which : {dsp::MountParameter::frequency, dsp::MountParameter::damping})
      parameters.push_back(of_mount(which, record));
  return parameters;
}

dsp::Motion in_coordinates(dsp::Motion motion, double zero, double lead_s) {
  Changes changes;
  const auto add_change = [&](const SensorParameter& parameter, double value) {
    if (value == 0.0) return;
    for (dsp::Signal& change : parameter.shape->change(motion)(0, motion.num_samples())) {
      change.values *= value;
      changes.push_back(std::move(change));
    }
  };
  add_change(zero_of_x(0.0, ""), -zero);
  add_change(lag_of_force(0.0), lead_s);
  for (const dsp::Signal& change : changes)
    for (dsp::Signal& signal : motion.signals)
      if (signal.name == change.name) signal.values += change.values;
  return motion;
}

}  // namespace ident
