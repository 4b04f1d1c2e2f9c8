#include "dsp/regimes/steady_steps.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "dsp/filter/strongest_line.hpp"
#include "dsp/regimes/harmonics.hpp"
#include "dsp/values/constants.hpp"
#include "dsp/values/linear.hpp"
#include "dsp/values/order_statistics.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Complex = std::complex<double>;

constexpr int drive_harmonics = 3, response_harmonics = static_cast<int>(2.0 * num_harmonics);

constexpr double window_periods = 6.0;  // of the record's strongest frequency: a window is judged as a whole
constexpr double as_wanted = 0.01;      // what a drive, or a response, is off by and still as it should be
constexpr std::size_t fewest = 3;       // windows that show a setting, frequencies that show a test
// A setting is held if it stays so over a window; in frequency, and in each part of the waveform.
constexpr double held = as_wanted / window_periods;

/// signal = mean + Re sum_h z_h e^{2 pi i h f t}, t from the start of the record.
struct Harmonics {
  std::vector<Complex> z;
  double residual = 0.0;  ///< rms of what is left
  Index num_rows = 0;
};

/// Least squares on samples [first, last), on about forty a period where there are more. Over a period and more sines
/// are nearly orthogonal, so the normal equations lose nothing; the turn of one row to the next is multiplied up.
Harmonics fit_harmonics(const VectorXd& signal, Index first, Index last, double rate_hz, double f, int count) {
  const Index stride = std::max<Index>(1, static_cast<Index>(rate_hz / (40.0 * f)));
  const Index n = (last - first + stride - 1) / stride;
  Eigen::MatrixXd columns(n, 2 * count + 1);
  VectorXd values(n);
  const auto turned = [&](Index samples) {
    return std::polar(1.0, two_pi * std::fmod(f * static_cast<double>(samples) / rate_hz, 1.0));
  };
  const Complex per_row = turned(stride);
  Complex turn = turned(first);
  for (Index i = 0; i < n; ++i, turn *= per_row) {
    Complex power = 1.0;
    values[i] = signal[first + i * stride];
    columns(i, 0) = 1.0;
    for (int h = 1; h <= count; ++h) {
      power *= turn;
      columns(i, 2 * h - 1) = power.real();
      columns(i, 2 * h) = -power.imag();
    }
  }
  const Eigen::MatrixXd normal = columns.transpose().lazyProduct(columns);
  const VectorXd c = solve_symmetric(normal, columns.transpose() * values);
  Harmonics fit;
  for (int h = 1; h <= count; ++h) fit.z.emplace_back(c[2 * h - 1], c[2 * h]);
  fit.residual = std::sqrt((values - columns * c).squaredNorm() / static_cast<double>(n));
  fit.num_rows = n;
  return fit;
}

/// A period of a waveform, or of its speed per radian, at points evenly spread.
VectorXd period_of(const std::vector<Complex>& z, bool speed = false) {
  constexpr Index points = 720;
  static const Eigen::VectorXcd turns = Eigen::VectorXcd::NullaryExpr(
      points, [](Index i) { return std::polar(1.0, two_pi * static_cast<double>(i) / points); });
  VectorXd values = VectorXd::Zero(points);
  for (std::size_t k = 0; k < z.size(); ++k) {
    const auto h = static_cast<Index>(k + 1);
    const Complex factor = speed ? Complex(0.0, static_cast<double>(h)) * z[k] : z[k];
    for (Index i = 0; i < points; ++i) values[i] += (factor * turns[h * i % points]).real();
  }
  return values;
}

/// Half of max - min.
double amplitude_of(const VectorXd& period) {
  return 0.5 * (period.maxCoeff() - period.minCoeff());
}

/// Whether it is as good as at rest, as far as its harmonics tell, for twice as long as a sine.
bool rests(const std::vector<Complex>& z) {
  constexpr double slow = 1.0 / response_harmonics;
  const VectorXd speed = period_of(z, true).cwiseAbs();
  const double of_sine = 2.0 / std::numbers::pi * std::asin(slow);
  return (speed.array() < slow * speed.maxCoeff()).cast<double>().mean() > 2.0 * of_sine;
}

/// An interval of the drive judged as a whole.
struct Window {
  Index first = 0, last = 0;
  double frequency_hz = nan, noise = 0.0;  ///< NaN: no sine; noise: standard deviation of a relative amplitude
};

/// Frequency of a window from the phases of its halves, starting from a guess; NaN if that does not settle.
double window_frequency(const VectorXd& drive, Index first, Index last, double rate_hz, double f) {
  const Index middle = (first + last) / 2;
  const double apart_s = 0.5 * static_cast<double>(last - first) / rate_hz;
  for (int i = 0; i < 6; ++i) {
    const Complex before = fit_harmonics(drive, first, middle, rate_hz, f, drive_harmonics).z[0],
                  after = fit_harmonics(drive, middle, last, rate_hz, f, drive_harmonics).z[0];
    const double change = std::arg(after * std::conj(before)) / (two_pi * apart_s);
    f += change;
    if (!(f * apart_s > 1.0 && f * drive_harmonics < 0.5 * rate_hz)) return nan;
    if (std::abs(change) < 1e-6 * f) return f;
  }
  return nan;
}

