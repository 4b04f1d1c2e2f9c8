#include "dsp/prepare/motion_band.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "dsp/io/channel_bodies.hpp"
#include "dsp/io/read_recording.hpp"
#include "dsp/samples/hold_length.hpp"
#include "dsp/sensors/motion.hpp"
#include "dsp/values/signals.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double rate_to_cutoff = 2.5;  // 25.6 Hz for 10.24 Hz
constexpr Index least_bin = 3;          // below lies what Hann's window leaves of a mean and a trend

/// Which columns of a recording make the motion.
struct MotionSource {
  std::string signal;
  int order = 0;
  Index plus = -1, minus = -1;  // columns; minus -1: none
};

MotionSource motion_source(const Recording& description) {
  for (int order = 0; order < 3; ++order) {
    const auto column = [&](Body body) { return description.find(motion_signal(body, order).role); };
    const auto name = [&](Body body) { return std::string(motion_signal(body, order).name); };
    const Index x = column(Body::relative), y = column(Body::payload), r = column(Body::base);
    if (x >= 0) return {name(Body::relative), order, x, -1};
    if (y >= 0 && r >= 0) return {fmt::format("{} - {}", name(Body::payload), name(Body::base)), order, y, r};
    if (y >= 0) return {name(Body::payload), order, y, -1};
  }
  return {};
}

/// The density times f^power, bins below least_bin left out.
VectorXd weighted(const VectorXd& density, double bin_hz, double power) {
  VectorXd result = density;
  for (Index k = 0; k < result.size(); ++k)
    result(k) *= k < least_bin ? 0.0 : std::pow(bin_hz * static_cast<double>(k), power);
  return result;
}

Index argmax(const VectorXd& values) {
  Index at = 0;
  values.maxCoeff(&at);
  return at;
}

/// Means of a spectrum over windows a twelfth of an octave apart.
class Smoothed {
 public:
  /// `around_hz`: windows reach so far at least, which holds two harmonics of a motion.
  Smoothed(const VectorXd& spectrum, double bin_hz, double around_hz) : bin_hz_(bin_hz), around_hz_(around_hz) {
    sums_.resize(spectrum.size() + 1);
    sums_(0) = 0.0;
    for (Index k = 0; k < spectrum.size(); ++k) sums_(k + 1) = sums_(k) + spectrum(k);
  }
  [[nodiscard]] double half_width_hz(double f_hz) const {
    static const double sixth = std::exp2(1.0 / 6.0) - 1.0;
    return std::max(around_hz_, sixth * f_hz);
  }
  [[nodiscard]] double at(double f_hz) const {
    const double half = half_width_hz(f_hz);
    const auto last = static_cast<double>(sums_.size() - 2);
    const auto from = static_cast<Index>(std::clamp((f_hz - half) / bin_hz_, static_cast<double>(least_bin), last));
    const auto to = static_cast<Index>(std::clamp((f_hz + half) / bin_hz_, static_cast<double>(from), last)) + 1;
    return (sums_(to) - sums_(from)) / static_cast<double>(to - from);
  }

 private:
  double bin_hz_, around_hz_;
  VectorXd sums_;
};

/// Where the smoothed spectrum is least between two frequencies; `end` if it still falls there.
double valley_hz(const Smoothed& spectrum, double from_hz, double end_hz) {
  static const double step = std::exp2(1.0 / 12.0);
  double least = INFINITY, at_hz = from_hz, last_hz = from_hz;
  for (double f_hz = from_hz; f_hz + 0.5 * spectrum.half_width_hz(f_hz) <= end_hz; f_hz *= step) {
    last_hz = f_hz;
    if (const double value = spectrum.at(f_hz); value < least) least = value, at_hz = f_hz;
  }
  return at_hz == last_hz ? end_hz : at_hz;
}

/// Up to where letting more in wins more of the motion than noise of this density, from `from_hz` on: a tone beyond a
/// gap is motion, too.
double reach_hz(const VectorXd& spectrum, double bin_hz, double noise, double power, double from_hz) {
  double won = 0.0, most = 0.0, at_hz = from_hz;
  for (auto k = static_cast<Index>(from_hz / bin_hz) + 1; k < spectrum.size(); ++k) {
    const double f_hz = bin_hz * static_cast<double>(k);
    won += spectrum(k) - 2.0 * noise * std::pow(f_hz, power);  // the motion there, less the noise
    if (won > most) most = won, at_hz = f_hz;
  }
  return at_hz;
}

