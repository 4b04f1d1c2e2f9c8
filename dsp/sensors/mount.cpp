#include "dsp/sensors/mount.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "dsp/filter/short_low_pass.hpp"
#include "dsp/values/constants.hpp"
#include "dsp/values/linear.hpp"
#include "dsp/values/order_statistics.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct MotionNames {
  const char *relative, *base, *payload;
};
constexpr MotionNames motion_names[] = {{"x", "r", "y"}, {"v", "dr", "dy"}, {"a", "ddr", "ddy"}};

// What the half wave behind one reversal leaves once its smooth part is projected out of it.
struct HalfWave {
  MatrixXd smooth;  // orthonormal
  VectorXd rest;
};

struct Ringing {
  double frequency_hz = 0.0, damping = 0.0;
  double left = 1.0, usually_left = 1.0;  ///< fraction of power it does not explain: of all rests, of the median one
};

class HalfWaves {
 public:
  explicit HalfWaves(double sample_rate_hz) : sample_rate_hz_(sample_rate_hz) {}

  void add(const MatrixXd& smooth_columns, VectorXd acceleration) {
    HalfWave wave{Qr(smooth_columns).basis(), {}};
    acceleration -= wave.smooth * (wave.smooth.transpose() * acceleration);
    wave.rest = std::move(acceleration);
    waves_.push_back(std::move(wave));
  }

  [[nodiscard]] std::size_t size() const { return waves_.size(); }

  // Of what the median half wave leaves, as a fraction of its largest acceleration.
  [[nodiscard]] double usual_rms() const {
    std::vector<double> all;
    for (const HalfWave& wave : waves_)
      all.push_back(std::sqrt(wave.rest.squaredNorm() / static_cast<double>(wave.rest.size())));
    return quantile(std::move(all), 0.5);
  }

  // What a decaying cosine and sine, of its own phase and size in every half wave, leave of every stride-th one's
  // power.
  [[nodiscard]] VectorXd unexplained(double frequency_hz, double damping, std::size_t stride = 1) const {
    const double omega = 2.0 * pi * frequency_hz / sample_rate_hz_;
    const std::complex<double> step =
        std::exp(std::complex<double>(-damping * omega, omega * std::sqrt(1.0 - damping * damping)));
    VectorXd left(static_cast<Index>((waves_.size() + stride - 1) / stride));
    for (std::size_t k = 0; k < waves_.size(); k += stride) {
      const HalfWave& wave = waves_[k];
      MatrixXd ring(wave.rest.size(), 2);
      std::complex<double> now = 1.0;
      for (Index i = 0; i < ring.rows(); ++i, now *= step) ring(i, 0) = now.real(), ring(i, 1) = now.imag();
      ring -= (wave.smooth * (wave.smooth.transpose() * ring)).eval();
      const Eigen::Matrix2d square = ring.transpose() * ring;
      const Eigen::Vector2d product = ring.transpose() * wave.rest;
      left(static_cast<Index>(k / stride)) = wave.rest.squaredNorm() - product.dot(solve_symmetric(square, product));
    }
    return left;
  }

  [[nodiscard]] Ringing with(double frequency_hz, double damping, std::size_t stride) const {
    const VectorXd unexplained_power = unexplained(frequency_hz, damping, stride);
    double left = 0.0, all = 0.0;
    std::vector<double> fractions;
    for (std::size_t k = 0; k < waves_.size(); k += stride) {
      const double power = waves_[k].rest.squaredNorm(),
                   unexplained_here = unexplained_power(static_cast<Index>(k / stride));
      left += unexplained_here;
      all += power;
      fractions.push_back(power > 0.0 ? unexplained_here / power : 1.0);
    }
    return {frequency_hz, damping, all > 0.0 ? left / all : 1.0, quantile(std::move(fractions), 0.5)};
  }