std::vector<Window> windows_of(const VectorXd& drive, double rate_hz) {
  const double typical_hz = strongest_line(drive, rate_hz).frequency_hz;
  const auto length = static_cast<Index>(std::llround(window_periods * rate_hz / typical_hz));
  const Index hop = std::max<Index>(length / 8, 1);
  const double largest = 0.5 * (drive.maxCoeff() - drive.minCoeff());
  std::vector<Window> windows;
  double guess = typical_hz;
  for (Index first = 0; first + length <= drive.size() && length >= 4 * (2 * drive_harmonics + 1); first += hop) {
    Window window{first, first + length, nan, 0.0};
    const SpectralLine line = strongest_line(drive.segment(first, length), rate_hz);
    for (const double start : {guess, line.frequency_hz}) {
      if (line.fraction < 0.5) break;  // no sine: spare the fits
      const double f = window_frequency(drive, window.first, window.last, rate_hz, start);
      if (std::isnan(f)) continue;
      const Harmonics fit = fit_harmonics(drive, window.first, window.last, rate_hz, f, drive_harmonics);
      const double amplitude = std::abs(fit.z[0]);
      if (amplitude < sensors_agree * largest || fit.residual > sensors_agree * amplitude) continue;
      window.frequency_hz = guess = f;
      window.noise = fit.residual * std::sqrt(2.0 / static_cast<double>(fit.num_rows)) / amplitude;
      break;
    }
    windows.push_back(window);
  }
  return windows;
}

/// Windows [first, last) that belong together.
struct Run {
  std::size_t first = 0, last = 0;
};

/// Runs in which `distance(k, run)` of every window to those before it stays small; shorter ones are dropped.
template <class Belongs>
std::vector<Run> runs_of(std::size_t begin, std::size_t end, std::size_t min_count, const Belongs& belongs) {
  std::vector<Run> runs;
  for (std::size_t first = begin; first < end;) {
    std::size_t last = first + 1;
    while (last < end && belongs(first, last)) ++last;
    if (last - first >= min_count)
      runs.push_back({first, last});
    else
      last = first + 1;
    first = last;
  }
  return runs;
}

class Finder {
 public:
  explicit Finder(const Motion& motion)
      : motion_(motion),
        rate_hz_(motion.sample_rate_hz),
        base_(motion.find("r")),
        drive_(base_ != nullptr ? base_ : motion.find("f")) {}

  [[nodiscard]] std::vector<SteadyStep> find() {
    if (drive_ == nullptr || drive_->values.size() < 64 || !drive_->values.allFinite()) return {};
    windows_ = windows_of(drive_->values, rate_hz_);
    std::vector<double> noises;
    for (const Window& window : windows_)
      if (std::isfinite(window.frequency_hz)) noises.push_back(window.noise);
    if (noises.empty()) return {};
    noise_ = median(noises);  // of one window alone it would hide the transition that spoils it
    const auto plateaus = runs_of(0, windows_.size(), 2 * fewest, [&](std::size_t first, std::size_t k) {
      double mean = 0.0;
      for (std::size_t i = first; i < k; ++i) mean += windows_[i].frequency_hz / static_cast<double>(k - first);
      // A phase known to noise_ radians at either end of a window: so many turns lie between.
      const double tolerance = std::max(held, noise_stds * noise_ / window_periods);
      return std::abs(windows_[k].frequency_hz - mean) <= tolerance * mean;  // false for NaN
    });
    if (plateaus.size() < fewest) return {};
    std::vector<SteadyStep> steps;
    for (const Run& plateau : plateaus) add_settings(plateau, steps);
    tag_drive(steps);
    tell_directions(steps);
    return steps;
  }

 private:
  /// Amplitude and harmonics of the drive, free of its phase.
  [[nodiscard]] Eigen::Matrix<double, 5, 1> waveform(const Window& window, double f) const {
    const auto z = fit_harmonics(drive_->values, window.first, window.last, rate_hz_, f, drive_harmonics).z;
    const Complex turn = std::conj(z[0]) / std::abs(z[0]);
    const Complex second = z[1] * turn * turn, third = z[2] * turn * turn * turn;
    return {std::abs(z[0]), second.real(), second.imag(), third.real(), third.imag()};
  }