/// Most of the velocity lies in bins that the window does not tell from a mean.
bool is_too_slow(const MotionBand& band) {
  const auto velocity = [&](Index k) {
    return band.density(k) * std::pow(static_cast<double>(k), 2.0 - 2.0 * band.order);
  };
  double slow = 0.0;
  for (Index k = 1; k < least_bin; ++k) slow = std::max(slow, velocity(k));
  constexpr double leakage = 10.0;  // under Hann's window a line puts no more than itself into a neighbouring bin
  return slow > leakage * velocity(std::max<Index>(least_bin, std::lround(band.peak_hz / band.bin_hz)));
}

/// The largest whole number up to `ratio` without a prime factor above 5, for which filters are short.
double smooth_divisor(double ratio) {
  for (auto divisor = static_cast<std::int64_t>(ratio); divisor > 1; --divisor) {
    std::int64_t rest = divisor;
    for (const int prime : {2, 3, 5})
      while (rest % prime == 0) rest /= prime;
    if (rest == 1) return static_cast<double>(divisor);
  }
  return 1.0;
}

}  // namespace

double MotionBand::kept_fraction(double cutoff_hz) const {
  const VectorXd motion = weighted((density.array() - noise).max(0.0), bin_hz, 4.0 - 2.0 * order);
  const auto bins_to = [&](double f_hz) {
    return std::min(static_cast<Index>(std::ceil(f_hz / bin_hz)) + 1, motion.size());
  };
  const double all = motion.head(bins_to(to_hz)).sum();
  return cutoff_hz >= to_hz || !(all > 0.0) ? 1.0 : motion.head(bins_to(cutoff_hz)).sum() / all;
}

MotionBand motion_band(std::string signal, int order, VectorXd density, double bin_hz) {
  MotionBand band{.signal = std::move(signal), .order = order, .bin_hz = bin_hz, .density = std::move(density)};
  constexpr double of_nyquist = 0.95;  // a recorder's own filter sets in above
  band.nyquist_hz = bin_hz * static_cast<double>(band.density.size() - 1);
  band.to_hz = band.nyquist_hz;
  const double end_hz = of_nyquist * band.nyquist_hz;
  // Of a displacement between slow drift, which rules it, and noise, which rules the velocity of a wide band.
  band.peak_hz = bin_hz * static_cast<double>(argmax(weighted(band.density, bin_hz, order == 0 ? 1.0 : 0.0)));
  if (!(band.peak_hz > 0.0)) return band;
  if (is_too_slow(band)) return {};
  const double derived = order == 2 ? 2.0 : 4.0 - 2.0 * order;
  const VectorXd of_acceleration = weighted(band.density, bin_hz, derived);
  constexpr double least_bins = 8.0;  // of noise: known to a quarter from one segment alone
  const Smoothed acceleration(of_acceleration, bin_hz, std::max(1.1 * band.peak_hz, least_bins * bin_hz));
  const double to_hz = valley_hz(acceleration, band.peak_hz, end_hz);
  if (to_hz < end_hz) {
    band.noise = acceleration.at(to_hz) / std::pow(to_hz, derived);
    band.to_hz = reach_hz(of_acceleration, bin_hz, band.noise, derived, to_hz);
  }
  if (order == 0) return band;
  const Smoothed displacement(weighted(band.density, bin_hz, -2.0 * order), bin_hz, bin_hz);
  // Where nothing rises towards 0 Hz there is no drift to be seen, and all that the spectrum resolves is motion.
  band.from_hz = std::min(valley_hz(displacement, least_bin * bin_hz, band.peak_hz), 0.5 * band.peak_hz);
  return band;
}

namespace {

constexpr Index frames_at_once = 16384;

/// Of a record too long for one spectrum: segments that resolve all that several of them show.
constexpr Index num_eighths = 8;

/// Segments for a record's motion, from its length and its samples alone: seconds would say something of their own
/// about a motion of a kilohertz. A quarter averages noise and still holds periods enough of most motions.
struct Segments {
  double usual_s = 0.0;  ///< a quarter of the record, or the longest that a spectrum takes
  double slow_s = 0.0;   ///< all of it, or an eighth where that is longer than a spectrum takes: for a slow motion
};

Segments segments_of(Index num_frames, double sample_rate_hz) {
  const double whole_s = static_cast<double>(num_frames) / sample_rate_hz;
  const double longest_s = static_cast<double>(RawSpectrum::longest_segment) / sample_rate_hz;
  return {std::min(0.25 * whole_s, longest_s), std::max(std::min(whole_s, longest_s), whole_s / num_eighths)};
}

/// Means of every so many values, which come in blocks of any size.
class Means {
 public:
  explicit Means(Index num_values) : num_values_(num_values) {}
  /// Those that these values complete.
  [[nodiscard]] VectorXd push(const VectorXd& values) {
    VectorXd means((count_ + values.size()) / num_values_);
    Index done = 0;
    for (const double value : values) {
      sum_ += value;
      if (++count_ < num_values_) continue;
      means(done++) = sum_ / static_cast<double>(num_values_);
      sum_ = 0.0;
      count_ = 0;
    }
    return means;
  }

