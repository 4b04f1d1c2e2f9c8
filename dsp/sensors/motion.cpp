#include "dsp/sensors/motion.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <complex>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "dsp/io/channel_roles.hpp"
#include "dsp/values/constants.hpp"

namespace dsp {
namespace {
using Eigen::Index;
using Eigen::VectorXd;

// A displacement with its derivatives (empty: not there yet), each as measured or else computed.
struct BodyMotion {
  std::array<VectorXd, 3> values;
  std::array<bool, 3> measured{};
  [[nodiscard]] bool has(std::size_t order) const { return values[order].size() > 0; }
  [[nodiscard]] bool has_any() const { return has(0) || has(1) || has(2); }
  void set(std::size_t order, VectorXd signal, bool is_measured) {
    values[order] = std::move(signal);
    measured[order] = is_measured;
  }
};

// Terms and CSV headers take letters, digits and '_'; names already in use get a number.
std::string usable_name(const std::string& name, const std::vector<Signal>& taken) {
  constexpr std::size_t most_characters = 60;
  std::string clean;
  for (const unsigned char c : name.substr(0, most_characters)) clean += std::isalnum(c) ? static_cast<char>(c) : '_';
  if (clean.empty() || std::isdigit(static_cast<unsigned char>(clean.front()))) clean = '_' + clean;
  const auto is_taken = [&](const std::string& s) {
    return std::any_of(taken.begin(), taken.end(), [&](const Signal& signal) { return signal.name == s; });
  };
  std::string unique = clean;
  for (int i = 2; is_taken(unique); ++i) unique = clean + "_" + std::to_string(i);
  return unique;
}

class MotionBuilder {
 public:
  MotionBuilder(Recording recording, const MotionOptions& options)
      : recording_(std::move(recording)), options_(options) {}

  Motion build() {
    if (!any_motion(recording_.channels))
      throw no_motion(recording_.name, recording_.channels,
                      find_derivatives(recording_.samples, recording_.sample_rate_hz),
                      look_at(recording_.samples, recording_.sample_rate_hz), recording_.checks);
    const double rate_hz = recording_.sample_rate_hz;
    const Index n = recording_.samples.rows();
    Motion motion{.sample_rate_hz = rate_hz};
    motion.excluded.assign(static_cast<std::size_t>(n), 0);
    for (const auto& bad : recording_.bad) mark(motion, bad);
    for (const auto& channel : recording_.channels) {
      if (channel.calibrated) continue;
      motion.uncalibrated.push_back(channel.name);
      if (info_of(channel.role).order >= 0 || channel.role == Role::t) has_units_ = false;
    }
    motion.edge_samples =
        std::min(n / 2, static_cast<Index>(std::ceil(rate_hz / (options_.band.cutoff_hz - options_.band.rolloff_hz))));

    BodyMotion r = measured(Body::base), y = measured(Body::payload), x = measured(Body::relative);
    auto others = other_channels();
    recording_.samples.resize(0, 0);  // the signals are as large again

    if (!has_displacement(recording_) && (x.has_any() || y.has_any())) {
      for (BodyMotion* q : {&r, &y, &x}) integrate(*q);
      for (Signal& other : others) other.values = without_drift(other.values);
      const double reach = integral_reach_periods * rate_hz / options_.integrate_from_hz;
      motion.edge_samples = std::max(motion.edge_samples, std::min(n / 2, static_cast<Index>(reach)));
    }
    has_base_ = r.has(0) || r.has(1) || r.has(2) || (x.has(0) && y.has(0));
    complete_displacements(r, y, x);
    {
      const ExtendedSpectrum of_x = spectrum(x.values[0]);
      complete_relative(r, y, x, of_x);
      motion.dropped_power_fraction = of_x.power_fraction_above(options_.band.cutoff_hz);
    }
    for (BodyMotion* q : {&r, &y})
      if (q->has(0) && !(q->has(1) && q->has(2))) complete(*q, spectrum(q->values[0]));

    motion.signals.push_back({"t", "s", VectorXd::LinSpaced(n, 0.0, static_cast<double>(n - 1)) / rate_hz});
    add(motion, Body::relative, x);
    add(motion, Body::base, r);
    add(motion, Body::payload, y);
    for (auto& signal : others) {
      signal.name = usable_name(signal.name, motion.signals);
      motion.signals.push_back(std::move(signal));
    }
    return motion;
  }

 private:
  BodyMotion measured(Body body) const {
    BodyMotion q;
    for (std::size_t i = 0; i < 3; ++i)
      if (const Index channel = recording_.find(motion_signal(body, static_cast<int>(i)).role); channel >= 0)
        q.set(i, recording_.samples.col(channel), true);
    return q;
  }

