#include "ident/validate/regressor_noise.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "dsp/filter/power_density.hpp"
#include "dsp/values/linear.hpp"
#include "ident/sensors/channel_noise.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t enough_samples = 2'000;  // samples, for means to a few per cent

/// A term's derivative with respect to one of its signals, on some samples.
struct TermSlope {
  Index term;
  std::string signal;
  VectorXd values;
};

std::vector<TermSlope> slopes_of(const Model& model, std::size_t recording, const dsp::Motion& motion) {
  std::vector<TermSlope> slopes;
  for (std::size_t i = 0; i < model.terms.size(); ++i) {
    const int own = model.terms[i].recording;
    if (own > 0 && static_cast<std::size_t>(own) != recording + 1) continue;
    const Expression term(model.terms[i].name);
    for (const std::string& signal : term.signals()) {
      if (signal == "t") continue;
      VectorXd values = term.derivative(signal).evaluate(motion);
      for (double& value : values)
        if (!std::isfinite(value)) value = 0.0;
      slopes.push_back({static_cast<Index>(i), signal, std::move(values)});
    }
  }
  return slopes;
}

/// Sums over rows: of the terms' noise with one another, and with the target's.
struct NoiseSums {
  MatrixXd noise;
  VectorXd shared;
  double target = 0.0;
  NoiseSums(Index k) : noise(MatrixXd::Zero(k, k)), shared(VectorXd::Zero(k)) {}
  void add(const std::vector<TermSlope>& slopes, const std::string& of_target, const ChannelNoise& of, double count,
           bool known, double to_hz) {
    target += count * of.covariance(of_target, of_target, known, to_hz);
    for (const TermSlope& one : slopes) {
      shared(one.term) += one.values.sum() * of.covariance(one.signal, of_target, known, to_hz);
      for (const TermSlope& other : slopes)
        if (const double both = of.covariance(one.signal, other.signal, known, to_hz); both != 0.0)
          noise(one.term, other.term) += one.values.dot(other.values) * both;
    }
  }
  [[nodiscard]] double of_residual(const VectorXd& beta) const {
    return std::max(0.0, target + beta.dot(noise * beta) - 2.0 * beta.dot(shared));
  }
};

/// Mean square of a series on rows of one recording, up to a frequency, by the spectra of stretches without a gap.
/// Nothing where all are too short for one.
std::optional<double> power_below(double to_hz, const Eigen::Ref<const VectorXd>& values, const std::vector<Row>& rows,
                                  std::size_t recording, double rate_hz) {
  constexpr double least = 16.0;  // ordinates below that frequency, beside which the window's reach is little
  double power = 0.0, num_rows = 0.0;
  for (Index first = 0, end = 0; first < std::ssize(rows); first = end) {
    end = end_of_stretch(rows, first, std::ssize(rows));
    const auto n = static_cast<double>(end - first);
    if (rows[static_cast<std::size_t>(first)].recording != recording || to_hz * n / rate_hz < least) continue;
    const dsp::PowerDensity density(Eigen::Ref<const VectorXd>(values.segment(first, end - first)), rate_hz);
    const VectorXd& ordinates = density.ordinates();
    const Index count = std::min(static_cast<Index>(to_hz / density.step_hz()) + 1, ordinates.size());
    power += n * density.step_hz() * ordinates.head(count).sum();
    num_rows += n;
  }
  if (num_rows == 0.0) return std::nullopt;
  return power / num_rows;
}

/// Variance of x over that of v; 0 where one is not there or v is at rest.
double square_of_x_over_v(const dsp::Motion& motion) {
  const dsp::Signal *x = motion.find("x"), *v = motion.find("v");
  if (x == nullptr || v == nullptr) return 0.0;
  const auto square = [](const VectorXd& values) { return (values.array() - values.mean()).square().sum(); };
  const double of_v = square(v->values);
  return of_v > 0.0 ? square(x->values) / of_v : 0.0;
}

/// Of a series on rows of one recording, in all frequencies.
double mean_square(const Eigen::Ref<const VectorXd>& values, const std::vector<Row>& rows, std::size_t recording) {
  double sum = 0.0, num_rows = 0.0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].recording != recording) continue;
    sum += values(static_cast<Index>(i)) * values(static_cast<Index>(i));
    num_rows += 1.0;
  }
  return sum / num_rows;
}

}  // namespace

RegressorNoise regressor_noise(const Model& model, const RFactor& kept, const std::vector<Row>& rows,
                               const std::vector<Columns>& recordings, const Eigen::Ref<const VectorXd>& residual,
                               const Poll& poll) {
  const Index k = std::ssize(model.terms);
  RegressorNoise result{.bias = VectorXd::Zero(k)};
  const VectorXd beta = means_of(model);
  NoiseSums known(k), at_most(k), in_motion(k);
  double num_samples = 0.0, of_x = 0.0, of_v = 0.0, motion_power = 0.0;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const Columns& columns = recordings[r];
    if (columns.noise == nullptr) continue;
    const dsp::Motion samples = some_samples(rows, r, recordings, enough_samples);
    if (samples.num_samples() == 0) continue;
    if (poll) poll();
    const ChannelNoise& of = *columns.noise;
    const auto count = static_cast<double>(samples.num_samples());
    const std::vector<TermSlope> slopes = slopes_of(model, r, samples);
    known.add(slopes, model.target, of, count, true, of.band_hz());
    at_most.add(slopes, model.target, of, count, false, of.band_hz());
    const std::optional<double> below = power_below(of.needed_hz(), residual, rows, r, columns.signals->sample_rate_hz);
    in_motion.add(slopes, model.target, of, count, false, below ? of.needed_hz() : of.band_hz());
    motion_power += count * (below ? *below : mean_square(residual, rows, r));
    num_samples += count;
    of_x += count * of.covariance("x", "x");
    of_v += count * of.covariance("v", "v") * square_of_x_over_v(samples);
    result.band_hz = std::max(result.band_hz, of.band_hz());
    result.needed_hz = std::max(result.needed_hz, of.needed_hz());
  }
  if (num_samples == 0.0) return result;
  result.known_std = std::sqrt(known.of_residual(beta) / num_samples);
  result.residual_std = std::sqrt(at_most.of_residual(beta) / num_samples);
  result.x_std = std::sqrt(of_x / num_samples);
  result.v_as_x_std = std::sqrt(of_v / num_samples);
  result.residual_power = residual.squaredNorm() / static_cast<double>(residual.size());
  result.motion_power = motion_power / num_samples;
  result.motion_std = std::sqrt(in_motion.of_residual(beta) / num_samples);
  const MatrixXd R = kept.R.topLeftCorner(k, k);
  const VectorXd right = (known.shared - known.noise * beta) * (static_cast<double>(kept.num_samples) / num_samples);
  result.bias = dsp::solve_upper(R, dsp::solve_transposed(R, right));
  return result;
}

VectorXd noise_below(const Model& model, std::size_t recording, const std::vector<Row>& rows,
                     const std::vector<Columns>& recordings, const Eigen::Ref<const VectorXd>& to_hz) {
  const dsp::Motion samples = some_samples(rows, recording, recordings, enough_samples);
  const std::vector<TermSlope> slopes = slopes_of(model, recording, samples);
  const auto count = static_cast<double>(samples.num_samples());
  const VectorXd beta = means_of(model);
  return to_hz.unaryExpr([&](double hz) {
    NoiseSums sums(beta.size());
    sums.add(slopes, model.target, *recordings[recording].noise, count, false, hz);
    return sums.of_residual(beta) / count;
  });
}

}  // namespace ident
