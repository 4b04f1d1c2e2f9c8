#include "dsp/sensors/sensor_consistency.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <functional>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include "dsp/sensors/band_windows.hpp"
#include "dsp/values/constants.hpp"
#include "dsp/values/for_each_index.hpp"
#include "dsp/values/linear.hpp"
#include "dsp/values/order_statistics.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Complex = std::complex<double>;

// The displacement's, made only where the record is long enough.
using SpectrumOf = std::function<const ExtendedSpectrum&()>;

// The measured ratio A / D'' and its weight, frequency by frequency.
struct Ratio {
  std::vector<double> frequency_hz, weight;
  std::vector<Complex> value;  // divided by sign and level
  double sign = 1.0, level = 1.0;
  int num_windows = 0;
};

using Response = std::function<Complex(double)>;

// D is differentiated, and given what the sensors are presumed to differ by, before it is cut into windows: a window
// smears each frequency over its neighbours, which does no harm only where the ratio is flat. Dividing spectra by f^2
// afterwards costs 1e-3 in gain; the slope of a coupling's phase, where motion lies between the window's frequencies,
// 40 us of lag. `A`: the acceleration's spectra.
Ratio measured_ratio(const SpectrumOf& displacement, const Eigen::MatrixXcd& A, const BandWindows& windows,
                     double rate_hz, const RelateOptions& options, const Response& presumed) {
  Ratio ratio;
  ratio.num_windows = static_cast<int>(windows.num_windows());
  if (ratio.num_windows == 0) return ratio;
  const double edge_hz = std::min(2.0 * options.to_hz, 0.4 * rate_hz);
  const SpectralBand band{edge_hz, 1.2 * edge_hz};
  const Eigen::MatrixXcd D = windows.spectra(displacement().filtered([&](double f) {
    const double gain = band.gain(f);
    return gain == 0.0 ? Complex(0.0) : -two_pi * f * two_pi * f * gain * presumed(f);
  }));
  double largest = 0.0;
  for (Index k = 0; k < D.rows(); ++k) {
    Complex cross = 0.0;
    double power = 0.0;
    for (Index i = 0; i < D.cols(); ++i) {
      cross += A(k, i) * std::conj(D(k, i));
      power += std::norm(D(k, i));
    }
    if (!(power > 0.0)) continue;
    const double f = windows.frequencies_hz()(k);
    ratio.frequency_hz.push_back(f);
    ratio.value.push_back(cross / power * presumed(f));
    ratio.weight.push_back(std::sqrt(power) / std::abs(presumed(f)));
    largest = std::max(largest, ratio.weight.back());
  }
  for (double& weight : ratio.weight) weight /= largest;
  return ratio;
}

void divide(Ratio& ratio, double sign, double level) {
  ratio.sign = sign;
  ratio.level = level;
  for (Complex& value : ratio.value) value /= sign * level;
}

// Divides the ratio by its sign and its level.
void normalise(Ratio& ratio) {
  double upright = 0.0, logs = 0.0, weights = 0.0;
  for (std::size_t i = 0; i < ratio.value.size(); ++i) {
    const double weight = ratio.weight[i] * ratio.weight[i];
    upright += weight * ratio.value[i].real();
    logs += weight * std::log(std::abs(ratio.value[i]));
    weights += weight;
  }
  divide(ratio, upright < 0.0 ? -1.0 : 1.0,
         weights > 0.0 && std::isfinite(logs) ? std::exp(logs / weights) : ratio.level);
}

// Parameters: log gain, lag, then log cut-offs; four at most.
class Model {
 public:
  using Slope = Eigen::Matrix<Complex, Eigen::Dynamic, 1, 0, 4, 1>;
  explicit Model(const VectorXd& p)
      : gain_(std::exp(p(0))), lag_s_(p(1)), cutoffs_hz_(p.tail(p.size() - 2).array().exp()) {}
  Complex operator()(double f) const {
    Complex value = std::polar(gain_, two_pi * f * lag_s_);
    for (const double cutoff_hz : cutoffs_hz_) value *= Complex(0.0, f) / Complex(cutoff_hz, f);
    return value;
  }
  // Derivatives of a value of the model by the parameters.
  Slope slope(double f, Complex value) const {
    Slope slope(2 + cutoffs_hz_.size());
    slope(0) = value;
    slope(1) = Complex(0.0, two_pi * f) * value;
    for (Index k = 0; k < cutoffs_hz_.size(); ++k) slope(2 + k) = -value * cutoffs_hz_(k) / Complex(cutoffs_hz_(k), f);
    return slope;
  }

 private:
  double gain_, lag_s_;
  Eigen::ArrayXd cutoffs_hz_;
};

struct Fitted {
  VectorXd p;
  MatrixXd covariance;
  double residual = 0.0, mean_error = 0.0, cost = std::numeric_limits<double>::infinity();
};