  // Of frequency and damping at the least of what is left, from how the half waves' slopes scatter there.
  [[nodiscard]] Eigen::Vector2d stds(const Ringing& best) const {
    constexpr double step = 0.01;  // of the frequency, and of damping: within the curvature
    const auto at = [&](double along, double across) {
      return unexplained(best.frequency_hz * (1.0 + along), best.damping + across);
    };
    const VectorXd here = at(0, 0), up = at(step, 0), down = at(-step, 0), more = at(0, step), less = at(0, -step);
    Eigen::Matrix2d curvature;
    curvature(0, 0) = (up + down - 2.0 * here).sum();
    curvature(1, 1) = (more + less - 2.0 * here).sum();
    curvature(0, 1) = curvature(1, 0) =
        0.25 * (at(step, step) + at(-step, -step) - at(step, -step) - at(-step, step)).sum();
    Eigen::MatrixX2d slopes(here.size(), 2);
    slopes << 0.5 * (up - down), 0.5 * (more - less);
    const Eigen::Matrix2d inverse = inverse_of(curvature);
    const Eigen::Matrix2d covariance = inverse * (slopes.transpose() * slopes) * inverse;
    return step * covariance.diagonal().cwiseSqrt().cwiseProduct(Eigen::Vector2d(best.frequency_hz, 1.0));
  }

 private:
  double sample_rate_hz_;
  std::vector<HalfWave> waves_;
};

struct Candidate {
  Index reversal, gap;
  double level;  // largest acceleration about it
};

// Half waves of usual length and of small accelerations, in which friction's leap counts for most.
std::vector<Candidate> choose(const VectorXd& a, const std::vector<Index>& reversal_indices, Index period) {
  std::vector<Candidate> all;
  std::vector<double> levels;
  for (std::size_t k = 0; k + 1 < reversal_indices.size(); ++k) {
    const Index gap = reversal_indices[k + 1] - reversal_indices[k], about = period / 4;
    if (5 * gap > 6 * period || 10 * gap < 3 * period || reversal_indices[k] < about ||
        reversal_indices[k] + about >= a.size())
      continue;
    all.push_back(
        {reversal_indices[k], gap, a.segment(reversal_indices[k] - about, 2 * about + 1).cwiseAbs().maxCoeff()});
    levels.push_back(all.back().level);
  }
  const double largest = quantile(levels, 0.95);
  std::erase_if(levels, [&](double level) { return level <= 0.05 * largest; });
  const double middle = quantile(levels, 0.5);
  std::erase_if(all, [&](const Candidate& c) { return c.level <= 0.05 * largest || c.level > middle; });
  return drawn_evenly(all, 120);
}

HalfWaves half_waves(const Motion& motion, const VectorXd& v, const std::vector<Index>& reversal_indices,
                     double cutoff_hz, Index period) {
  const VectorXd &a = motion.at("a"), &x = motion.at("x");
  const Signal* base = motion.find("ddr");
  const ShortLowPass low_pass(cutoff_hz, motion.sample_rate_hz);
  HalfWaves waves(motion.sample_rate_hz);
  const Index from = std::max<Index>(3, std::lround(0.07 * static_cast<double>(period)));  // the leap is over
  for (const Candidate& c : choose(a, reversal_indices, period)) {
    const Index to = std::min(c.gap * 17 / 20, period * 7 / 10), first = c.reversal + from, count = to - from;
    if (count < 15 || first < low_pass.reach() || c.reversal + to + low_pass.reach() >= a.size()) continue;
    VectorXd acceleration = low_pass(a, first, count), position = low_pass(x, first, count);
    position.array() -= position.mean();
    position /= std::max(position.cwiseAbs().maxCoeff(), 1e-300);
    MatrixXd smooth(count, base != nullptr ? 6 : 5);
    smooth.col(0).setOnes();
    smooth.col(1) = position;
    smooth.col(2) = position.cwiseAbs2();
    smooth.col(3) = smooth.col(2).cwiseProduct(position);
    smooth.col(4) = v.segment(first, count);
    if (base != nullptr) {
      smooth.col(5) = low_pass(base->values, first, count);
      acceleration += smooth.col(5);
    }
    waves.add(smooth, acceleration / c.level);
  }
  return waves;
}

