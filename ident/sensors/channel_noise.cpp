#include "ident/sensors/channel_noise.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "dsp/filter/power_density.hpp"
#include "dsp/filter/spectral.hpp"
#include "dsp/values/signals.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr Index piece_samples = 16384;  // a transform that stays in the cache

/// Up to where a signal is more than its noise, whose density grows as f^(2 order).
double needed_band(const Eigen::VectorXd& signal, double sample_rate_hz, int order, double noise_variance,
                   double band_hz) {
  const dsp::PowerDensity spectrum(signal, sample_rate_hz, piece_samples);
  const VectorXd& density = spectrum.ordinates();
  const double bin_hz = spectrum.step_hz();
  if (density.size() == 0) return band_hz;
  const double noise_at_end = noise_variance * (2.0 * order + 1.0) / band_hz;
  // So many ordinates of noise are together twice what they are on average less than once in 1e7.
  constexpr Index together = 48;
  const Index end = std::min(static_cast<Index>(band_hz / bin_hz), density.size());
  for (Index first = end - together; first > 0; first -= together) {
    const double f_hz = bin_hz * (static_cast<double>(first) + 0.5 * together);
    if (density.segment(first, together).mean() > 2.0 * noise_at_end * std::pow(f_hz / band_hz, 2.0 * order))
      return bin_hz * static_cast<double>(first + together);
  }
  return end > together ? bin_hz * together : band_hz;
}

}  // namespace

NoiseDensity noise_density(const Eigen::Ref<const VectorXd>& signal, double sample_rate_hz, double from_hz,
                           double to_hz) {
  const dsp::PowerDensity spectrum(signal, sample_rate_hz, piece_samples);
  constexpr int quarters = 4;
  constexpr Index least = 8;     // ordinates of a quarter
  constexpr double alike = 2.0;  // more than the medians of a dozen ordinates differ by chance
  const double width_hz = (to_hz - from_hz) / quarters;
  double of_quarter[quarters];
  for (int i = 0; i < quarters; ++i)
    of_quarter[i] = spectrum.between(from_hz + i * width_hz, from_hz + (i + 1) * width_hz, least);
  const double first = of_quarter[0];
  std::sort(std::begin(of_quarter), std::end(of_quarter));
  if (of_quarter[1] <= alike * of_quarter[0]) return {of_quarter[0], false};
  return {first, true};
}

ChannelNoise::ChannelNoise(const dsp::Prepared& prepared, const std::string& target) {
  const dsp::Motion& motion = prepared.intermediate;
  if (prepared.integrated()) integrated_from_hz_ = prepared.options.integrate_from_hz;
  const double stop_hz = prepared.filter.stop_hz(), rate_hz = motion.sample_rate_hz;
  band_hz_ = 0.5 * (prepared.options.rolloff_hz + stop_hz);
  const bool own_rate = !prepared.decimation || prepared.decimation->stages.empty() ||
                        prepared.decimation->stages.front().input_rate_hz <= rate_hz;
  // Behind an anti-alias filter noise is flat up to the end of the state band only.
  const double to_hz = own_rate ? 0.45 * rate_hz : prepared.options.state_cutoff_hz;
  const double from_hz = std::min(stop_hz, 0.5 * to_hz);
  for (const dsp::Signal& signal : motion.signals)
    if (signal.name != "t") parts_[signal.name] = parts_of(prepared, signal.name, 0);
  for (const auto& [name, parts] : parts_)
    for (const Part& part : parts)
      if (density_.count(part.channel) == 0)
        density_[part.channel] = noise_density(motion.at(part.channel), rate_hz, from_hz, to_hz);
  int order = 0;
  for (const Part& part : parts_[target]) order = std::max(order, part.order);
  needed_hz_ = needed_band(motion.at(target), rate_hz, order, covariance(target, target), band_hz_);
}