  /// The settings of the drive within one plateau of frequency, each with its response.
  void add_settings(const Run& plateau, std::vector<SteadyStep>& steps) const {
    double f = 0.0;
    for (std::size_t k = plateau.first; k < plateau.last; ++k)
      f += windows_[k].frequency_hz / static_cast<double>(plateau.last - plateau.first);
    std::vector<Eigen::Matrix<double, 5, 1>> waves;
    for (std::size_t k = plateau.first; k < plateau.last; ++k) waves.push_back(waveform(windows_[k], f));
    const auto settings = runs_of(0, waves.size(), fewest, [&](std::size_t first, std::size_t k) {
      Eigen::Matrix<double, 5, 1> mean = Eigen::Matrix<double, 5, 1>::Zero();
      for (std::size_t i = first; i < k; ++i) mean += waves[i] / static_cast<double>(k - first);
      const double tolerance = std::max(held, noise_stds * std::sqrt(5.0) * noise_);
      return (waves[k] - mean).norm() <= tolerance * mean[0];
    });
    for (const Run& setting : settings) {
      const Window &begin = windows_[plateau.first + setting.first], &end = windows_[plateau.first + setting.last - 1];
      // A window may reach into the next transition by what its tolerance hides: a sixteenth is given up.
      const Index margin = (end.last - end.first) / 16;
      steps.push_back(measured(begin.first + margin, end.last - margin, f));
      if (&setting != &settings.back() && steps.back().tag != StepTag::disturbed) steps.back().tag = StepTag::iteration;
    }
  }

  [[nodiscard]] SteadyStep measured(Index begin, Index end, double f) const {
    const Index first = begin + (end - begin) * 2 / 5;  // the earlier part is left to the response to settle
    const VectorXd& x = motion_.at("x");
    const int count = std::max(1, std::min(response_harmonics, static_cast<int>(0.45 * rate_hz_ / f)));
    const Harmonics drive = fit_harmonics(drive_->values, first, end, rate_hz_, f, drive_harmonics);
    const Harmonics response = fit_harmonics(x, first, end, rate_hz_, f, count);
    SteadyStep step{.from_s = static_cast<double>(first) / rate_hz_,
                    .to_s = static_cast<double>(end) / rate_hz_,
                    .frequency_hz = f,
                    .drive = std::abs(drive.z[0])};
    step.drive_distortion = std::hypot(std::abs(drive.z[1]), std::abs(drive.z[2])) / step.drive;
    const VectorXd x_period = period_of(response.z);
    step.x_m = amplitude_of(x_period);
    const Signal* y = motion_.find("y");
    step.y_m = y != nullptr       ? amplitude_of(period_of(fit_harmonics(y->values, first, end, rate_hz_, f, count).z))
               : base_ != nullptr ? amplitude_of(x_period + period_of(drive.z))
                                  : nan;
    step.locked = base_ != nullptr && step.x_m < sensors_agree * step.drive;
    step.phase_rad = step.locked ? nan : std::arg(response.z[0] / drive.z[0]);
    if (step.locked) return mark_unusable(step, first, end);
    step.stops = rests(response.z);
    const Index middle = (first + end) / 2;
    const double before = std::abs(fit_harmonics(x, first, middle, rate_hz_, f, count).z[0]),
                 after = std::abs(fit_harmonics(x, middle, end, rate_hz_, f, count).z[0]);
    if (std::abs(after - before) > as_wanted * std::max(after, before)) step.tag = StepTag::unsettled;
    return mark_unusable(step, first, end);
  }

  [[nodiscard]] SteadyStep mark_unusable(SteadyStep step, Index first, Index end) const {
    if (!motion_.excluded.empty() && std::any_of(motion_.excluded.begin() + first, motion_.excluded.begin() + end,
                                                 [](auto bad) { return bad != 0; }))
      step.tag = StepTag::disturbed;
    return step;
  }

  void tag_drive(std::vector<SteadyStep>& steps) const {
    std::vector<double> amplitudes;
    for (const SteadyStep& step : steps)
      if (step.tag == StepTag::final) amplitudes.push_back(step.drive);
    if (amplitudes.empty()) return;
    const double wanted = median(amplitudes);
    for (SteadyStep& step : steps) {
      if (step.tag != StepTag::final) continue;
      if (std::abs(step.drive - wanted) > as_wanted * wanted) step.tag = StepTag::off_amplitude;
      if (step.drive_distortion > as_wanted) step.tag = StepTag::distorted;
    }
  }

  static void tell_directions(std::vector<SteadyStep>& steps) {
    const auto towards = [](const SteadyStep& a, const SteadyStep& b) {
      const double change = b.frequency_hz / a.frequency_hz - 1.0;
      return change > held ? 1 : change < -held ? -1 : 0;
    };
    for (std::size_t k = 1; k < steps.size(); ++k) {
      steps[k].direction = towards(steps[k - 1], steps[k]);
      if (steps[k].direction == 0) steps[k].direction = steps[k - 1].direction;
    }
    for (std::size_t k = steps.size() - 1; k-- > 0;)  // the first step goes where the next went
      if (steps[k].direction == 0) steps[k].direction = steps[k + 1].direction;
  }

  const Motion& motion_;
  double rate_hz_;
  const Signal *base_, *drive_;
  std::vector<Window> windows_;
  double noise_ = 0.0;  ///< standard deviation of a relative amplitude of the drive in a window
};

}  // namespace

std::string_view to_string(StepTag tag) {
  constexpr std::string_view names[] = {"final", "iteration", "unsettled", "off_amplitude", "distorted", "disturbed"};
  return names[static_cast<int>(tag)];
}

std::vector<SteadyStep> find_steady_steps(const Motion& motion) {
  (void)motion.at("x");
  return Finder(motion).find();
}

}  // namespace dsp
