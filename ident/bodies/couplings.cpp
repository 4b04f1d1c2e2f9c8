#include "ident/bodies/couplings.hpp"

#include <algorithm>
#include <cmath>

#include "dsp/values/constants.hpp"
#include "dsp/values/linear.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The coefficients of terms between two bodies in both equations.
struct Pair {
  VectorXd lower, upper;
  MatrixXd of_lower, of_both, of_upper;  ///< covariances
  /// Upper + factor lower, factor m_lower / m_upper: zero where the law holds.
  [[nodiscard]] VectorXd difference(double factor) const { return upper + factor * lower; }
  [[nodiscard]] MatrixXd covariance(double factor) const {
    return of_upper + factor * (of_both + of_both.transpose()) + factor * factor * of_lower;
  }
  /// covariance(factor)^-1 b, in units of its standard deviations.
  [[nodiscard]] VectorXd solved(double factor, const VectorXd& b) const {
    const MatrixXd C = covariance(factor);
    const VectorXd by_std = C.diagonal().cwiseSqrt().cwiseInverse();
    return by_std.cwiseProduct(
        dsp::solve_symmetric(by_std.asDiagonal() * C * by_std.asDiagonal(), by_std.cwiseProduct(b)));
  }
  [[nodiscard]] double chi_square(double factor) const {
    const VectorXd d = difference(factor);
    return d.dot(solved(factor, d));
  }
};

/// The least of a function of the logarithm of a positive factor about a start, by ever smaller steps.
double least_near(const Pair& pair, double start) {
  double at = std::log(start), best = pair.chi_square(start);
  for (double step = 0.5; step > 1e-10;) {
    const double up = pair.chi_square(std::exp(at + step)), down = pair.chi_square(std::exp(at - step));
    if (up < best)
      at += step, best = up;
    else if (down < best)
      at -= step, best = down;
    else
      step *= 0.5;
  }
  return std::exp(at);
}

/// Probability of a chi-square of so many degrees beyond a value: its finite sum in whole or half powers.
double beyond(double chi_square, int freedom) {
  if (freedom <= 0) return 1.0;
  const double half = 0.5 * chi_square;
  const bool is_odd = freedom % 2 == 1;
  double sum = is_odd ? std::erfc(std::sqrt(half)) : 0.0;
  for (double k = is_odd ? 0.5 : 0.0; k < 0.5 * freedom; k += 1.0)
    sum += std::exp(-half) * std::pow(half, k) / std::tgamma(k + 1.0);
  return std::min(1.0, sum);
}

std::ptrdiff_t place_of(const std::vector<BodyTerm>& terms, int body, const std::string& name) {
  const auto found =
      std::find_if(terms.begin(), terms.end(), [&](const BodyTerm& t) { return t.body == body && t.name == name; });
  return found == terms.end() ? -1 : found - terms.begin();
}

/// What both equations have of a pair.
std::vector<std::string> names_between(int lower, const std::vector<BodyTerm>& terms) {
  const std::string stretch = BodiesLayout::stretch(lower), rate = BodiesLayout::stretch_rate(lower);
  std::vector<std::string> names;
  for (const BodyTerm& term : terms) {
    const bool is_between = term.name.find(stretch) != std::string::npos || term.name.find(rate) != std::string::npos;
    if (is_between && std::find(names.begin(), names.end(), term.name) == names.end()) names.push_back(term.name);
  }
  return names;
}

/// Imposes it on the lower body's coefficients: weighted least squares of both against one, in units of the standard
/// deviations, as the coefficients span decades.
void impose(Coupling& coupling, const Pair& pair, double factor) {
  const Index k = pair.lower.size();
  VectorXd std(2 * k), both(2 * k);
  std << pair.of_lower.diagonal().cwiseSqrt(), pair.of_upper.diagonal().cwiseSqrt();
  both << pair.lower, pair.upper;
  MatrixXd covariance(2 * k, 2 * k), design(2 * k, k);
  covariance << pair.of_lower, pair.of_both.transpose(), pair.of_both, pair.of_upper;
  design << MatrixXd::Identity(k, k), -factor * MatrixXd::Identity(k, k);
  const MatrixXd by_std = std.cwiseInverse().asDiagonal(), unit = std.head(k).asDiagonal();
  const MatrixXd weight = dsp::inverse_of_symmetric(by_std * covariance * by_std), scaled = by_std * design * unit;
  const MatrixXd own = dsp::inverse_of_symmetric(scaled.transpose() * weight * scaled);
  coupling.mean = unit * (own * (scaled.transpose() * (weight * (by_std * both))));
  coupling.std = unit * own.diagonal().cwiseSqrt();
}

Coupling coupling_of(int lower, const std::vector<std::string>& names, const std::vector<BodyTerm>& terms,
                     const VectorXd& mean, const MatrixXd& covariance) {
  Coupling coupling{.lower = lower, .terms = names};
  coupling.mass_ratio = coupling.mass_ratio_std = dsp::nan;
  std::vector<Index> below, above;
  for (const std::string& name : names) {
    const auto low = place_of(terms, lower, name), high = place_of(terms, lower + 1, name);
    if (low < 0 || high < 0)
      coupling.on_one_side.push_back(name);
    else
      below.push_back(low), above.push_back(high);
  }
  if (!coupling.on_one_side.empty()) coupling.probability = 0.0;
  if (below.empty()) return coupling;
  const Pair pair{mean(below), mean(above), covariance(below, below), covariance(above, below),
                  covariance(above, above)};
  Index strongest = 0;
  pair.lower.cwiseAbs().cwiseQuotient(pair.of_lower.diagonal().cwiseSqrt()).maxCoeff(&strongest);
  const double start = -pair.upper(strongest) / pair.lower(strongest);
  coupling.freedom = static_cast<int>(below.size()) - 1;
  if (!(start > 0.0)) {
    coupling.probability = 0.0;
    return coupling;
  }
  const double factor = least_near(pair, start);
  coupling.chi_square = pair.chi_square(factor);
  if (coupling.on_one_side.empty()) coupling.probability = beyond(coupling.chi_square, coupling.freedom);
  const VectorXd slope = pair.solved(factor, pair.lower);
  coupling.mass_ratio = 1.0 / factor;
  coupling.mass_ratio_std = 1.0 / (factor * factor * std::sqrt(pair.lower.dot(slope)));
  if (coupling.holds()) impose(coupling, pair, factor);
  return coupling;
}

}  // namespace

std::vector<Coupling> couplings_of(const BodiesLayout& layout, const std::vector<BodyTerm>& terms, const VectorXd& mean,
                                   const MatrixXd& covariance) {
  std::vector<Coupling> couplings;
  for (int lower = 1; lower < layout.num_bodies; ++lower)
    if (const std::vector<std::string> names = names_between(lower, terms); !names.empty())
      couplings.push_back(coupling_of(lower, names, terms, mean, covariance));
  return couplings;
}

}  // namespace ident