std::vector<ChannelNoise::Part> ChannelNoise::parts_of(const dsp::Prepared& prepared, const std::string& signal,
                                                       int depth) const {
  constexpr int deepest = 6;  // a = dv/dt, v = dx/dt, x = y - r
  const dsp::Motion& motion = prepared.intermediate;
  const dsp::SignalInfo* info = dsp::find_signal(signal);
  const bool moves = info != nullptr && info->order >= 0;
  if (!moves || prepared.channel(info->role) != nullptr || depth == deepest) return {{signal, 0, 1.0}};
  const auto integrated_from = [&](dsp::Body body) -> std::vector<Part> {
    for (int order = info->order + 1; order <= 2 && integrated_from_hz_ > 0.0; ++order)
      if (const dsp::SignalInfo& above = dsp::motion_signal(body, order); prepared.channel(above.role) != nullptr)
        return {{std::string(above.name), info->order - order, 1.0}};
    return {};
  };
  if (std::vector<Part> parts = integrated_from(info->body); !parts.empty()) return parts;
  if (std::isfinite(motion.find(signal)->flat_to_hz)) {  // a computed derivative
    const std::string below(dsp::motion_signal(info->body, info->order - 1).name);
    if (motion.find(below) == nullptr) return {{signal, 0, 1.0}};
    std::vector<Part> parts = parts_of(prepared, below, depth + 1);
    for (Part& part : parts) ++part.order;
    return parts;
  }
  const auto with = [&](dsp::Body one, dsp::Body other, double sign) -> std::vector<Part> {
    const std::string a(dsp::motion_signal(one, info->order).name), b(dsp::motion_signal(other, info->order).name);
    if (motion.find(a) == nullptr || motion.find(b) == nullptr) return {};
    std::vector<Part> parts = parts_of(prepared, a, depth + 1);
    for (Part part : parts_of(prepared, b, depth + 1)) {
      part.sign *= sign;
      parts.push_back(part);
    }
    return parts;
  };
  std::vector<Part> parts = info->body == dsp::Body::relative  ? with(dsp::Body::payload, dsp::Body::base, -1.0)
                            : info->body == dsp::Body::payload ? with(dsp::Body::relative, dsp::Body::base, 1.0)
                                                               : with(dsp::Body::payload, dsp::Body::relative, -1.0);
  if (!parts.empty()) return parts;
  // Without a base the relative and the absolute motion are one.
  const dsp::Body twin = info->body == dsp::Body::relative ? dsp::Body::payload : dsp::Body::relative;
  const dsp::SignalInfo& other = dsp::motion_signal(twin, info->order);
  if (prepared.channel(other.role) != nullptr) return {{std::string(other.name), 0, 1.0}};
  parts = integrated_from(twin);
  return parts.empty() ? std::vector<Part>{{signal, 0, 1.0}} : parts;
}

double ChannelNoise::covariance(const std::string& one, const std::string& other, bool known, double to_hz) const {
  const auto a = parts_.find(one), b = parts_.find(other);
  if (a == parts_.end() || b == parts_.end()) return 0.0;
  double sum = 0.0;
  for (const Part& p : a->second)
    for (const Part& q : b->second) {
      if (p.channel != q.channel || (p.order - q.order) % 2 != 0) continue;
      const NoiseDensity& density = density_.at(p.channel);
      if (known && density.is_bound) continue;
      // Derivatives of order p and q of one white noise: the integral of (i w)^p conj((i w)^q).
      const double turn = (p.order - q.order) % 4 == 0 ? 1.0 : -1.0;
      const int power = p.order + q.order;
      sum +=
          p.sign * q.sign * turn * density.value * std::pow(2.0 * std::numbers::pi, power) * integral_of(power, to_hz);
    }
  return sum;
}

double ChannelNoise::integral_of(int power, double to_hz) const {
  const double from_hz = integrated_from_hz_;
  const auto below = [&](double f_hz) { return std::pow(f_hz, power + 1) / (power + 1); };  // powers are even
  if (from_hz == 0.0) return below(to_hz);
  double sum = below(std::max(from_hz, to_hz)) - below(from_hz);
  const dsp::SpectralBand drift{0.5 * from_hz, from_hz};
  constexpr int steps = 64;  // of a smooth rise from 0 to 1
  const double step_hz = 0.5 * from_hz / steps;
  for (int k = 0; k < steps; ++k) {
    const double f_hz = 0.5 * from_hz + (k + 0.5) * step_hz;
    sum += std::pow(1.0 - drift.gain(f_hz), 2) * std::pow(f_hz, power) * step_hz;
  }
  return sum;
}

}  // namespace ident