 private:
  Index num_values_, count_ = 0;
  double sum_ = 0.0;
};

/// How many samples one mean is to be of, so that a segment is no more than a spectrum takes, and that means keep a
/// hundred harmonics of all that the usual segments do not resolve.
Index means_for(const Segments& segments, double rate_hz) {
  constexpr double num_harmonics = 100.0;
  const double kept_hz = num_harmonics * static_cast<double>(least_bin) / segments.usual_s;
  const double wanted = std::ceil(segments.slow_s * rate_hz / static_cast<double>(RawSpectrum::longest_segment));
  return static_cast<Index>(std::max(1.0, std::min(wanted, std::floor(0.5 * rate_hz / kept_hz))));
}

/// Of a channel that is slower than the clock what is below half its own rate: above are images.
VectorXd below_own_nyquist(const Eigen::Ref<const VectorXd>& power, double bin_hz, double rate_hz, int hold_samples) {
  const auto bins = static_cast<Index>(std::floor(0.5 * rate_hz / hold_samples / bin_hz)) + 1;
  return hold_samples > 1 ? power.head(std::min(bins, power.size())) : power;
}

/// Of means of `num_means` samples where that is more than one: white noise keeps its density in them, and what else
/// they fold is far above a slow motion.
MotionBand band_of_segments(RecordingReader reader, const MotionSource& source, double segment_s, Index num_means = 1) {
  constexpr int most_segments = 32;
  const double rate_hz = reader.description().sample_rate_hz;
  RawSpectrum spectrum(rate_hz / static_cast<double>(num_means), 1, static_cast<Index>(reader.num_frames()) / num_means,
                       most_segments, segment_s);
  Means means(num_means);
  HoldLength of_plus, of_minus;
  FrameBlock block;
  for (;;) {
    if (const Index idle = spectrum.num_idle(); num_means == 1 && idle > 0) {
      const Index skipped = reader.skip(idle);
      spectrum.skip(skipped);
      of_plus.restart(), of_minus.restart();
      if (skipped < idle) break;
      continue;
    }
    if (reader.read(block, frames_at_once) == 0) break;
    VectorXd motion = block.col(source.plus);
    for (const double value : motion) of_plus.push(value);
    if (source.minus >= 0) {
      for (Index i = 0; i < block.rows(); ++i) of_minus.push(block(i, source.minus));
      motion -= block.col(source.minus);
    }
    if (num_means > 1) motion = means.push(motion);
    spectrum.push(motion);
  }
  const Eigen::MatrixXd power = spectrum.power();
  if (power.rows() == 0) return {};
  const int hold_samples = std::max(of_plus.samples(), of_minus.samples());
  MotionBand band =
      motion_band(source.signal, source.order,
                  below_own_nyquist(power.col(0), spectrum.bin_hz(), rate_hz, hold_samples), spectrum.bin_hz());
  band.hold_samples = hold_samples;
  if (band.signal.empty()) return band;
  const double nyquist_hz = 0.5 * rate_hz / hold_samples;
  if (band.to_hz == band.nyquist_hz) band.to_hz = nyquist_hz;
  band.nyquist_hz = nyquist_hz;
  return band;
}

}  // namespace

MotionBand find_motion_band(const std::function<RecordingReader()>& open) {
  RecordingReader reader = open();
  require_one_body(reader.description());
  const MotionSource source = motion_source(reader.description());
  if (source.plus < 0) return {};
  const double rate_hz = reader.description().sample_rate_hz;
  const Segments segments = segments_of(static_cast<Index>(reader.num_frames()), rate_hz);
  MotionBand band = band_of_segments(std::move(reader), source, segments.usual_s);
  if (is_unresolved(band)) band = band_of_segments(open(), source, segments.slow_s, means_for(segments, rate_hz));
  return band;
}