// Levenberg-Marquardt on sum rho(|e|^2), rho(z) = 2 (sqrt(1 + z / s^2) - 1) s^2, as reweighted least squares.
Fitted fit_from(const Ratio& ratio, const VectorXd& p, double scale) {
  const Index n = p.size();
  const auto cost = [&](const VectorXd& at) {
    const Model model(at);
    double sum = 0.0;
    for (std::size_t i = 0; i < ratio.value.size(); ++i) {
      const Complex e = ratio.weight[i] * (ratio.value[i] - model(ratio.frequency_hz[i]));
      sum += 2.0 * (std::sqrt(1.0 + std::norm(e) / (scale * scale)) - 1.0);
    }
    return sum;
  };
  Fitted best{.p = p, .covariance = {}, .cost = cost(p)};
  MatrixXd normal = MatrixXd::Zero(n, n);
  double damping = 1e-3, weighted = 0.0, weights = 0.0;
  for (int iteration = 0; iteration < 200 && damping < 1e12; ++iteration) {
    normal.setZero();
    VectorXd gradient = VectorXd::Zero(n);
    weighted = weights = 0.0;
    const Model model(best.p);
    for (std::size_t i = 0; i < ratio.value.size(); ++i) {
      const double f = ratio.frequency_hz[i];
      const Complex m = model(f), e = ratio.weight[i] * (ratio.value[i] - m);
      const double robust = 1.0 / std::sqrt(1.0 + std::norm(e) / (scale * scale));
      const Model::Slope slope = model.slope(f, ratio.weight[i] * m);
      normal += robust * (slope.conjugate() * slope.transpose()).real();
      gradient += robust * (slope.conjugate() * e).real();
      weighted += robust * std::norm(e);
      weights += robust;
    }
    MatrixXd damped = normal;
    damped.diagonal() *= 1.0 + damping;
    const VectorXd step = solve_symmetric(damped, gradient);
    const VectorXd next = best.p + step;
    const double next_cost = step.allFinite() ? cost(next) : std::numeric_limits<double>::infinity();
    if (next_cost < best.cost) {
      const bool settled = best.cost - next_cost < 1e-10 * best.cost;
      best.p = next;
      best.cost = next_cost;
      damping *= 0.2;
      if (settled) break;
    } else {
      damping *= 5.0;
    }
  }
  // A Hann window makes neighbouring bins share 1.5 bins' worth of information.
  const double noise = 1.5 * weighted / std::max(1.0, 2.0 * weights - static_cast<double>(n));
  best.covariance = noise * inverse_of_symmetric(normal);
  const Model model(best.p);
  double misfit = 0.0, size = 0.0, errors = 0.0;
  for (std::size_t i = 0; i < ratio.value.size(); ++i) {
    const double error = ratio.weight[i] * std::abs(ratio.value[i] - model(ratio.frequency_hz[i]));
    misfit += error * error;
    errors += ratio.weight[i] * error;
    size += std::norm(ratio.weight[i] * ratio.value[i]);
  }
  best.residual = std::sqrt(misfit / size);
  best.mean_error = errors / size;
  return best;
}

double median_error(const Ratio& ratio, const VectorXd& p) {
  const Model model(p);
  std::vector<double> errors;
  for (std::size_t i = 0; i < ratio.value.size(); ++i)
    errors.push_back(ratio.weight[i] * std::abs(ratio.value[i] - model(ratio.frequency_hz[i])));
  return std::max(median(std::move(errors)), 1e-12);
}

// Twice more with the median error as the scale of the soft L1.
Fitted robustly_from(const Ratio& ratio, Fitted start) {
  for (int round = 0; round < 2; ++round) start = fit_from(ratio, start.p, median_error(ratio, start.p));
  return start;
}

// With so many poles, from several cut-offs.
Fitted fit_poles(const Ratio& ratio, Index poles) {
  Fitted best;
  for (const double start_hz : {0.1, 0.4, 1.0}) {
    VectorXd p = VectorXd::Zero(2 + poles);
    for (Index k = 0; k < poles; ++k) p(2 + k) = std::log(start_hz * (1.0 + 0.5 * static_cast<double>(k)));
    Fitted fitted = fit_from(ratio, p, 0.1);
    if (best.p.size() == 0 || fitted.cost < best.cost) best = std::move(fitted);
    if (poles == 0) break;
  }
  return robustly_from(ratio, std::move(best));
}