  std::vector<Signal> other_channels() const {
    std::vector<Signal> others;
    std::vector<Role> roles;
    for (const SignalInfo& signal : signal_table())
      if (signal.body == Body::none && signal.role != Role::t && signal.role != Role::other)
        roles.push_back(signal.role);
    roles.push_back(Role::other);
    for (const Role wanted : roles)
      for (std::size_t i = 0; i < recording_.channels.size(); ++i) {
        const auto& channel = recording_.channels[i];
        if (channel.role == wanted)
          others.push_back({wanted == Role::other ? channel.name : std::string(to_string(wanted)), channel.unit,
                            recording_.samples.col(static_cast<Index>(i))});
      }
    return others;
  }

  ExtendedSpectrum spectrum(const VectorXd& signal) const {
    return ExtendedSpectrum(signal, recording_.sample_rate_hz, options_.extension);
  }

  VectorXd without_drift(const VectorXd& values) const {
    const SpectralBand drift{0.5 * options_.integrate_from_hz, options_.integrate_from_hz};
    return spectrum(values).filtered([&](double f) { return 1.0 - drift.gain(f); });
  }

  // From the lowest order measured; what was measured ends below where the integral does.
  void integrate(BodyMotion& q) const {
    const double from_hz = options_.integrate_from_hz;
    std::size_t lowest = 3;
    for (std::size_t order = 3; order-- > 0;)
      if (q.has(order)) lowest = order;
    if (lowest == 3) return;
    if (!(from_hz > 0.0) || !(from_hz < options_.band.rolloff_hz))
      throw std::invalid_argument("relative_motion: 0 < integrate_from_hz < rolloff_hz is required");
    for (std::size_t order = lowest; order < 3; ++order)
      if (q.has(order)) q.values[order] = without_drift(q.values[order]);
    const ExtendedSpectrum of_lowest = spectrum(q.values[lowest]);
    for (std::size_t order = 0; order < lowest; ++order)
      q.set(order, of_lowest.filtered([&](double f) -> std::complex<double> {
        if (!(f > 0.5 * from_hz)) return 0.0;
        return std::pow(std::complex<double>(0.0, 2.0 * std::numbers::pi * f), -static_cast<int>(lowest - order));
      }),
            true);
  }

  // x = y - r, whichever two are measured; without a base all that is known of x and y is known of both.
  void complete_displacements(BodyMotion& r, BodyMotion& y, BodyMotion& x) const {
    if (!has_base_)
      for (std::size_t i = 0; i < 3; ++i) {
        if (!x.has(i) && i == 0) x.set(i, y.values[i], y.measured[i]);
        if (!y.has(i)) y.set(i, x.values[i], x.measured[i]);
      }
    if (!x.has(0) && y.has(0) && r.has(0)) x.set(0, y.values[0] - r.values[0], true);
    if (!y.has(0) && x.has(0) && r.has(0)) y.set(0, x.values[0] + r.values[0], true);
    if (has_base_ && !r.has(0) && y.has(0) && x.has(0)) r.set(0, y.values[0] - x.values[0], true);
    if (!x.has(0)) throw no_motion(recording_.name, recording_.channels);
  }

  // Derivatives not yet there, from the highest measured one below them.
  void complete(BodyMotion& q, const ExtendedSpectrum& displacement) const {
    if (!q.has(1)) q.set(1, displacement.derivative(1, options_.band), false);
    if (!q.has(2))
      q.set(2,
            q.measured[1] ? spectrum(q.values[1]).derivative(1, options_.band)
                          : displacement.derivative(2, options_.band),
            false);
  }

  void complete_relative(const BodyMotion& r, const BodyMotion& y, BodyMotion& x, const ExtendedSpectrum& of_x) const {
    for (const std::size_t i : {1, 2}) {
      if (x.has(i) || !y.measured[i] || (has_base_ && !r.measured[i])) continue;
      if (has_base_)
        x.set(i, y.values[i] - r.values[i], true);
      else
        x.set(i, y.values[i], true);
    }
    if (options_.acceleration == AccelerationSource::accelerometer && !x.has(2))
      throw Fault(FaultKind::usage, "motion.no_accelerometer",
                  recording_.name + ": the acceleration is to come from accelerometers, found " +
                      in_words(recording_.channels) +
                      ", wanted a, or ddy and ddr; set prepare.acceleration to displacement");
    if (options_.acceleration == AccelerationSource::displacement) x.set(2, {}, false);
    complete(x, of_x);
  }

