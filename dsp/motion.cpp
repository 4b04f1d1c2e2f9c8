#include "dsp/motion.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

namespace dsp {
namespace {
using Eigen::Index;
using Eigen::VectorXd;

// A displacement with its derivatives, each as measured or else computed from the measured one of next lower order.
struct Quantity {
  std::array<std::optional<VectorXd>, 3> measured, values;
};

// The channel without the lag it is known to have.
VectorXd on_the_clock(const Recording& recording, Index channel, const ExtensionOptions& extension) {
  const double delay_s = recording.channels[static_cast<std::size_t>(channel)].delay_s;
  if (delay_s == 0.0) return recording.samples.col(channel);
  return ExtendedSpectrum(recording.samples.col(channel), recording.sample_rate_hz, extension)
      .filtered([delay_s](double f) { return std::polar(1.0, 2.0 * std::numbers::pi * f * delay_s); });
}

std::optional<VectorXd> combine(const std::optional<VectorXd>& a, double sign, const std::optional<VectorXd>& b) {
  if (!a || !b) return std::nullopt;
  return *a + sign * *b;
}

// muParser and CSV headers take letters, digits and '_'; names already in use get a number.
std::string clean_name(const std::string& name, const std::vector<Signal>& taken) {
  std::string clean;
  for (const unsigned char c : name) clean += std::isalnum(c) ? static_cast<char>(c) : '_';
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
  MotionBuilder(const Recording& recording, const MotionOptions& options) : recording_(recording), options_(options) {}

  Motion build() {
    Quantity r = measured(Role::r, Role::dr, Role::ddr), y = measured(Role::y, Role::dy, Role::ddy),
             x = measured(Role::x, Role::v, Role::a);
    const bool has_base = r.measured[0] || r.measured[1] || r.measured[2] || (x.measured[0] && y.measured[0]);
    complete_displacements(r, y, x, has_base);
    if (r.values[0]) complete(r);
    if (y.values[0]) complete(y);
    complete_relative(r, y, x, has_base);

    const double rate_hz = recording_.sample_rate_hz;
    const Index n = recording_.samples.rows();
    Motion motion{.sample_rate_hz = rate_hz};
    motion.signals.push_back({"t", "s", VectorXd::LinSpaced(n, 0.0, static_cast<double>(n - 1)) / rate_hz});
    add(motion, {"x", "v", "a"}, x);
    add(motion, {"r", "dr", "ddr"}, r);
    add(motion, {"y", "dy", "ddy"}, y);
    add_others(motion);
    motion.excluded.assign(static_cast<std::size_t>(n), 0);
    for (const auto& bad : recording_.bad) mark(motion, bad);
    motion.edge_samples =
        std::min(n / 2, static_cast<Index>(std::ceil(rate_hz / (options_.band.cutoff_hz - options_.band.rolloff_hz))));
    motion.dropped_power_fraction =
        ExtendedSpectrum(*x.values[0], rate_hz, options_.extension).power_fraction_above(options_.band.cutoff_hz);
    return motion;
  }

 private:
  Quantity measured(Role displacement, Role velocity, Role acceleration) const {
    Quantity q;
    const std::array roles{displacement, velocity, acceleration};
    for (std::size_t i = 0; i < 3; ++i)
      if (const Index channel = recording_.find(roles[i]); channel >= 0)
        q.values[i] = q.measured[i] = on_the_clock(recording_, channel, options_.extension);
    return q;
  }

  VectorXd derivative(const VectorXd& signal, int order) const {
    return ExtendedSpectrum(signal, recording_.sample_rate_hz, options_.extension).derivative(order, options_.band);
  }

  // x = y - r, whichever two are measured.
  void complete_displacements(Quantity& r, Quantity& y, Quantity& x, bool has_base) const {
    if (!has_base) {
      if (!x.values[0]) x.values[0] = y.values[0];
      for (std::size_t i = 0; i < 3; ++i)
        if (!y.values[i]) y.values[i] = y.measured[i] = x.values[i];
    }
    if (!x.values[0]) x.values[0] = combine(y.values[0], -1.0, r.values[0]);
    if (!y.values[0]) y.values[0] = combine(x.values[0], 1.0, r.values[0]);
    if (has_base && !r.values[0]) r.values[0] = combine(y.values[0], -1.0, x.values[0]);
    if (!x.values[0])
      throw Fault(FaultKind::input, "motion.no_displacement",
                  recording_.name + ": no relative displacement can be had: found " + roles_found() +
                      ", wanted x, or y and r, or y alone without a base; give channels their roles in the sidecar");
  }

  void complete(Quantity& q) const {
    if (!q.values[1]) q.values[1] = derivative(*q.values[0], 1);
    if (!q.values[2]) q.values[2] = q.measured[1] ? derivative(*q.measured[1], 1) : derivative(*q.values[0], 2);
  }

  void complete_relative(const Quantity& r, const Quantity& y, Quantity& x, bool has_base) const {
    const auto difference = [&](std::size_t order) {
      return has_base ? combine(y.measured[order], -1.0, r.measured[order]) : y.measured[order];
    };
    if (!x.values[1]) x.values[1] = difference(1);
    const bool velocity_measured = x.values[1].has_value();
    if (!velocity_measured) x.values[1] = derivative(*x.values[0], 1);

    const auto accelerometer = x.measured[2] ? x.measured[2] : difference(2);
    if (options_.acceleration == AccelerationSource::accelerometer && !accelerometer)
      throw Fault(FaultKind::usage, "motion.no_accelerometer",
                  recording_.name + ": the acceleration is to come from accelerometers, found " + roles_found() +
                      ", wanted a, or ddy and ddr; set prepare.acceleration to displacement");
    if (accelerometer && options_.acceleration != AccelerationSource::displacement)
      x.values[2] = accelerometer;
    else
      x.values[2] = velocity_measured ? derivative(*x.values[1], 1) : derivative(*x.values[0], 2);
  }

  std::string roles_found() const {
    std::string found;
    for (const auto& channel : recording_.channels)
      found += (found.empty() ? "" : ", ") + channel.name + " (" + std::string(to_string(channel.role)) + ")";
    return found.empty() ? "no channels" : found;
  }

  static void add(Motion& motion, const std::array<const char*, 3>& names, const Quantity& q) {
    const std::array units{"m", "m/s", "m/s^2"};
    for (std::size_t i = 0; i < 3; ++i)
      if (q.values[i]) motion.signals.push_back({names[i], units[i], *q.values[i]});
  }

  void add_others(Motion& motion) const {
    for (const Role wanted : {Role::f, Role::z, Role::other})
      for (std::size_t i = 0; i < recording_.channels.size(); ++i) {
        const auto& channel = recording_.channels[i];
        if (channel.role != wanted) continue;
        const std::string name = wanted == Role::other ? channel.name : std::string(to_string(wanted));
        motion.signals.push_back({clean_name(name, motion.signals), channel.unit,
                                  on_the_clock(recording_, static_cast<Index>(i), options_.extension)});
      }
  }

  const Recording& recording_;
  const MotionOptions& options_;
};
}  // namespace

const Signal* Motion::find(std::string_view name) const {
  const auto it = std::find_if(signals.begin(), signals.end(), [&](const Signal& s) { return s.name == name; });
  return it == signals.end() ? nullptr : &*it;
}

const VectorXd& Motion::at(std::string_view name) const {
  if (const Signal* signal = find(name)) return signal->values;
  std::string known;
  for (const auto& signal : signals) known += (known.empty() ? "" : ", ") + signal.name;
  throw std::invalid_argument("no signal '" + std::string(name) + "'; there are " + known);
}

void mark(Motion& motion, const Interval& interval, double margin_s) {
  const auto n = static_cast<double>(motion.excluded.size());
  const double first = std::ceil((interval.from_s - margin_s) * motion.sample_rate_hz - 1e-9);
  const double last = std::floor((interval.to_s + margin_s) * motion.sample_rate_hz + 1e-9);
  for (double i = std::max(first, 0.0); i <= last && i < n; ++i) motion.excluded[static_cast<std::size_t>(i)] = 1;
}

Motion relative_motion(const Recording& recording, const MotionOptions& options) {
  const auto& band = options.band;
  if (!(band.rolloff_hz > 0.0) || !(band.cutoff_hz > band.rolloff_hz) ||
      !(band.cutoff_hz <= recording.sample_rate_hz / 2.0))
    throw std::invalid_argument("relative_motion: 0 < rolloff_hz < cutoff_hz <= half the sample rate is required");
  return MotionBuilder(recording, options).build();
}

}  // namespace dsp