SensorRelation related(const SpectrumOf& displacement, const Eigen::Ref<const VectorXd>& acceleration,
                       double sample_rate_hz, const std::vector<unsigned char>& excluded,
                       const RelateOptions& options) {
  SensorRelation relation;
  const BandWindows windows(acceleration.size(), sample_rate_hz, excluded, options.window_s, options.from_hz,
                            options.to_hz);
  const Eigen::MatrixXcd A = windows.spectra(acceleration);
  const auto measured = [&](const Response& presumed) {
    return measured_ratio(displacement, A, windows, sample_rate_hz, options, presumed);
  };
  Ratio ratio = measured([](double) { return Complex(1.0); });
  normalise(ratio);
  relation.num_windows = ratio.num_windows;
  if (ratio.num_windows < options.min_windows) {
    const double whole_s = static_cast<double>(acceleration.size()) / sample_rate_hz;
    const bool is_short =
        whole_s < 0.5 * options.window_s * static_cast<double>(options.min_windows + 1);  // they overlap
    relation.reason =
        (is_short ? "the record is too short: " : "too little of the record is without faulty samples: ") +
        std::to_string(ratio.num_windows) + " windows of " + std::to_string(static_cast<int>(options.window_s)) +
        " s, wanted " + std::to_string(options.min_windows);
    return relation;
  }
  // By the rms of the errors or, if that gets no worse, their mean: a few bins spoilt, by clipping that nobody found,
  // say, outweigh all others in the squares.
  Fitted best = fit_poles(ratio, 0);
  for (Index poles = 1; poles <= 2; ++poles) {
    Fitted more = fit_poles(ratio, poles);
    const double bar = 1.0 - options.pole_gain;
    if (more.residual < bar * best.residual ||
        (more.mean_error < bar * best.mean_error && more.residual < 1.1 * best.residual))
      best = std::move(more);
  }
  if (best.residual > 0.5) {
    relation.reason = "the two sensors do not describe one motion";
    relation.residual = best.residual;
    return relation;
  }
  // What is presumed is right to a few thousandths after the first of these, and the smear of the rest to 1e-5.
  constexpr int refinements = 3;
  for (int i = 0; i < refinements; ++i) {
    Ratio again = measured(Model(best.p));
    divide(again, ratio.sign, ratio.level);
    best = robustly_from(again, std::move(best));
  }
  const VectorXd std = best.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  relation.sign = ratio.sign;
  relation.gain = ratio.level * std::exp(best.p(0));
  relation.gain_std = relation.gain * std(0);
  relation.lag_s = best.p(1);
  relation.lag_std_s = std(1);
  for (Index k = 2; k < best.p.size(); ++k) {
    relation.highpass_hz.push_back(std::exp(best.p(k)));
    relation.highpass_std_hz.push_back(relation.highpass_hz.back() * std(k));
  }
  // d(sum of cut-offs) = sum of cut-off d(log cut-off)
  VectorXd slope = VectorXd::Zero(best.p.size());
  for (Index k = 2; k < best.p.size(); ++k) slope(k) = std::exp(best.p(k));
  relation.highpass_sum_std_hz = std::sqrt(std::max(0.0, slope.dot(best.covariance * slope)));
  relation.residual = best.residual;
  return relation;
}

}  // namespace

SensorRelation relate_sensors(const Eigen::Ref<const VectorXd>& displacement,
                              const Eigen::Ref<const VectorXd>& acceleration, double sample_rate_hz,
                              const std::vector<unsigned char>& excluded, const RelateOptions& options) {
  std::optional<ExtendedSpectrum> spectrum;
  return related([&]() -> const ExtendedSpectrum& { return spectrum.emplace(displacement, sample_rate_hz); },
                 acceleration, sample_rate_hz, excluded, options);
}