  // Of displacement, velocity and acceleration: as the channels say; the others follow from the displacement's.
  std::array<std::string, 3> units() const {
    constexpr std::array by_time{"", "/s", "/s^2"};
    std::array<std::string, 3> found{"m", "", ""};
    if (!has_displacement(recording_))  // that of a turn follows from its rate
      for (const Channel& channel : recording_.channels)
        if (info_of(channel.role).order > 0 && channel.unit.starts_with("rad")) found[0] = "rad";
    for (std::size_t order = 0; order < 3; ++order) {
      const bool simple =
          std::all_of(found[0].begin(), found[0].end(), [](unsigned char c) { return std::isalpha(c); });
      if (order > 0 && simple) found[order] = found[0] + by_time[order];
      for (const Body body : {Body::relative, Body::payload, Body::base})
        if (const Index channel = recording_.find(motion_signal(body, static_cast<int>(order)).role); channel >= 0) {
          const std::string& unit = recording_.channels[static_cast<std::size_t>(channel)].unit;
          if (unit.empty()) continue;
          found[order] = unit;
          break;
        }
    }
    return found;
  }

  void add(Motion& motion, Body body, BodyMotion& q) const {
    const auto units_found = units();
    for (std::size_t i = 0; i < 3; ++i)
      if (q.has(i)) {
        motion.signals.push_back({std::string(motion_signal(body, static_cast<int>(i)).name),
                                  has_units_ ? units_found[i] : "", std::move(q.values[i])});
        if (!q.measured[i]) motion.signals.back().flat_to_hz = options_.band.rolloff_hz;
      }
  }

  Recording recording_;
  const MotionOptions& options_;
  bool has_base_ = false, has_units_ = true;
};
}  // namespace

bool has_displacement(const Recording& recording) {
  const auto has = [&](Role role) { return recording.find(role) >= 0; };
  const bool base = has(Role::r) || has(Role::dr) || has(Role::ddr);
  return has(Role::x) || (has(Role::y) && (has(Role::r) || !base));
}

const Signal* Motion::find(std::string_view name) const& {
  const auto it = std::find_if(signals.begin(), signals.end(), [&](const Signal& s) { return s.name == name; });
  return it == signals.end() ? nullptr : &*it;
}

const VectorXd& Motion::at(std::string_view name) const& {
  if (const Signal* signal = find(name)) return signal->values;
  std::string known;
  for (const auto& signal : signals) known += (known.empty() ? "" : ", ") + signal.name;
  throw std::invalid_argument("no signal '" + std::string(name) + "'; there are " + known);
}

namespace {
/// What is left of a sine whose values are held: the mean of so many equal steps of its phase. 1 above half the own
/// rate, where there are but its images.
double gain_of_hold(double f, const Channel& channel) {
  const double half_turn = std::numbers::pi * f * channel.hold_s;
  if (!(half_turn > 0.0) || half_turn > 0.5 * std::numbers::pi) return 1.0;
  return std::sin(half_turn) / (channel.hold_samples * std::sin(half_turn / channel.hold_samples));
}
}  // namespace

void remove_delays(Recording& recording, const ExtensionOptions& extension) {
  for (std::size_t c = 0; c < recording.channels.size(); ++c) {
    Channel& channel = recording.channels[c];
    if (channel.delay_s == 0.0 && channel.hold_s == 0.0) continue;
    auto samples = recording.samples.col(static_cast<Index>(c));
    samples = ExtendedSpectrum(samples, recording.sample_rate_hz, extension).filtered([&](double f) {
      return std::polar(1.0 / gain_of_hold(f, channel), two_pi * f * channel.delay_s);
    });
    channel.delay_s = channel.hold_s = 0.0;
  }
}

void mark(Motion& motion, const Interval& interval, double margin_s) {
  const auto n = static_cast<double>(motion.excluded.size());
  const double first = std::ceil((interval.from_s - margin_s) * motion.sample_rate_hz - 1e-9);
  const double last = std::floor((interval.to_s + margin_s) * motion.sample_rate_hz + 1e-9);
  for (double i = std::max(first, 0.0); i <= last && i < n; ++i) motion.excluded[static_cast<std::size_t>(i)] = 1;
}

Motion relative_motion(Recording recording, const MotionOptions& options) {
  const auto& band = options.band;
  if (!(band.rolloff_hz > 0.0) || !(band.cutoff_hz > band.rolloff_hz) ||
      !(band.cutoff_hz <= recording.sample_rate_hz / 2.0))
    throw std::invalid_argument("relative_motion: 0 < rolloff_hz < cutoff_hz <= half the sample rate is required");
  remove_delays(recording, options.extension);
  return MotionBuilder(std::move(recording), options).build();
}

}  // namespace dsp