bool is_unresolved(const MotionBand& band) {
  return band.signal.empty() || band.peak_hz < 2.0 * static_cast<double>(least_bin) * band.bin_hz;
}

double usual_segment_s(Index num_frames, double sample_rate_hz) {
  return segments_of(num_frames, sample_rate_hz).usual_s;
}

RawSpectrum spectrum_of_slow(const Recording& recording) {
  const Index n = recording.samples.rows();
  RawSpectrum spectrum(recording.sample_rate_hz, recording.samples.cols(), n, num_eighths,
                       segments_of(n, recording.sample_rate_hz).slow_s);
  for (Index first = 0; first < n; first += frames_at_once)
    spectrum.push(recording.samples.middleRows(first, std::min(frames_at_once, n - first)));
  return spectrum;
}

MotionBand motion_band_of_channels(const std::vector<Channel>& channels, const RawSpectrum& spectrum) {
  const MotionSource source = motion_source({.channels = channels});
  const Eigen::MatrixXd power = spectrum.power();
  if (source.plus < 0 || power.rows() == 0) return {};
  const Channel& channel = channels[static_cast<std::size_t>(source.plus)];
  const VectorXd density =
      below_own_nyquist(power.col(source.plus), spectrum.bin_hz(), spectrum.sample_rate_hz(), channel.hold_samples);
  MotionBand band = motion_band(channel.name, source.order, density, spectrum.bin_hz());
  band.hold_samples = channel.hold_samples;
  return band;
}

double integration_from_hz(const std::vector<Channel>& channels, const RawSpectrum& spectrum, double duration_s) {
  const double least_hz = integral_reach_periods / (most_lost_to_integral * duration_s);
  const Eigen::MatrixXd power = spectrum.power();
  const Recording description{.channels = channels};
  double from_hz = 0.0;
  for (const Body body : {Body::relative, Body::payload, Body::base}) {
    if (power.rows() == 0 || description.find(motion_signal(body, 0).role) >= 0) continue;
    for (const int order : {1, 2}) {
      const Index column = description.find(motion_signal(body, order).role);
      if (column < 0) continue;
      const MotionBand band = motion_band("", order, power.col(column), spectrum.bin_hz());
      from_hz = std::max(from_hz, std::min(std::max(band.from_hz, least_hz), 0.5 * band.peak_hz));
      break;
    }
  }
  return from_hz;
}

double cutoff_for(const MotionBand& band) {
  constexpr double cutoff_to_rolloff = 1.28;  // of 8 Hz: 10.24 Hz
  const double cutoff_hz = cutoff_to_rolloff * band.to_hz;
  if (band.signal.empty() || rate_to_cutoff * cutoff_hz >= 2.0 * band.nyquist_hz) return 0.0;
  return std::stod(fmt::format("{:.3g}", cutoff_hz));  // more digits are not known of it
}

PrepareOptions rate_by_cutoff(PrepareOptions options, double sample_rate_hz) {
  if (options.rate_hz > 0.0 || options.cutoff_hz == 0.0) return options;
  const double divisor = smooth_divisor(sample_rate_hz / (rate_to_cutoff * options.cutoff_hz));
  if (divisor > 1.0) options.rate_hz = sample_rate_hz / divisor;
  return options;
}

Check band_check(const MotionBand& band, double cutoff_hz) {
  constexpr double least_kept = 0.95;
  Check check{.name = "prepare.band", .value = band.kept_fraction(cutoff_hz), .limit = least_kept};
  const bool seen = band.to_hz < band.nyquist_hz;
  check.status = check.value < least_kept ? CheckStatus::warning : CheckStatus::note;
  check.message = fmt::format(
      "the band used ends at {:.4g} Hz and holds {:.3g} % of the power of the motion's "
      "acceleration ({})",
      cutoff_hz, 100.0 * check.value,
      seen ? fmt::format("noise apart, which exceeds the motion above {:.3g} Hz", band.to_hz)
           : "which is above its noise up to the end of the record's band");
  const double whole_hz = cutoff_for(band);  // 0: as far as the record goes
  if (check.value < least_kept)
    check.message += fmt::format(". For all of it set prepare.cutoff_hz = {:.3g} and leave rate_hz out",
                                 whole_hz > 0.0 ? whole_hz : 0.8 * band.nyquist_hz);
  return check;
}

}  // namespace dsp