namespace {

struct Pair {
  const char* name;
  Role displacement, acceleration;
};
constexpr Pair derivative_pairs[] = {{"r and ddr", Role::r, Role::ddr}, {"y and ddy", Role::y, Role::ddy}};

SensorRelation relate_pair(ColumnSpectra& spectra, const Pair& pair, const std::vector<unsigned char>& excluded) {
  const Recording& recording = spectra.recording();
  const Index d = recording.find(pair.displacement), a = recording.find(pair.acceleration);
  SensorRelation relation = related([&]() -> const ExtendedSpectrum& { return spectra.of(d); },
                                    recording.samples.col(a), recording.sample_rate_hz, excluded, {});
  relation.name = pair.name;
  relation.displacement = recording.channels[static_cast<std::size_t>(d)].name;
  relation.acceleration = recording.channels[static_cast<std::size_t>(a)].name;
  relation.declared_hz = recording.channels[static_cast<std::size_t>(a)].highpass_hz;
  return relation;
}

bool has(const Recording& recording, const Pair& pair) {
  return recording.find(pair.displacement) >= 0 && recording.find(pair.acceleration) >= 0;
}

/// Brings the displacement of a pair to the accelerometer's clock, and both to one scale.
void bring_together(ColumnSpectra& spectra, const Pair& pair, const SensorRelation& relation, ScaleReference scale) {
  const Recording& recording = spectra.recording();
  const bool displacement_counts = scale == ScaleReference::displacement;
  const double lag_s = relation.lag_s, ratio = gain_is_plausible(relation) ? relation.gain : 1.0;
  const double gain = displacement_counts ? 1.0 : ratio;
  spectra.change(recording.find(pair.displacement)).multiply([&](double f) {
    return std::polar(gain, two_pi * f * lag_s);
  });
  if (displacement_counts)
    spectra.change(recording.find(pair.acceleration)).multiply([&](double) { return 1.0 / ratio; });
}

/// Relates the pairs that are there; `use(pair, relation)` is called for each on the thread that found it.
template <class Use>
std::vector<SensorRelation> relate_each(ColumnSpectra& spectra, const std::vector<unsigned char>& excluded,
                                        int num_threads, const Use& use) {
  std::array<std::optional<SensorRelation>, std::size(derivative_pairs)> found;
  for_each_index(found.size(), num_threads, [&](std::size_t i) {
    if (!has(spectra.recording(), derivative_pairs[i])) return;
    found[i] = relate_pair(spectra, derivative_pairs[i], excluded);
    use(derivative_pairs[i], *found[i]);
  });
  std::vector<SensorRelation> relations;
  for (std::optional<SensorRelation>& relation : found)
    if (relation) relations.push_back(std::move(*relation));
  return relations;
}

}  // namespace

std::vector<SensorRelation> relate_pairs(ColumnSpectra& spectra, const std::vector<unsigned char>& excluded,
                                         int num_threads) {
  return relate_each(spectra, excluded, num_threads, [](const Pair&, const SensorRelation&) {});
}

bool can_be_corrected(const SensorRelation& relation) {
  return relation.reason.empty() && relation.sign > 0.0;
}

bool gain_is_plausible(const SensorRelation& relation) {
  return std::abs(relation.gain - 1.0) <= largest_gain_error;
}

Equalised equalise_sensors(ColumnSpectra& spectra, const std::vector<unsigned char>& excluded, ScaleReference scale,
                           int num_threads) {
  const Recording& recording = spectra.recording();
  Equalised result;
  result.relations = relate_each(spectra, excluded, num_threads, [&](const Pair& pair, const SensorRelation& relation) {
    if (can_be_corrected(relation)) bring_together(spectra, pair, relation, scale);
  });
  std::optional<std::vector<double>> base_highpass;
  for (const SensorRelation& relation : result.relations) {
    // Without a relation, the cut-offs somebody wrote down.
    const auto& cutoffs = can_be_corrected(relation) ? relation.highpass_hz : relation.declared_hz;
    if (relation.name == derivative_pairs[0].name)
      base_highpass = cutoffs;
    else
      result.highpass_hz = cutoffs;
  }
  // The base acceleration takes on the payload's AC coupling; both lose what lies below any useful frequency.
  const auto& shared = result.highpass_hz;
  const bool coupled = !shared.empty() || (base_highpass && !base_highpass->empty());
  constexpr std::array accelerations{Role::ddr, Role::ddy};
  for_each_index(accelerations.size(), num_threads, [&](std::size_t i) {
    const Index a = recording.find(accelerations[i]);
    if (a < 0 || result.relations.empty() || !coupled) return;
    const std::vector<double>& own = accelerations[i] == Role::ddr && base_highpass ? *base_highpass : shared;
    spectra.change(a).multiply([&](double f) {
      constexpr double lowest_hz = 0.02;
      if (f < lowest_hz) return Complex(0.0);
      return own == shared ? Complex(1.0) : highpass_response(shared, f) / highpass_response(own, f);
    });
  });
  return result;
}

void restore_low_frequencies(ColumnSpectra& spectra, const std::vector<double>& highpass_hz, int num_threads) {
  if (highpass_hz.empty()) return;
  const double upper_hz = *std::max_element(highpass_hz.begin(), highpass_hz.end());
  // 1 where the displacement counts, 0 where the accelerometer does.
  const SpectralBand low{upper_hz / 2.0, upper_hz};
  for_each_index(std::size(derivative_pairs), num_threads, [&](std::size_t i) {
    const Index d = spectra.recording().find(derivative_pairs[i].displacement),
                a = spectra.recording().find(derivative_pairs[i].acceleration);
    if (d < 0 || a < 0) return;
    ExtendedSpectrum& whole = spectra.change(a);
    whole.multiply([&](double f) {
      return f <= low.rolloff_hz ? Complex(0.0) : (1.0 - low.gain(f)) / highpass_response(highpass_hz, f);
    });
    whole.add(spectra.of(d), [&](double f) { return -two_pi * f * two_pi * f * low.gain(f); });
  });
}

}  // namespace dsp
