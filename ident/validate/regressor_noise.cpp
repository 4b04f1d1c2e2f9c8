#include "ident/validate/regressor_noise.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "ident/sensors/channel_noise.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A term's derivative with respect to one of its signals, on some samples.
struct Slope {
  Index term;
  std::string signal;
  VectorXd values;
};

std::vector<Slope> slopes_of(const Model& model, std::size_t recording, const dsp::Motion& motion) {
  std::vector<Slope> slopes;
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
  void add(const std::vector<Slope>& slopes, const std::string& of_target, const ChannelNoise& of, double count,
           bool known) {
    target += count * of.covariance(of_target, of_target, known);
    for (const Slope& one : slopes) {
      shared(one.term) += one.values.sum() * of.covariance(one.signal, of_target, known);
      for (const Slope& other : slopes)
        if (const double both = of.covariance(one.signal, other.signal, known); both != 0.0)
          noise(one.term, other.term) += one.values.dot(other.values) * both;
    }
  }
  [[nodiscard]] double of_residual(const VectorXd& beta) const {
    return std::max(0.0, target + beta.dot(noise * beta) - 2.0 * beta.dot(shared));
  }
};

}  // namespace

RegressorNoise regressor_noise(const Model& model, const RFactor& kept, const std::vector<Row>& rows,
                               const std::vector<Columns>& recordings, const Eigen::Ref<const VectorXd>& residual,
                               const Poll& poll) {
  const Index k = std::ssize(model.terms);
  RegressorNoise result{.bias = VectorXd::Zero(k)};
  VectorXd beta(k);
  for (Index i = 0; i < k; ++i) beta(i) = model.terms[static_cast<std::size_t>(i)].mean;
  NoiseSums known(k), at_most(k);
  double num_samples = 0.0, of_x = 0.0;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const Columns& columns = recordings[r];
    if (columns.noise == nullptr) continue;
    constexpr std::size_t enough = 2'000;  // for means to a few per cent
    const dsp::Motion samples = some_samples(rows, r, recordings, enough);
    if (samples.num_samples() == 0) continue;
    if (poll) poll();
    const ChannelNoise& of = *columns.noise;
    const auto count = static_cast<double>(samples.num_samples());
    const std::vector<Slope> slopes = slopes_of(model, r, samples);
    known.add(slopes, model.target, of, count, true);
    at_most.add(slopes, model.target, of, count, false);
    num_samples += count;
    of_x += count * of.covariance("x", "x");
    result.band_hz = std::max(result.band_hz, of.band_hz());
    result.needed_hz = std::max(result.needed_hz, of.needed_hz());
  }
  if (num_samples == 0.0) return result;
  result.known_std = std::sqrt(known.of_residual(beta) / num_samples);
  result.residual_std = std::sqrt(at_most.of_residual(beta) / num_samples);
  result.x_std = std::sqrt(of_x / num_samples);
  result.residual_power = residual.squaredNorm() / static_cast<double>(residual.size());
  const auto R = kept.R.topLeftCorner(k, k).triangularView<Eigen::Upper>();
  const VectorXd right = (known.shared - known.noise * beta) * (static_cast<double>(kept.num_samples) / num_samples);
  result.bias = R.solve(R.transpose().solve(right));
  return result;
}

}  // namespace ident