std::complex<double> error_response(const Mount& mount, double f) {
  const std::complex<double> s(0.0, 2.0 * pi * f);
  const double omega = 2.0 * pi * mount.frequency_hz;
  return -s * s / (2.0 * mount.damping * omega * s + omega * omega);  // 1 - 1 / response
}

// Its derivative with respect to a parameter.
std::complex<double> error_slope(const Mount& mount, MountParameter parameter, double f) {
  const std::complex<double> s(0.0, 2.0 * pi * f);
  const double omega = 2.0 * pi * mount.frequency_hz;
  const std::complex<double> denominator = 2.0 * mount.damping * omega * s + omega * omega,
                             slope = parameter == MountParameter::damping
                                         ? 2.0 * omega * s
                                         : 2.0 * pi * (2.0 * mount.damping * s + 2.0 * omega);
  return s * s * slope / (denominator * denominator);
}

}  // namespace

Mount find_mount(const Motion& motion, const VectorXd& v, const std::vector<Index>& reversal_indices, double cutoff_hz,
                 Index samples_per_period) {
  const HalfWaves waves = half_waves(motion, v, reversal_indices, cutoff_hz, samples_per_period);
  constexpr std::size_t fewest = 10, looked_at_first = 40;
  if (waves.size() < fewest) return {};
  const double per_period_hz = motion.sample_rate_hz / static_cast<double>(samples_per_period);
  const std::size_t stride = std::max<std::size_t>(1, waves.size() / looked_at_first);
  Ringing best;
  for (double number = 4.5; number <= 18.0; number += 0.5)
    for (const double damping : {0.03, 0.1, 0.25})
      if (const Ringing here = waves.with(number * per_period_hz, damping, stride); here.left < best.left) best = here;
  constexpr double at_first = 0.5, at_last = 0.3, most_damping = 0.35, least_size = 0.01;
  if (best.left > at_first) return {};

  best = waves.with(best.frequency_hz, best.damping, 1);
  for (double by = 0.04; by > 1e-3; by /= 2.0)  // a step of damping counts as much as one of frequency
    for (bool moved = true; moved;) {
      moved = false;
      for (const auto& [along, across] : {std::pair{by, 0.0}, {-by, 0.0}, {0.0, by}, {0.0, -by}}) {
        const double damping = best.damping + across;
        if (damping < 0.005 || damping > most_damping) continue;
        const Ringing here = waves.with(best.frequency_hz * (1.0 + along), damping, 1);
        if (here.left < best.left) best = here, moved = true;
      }
    }
  const double number = best.frequency_hz / per_period_hz;
  if (best.usually_left > at_last || number < 4.5 || number > 18.0 || best.damping + 0.01 > most_damping ||
      waves.usual_rms() < least_size)
    return {};
  const Eigen::Vector2d stds = waves.stds(best);
  return {best.frequency_hz, best.damping, stds(0), stds(1)};
}

VectorXd payload_signal(const Motion& motion, int order) {
  const MotionNames& names = motion_names[order];
  if (const Signal* base = motion.find(names.base)) return motion.at(names.relative) + base->values;
  return motion.at(names.relative);
}

void undo_mount(Motion& motion, const Mount& mount, const SpectralBand& band) {
  for (int order = 0; order < 3; ++order) {
    const MotionNames& names = motion_names[order];
    if (motion.find(names.relative) == nullptr) continue;
    ExtendedSpectrum spectrum(payload_signal(motion, order), motion.sample_rate_hz);
    spectrum.multiply([&](double f) { return -band.gain(f) * error_response(mount, f); });
    const VectorXd change = std::move(spectrum).signal();
    for (Signal& signal : motion.signals)
      if (signal.name == names.relative || signal.name == names.payload) signal.values += change;
  }
}

VectorXd mount_sensitivity(const VectorXd& undone, double sample_rate_hz, const Mount& mount, MountParameter parameter,
                           const SpectralBand& band) {
  ExtendedSpectrum spectrum(undone, sample_rate_hz);
  spectrum.multiply([&](double f) {
    return -band.gain(f) * error_slope(mount, parameter, f) / (1.0 - band.gain(f) * error_response(mount, f));
  });
  return std::move(spectrum).signal();
}

}  // namespace dsp
