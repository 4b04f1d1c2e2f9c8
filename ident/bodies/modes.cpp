#include "ident/bodies/modes.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>

#include "dsp/values/constants.hpp"
#include "ident/state_space/model.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// d rate / d state of the equations at rest, a matrix for each coefficient of 1, the kinematics first.
std::vector<MatrixXd> linear_parts(const BodiesLayout& layout, const std::vector<BodyTerm>& terms) {
  const state_space::Problem problem{.equations = equations_of(layout, terms), .channels = {}, .records = {}};
  const state_space::Model model(problem);
  state_space::Rates<1> rates(model);
  std::vector<MatrixXd> parts;
  for (std::size_t of = 0; of <= terms.size(); ++of) {
    std::vector<double> coefficients(terms.size(), 0.0);
    if (of > 0) coefficients[of - 1] = 1.0;
    for (int i = 0; i < model.num_states(); ++i) *rates.state(i) = 0.0;
    for (int i = 0; i < model.num_inputs(); ++i) *rates.input(i) = 0.0;
    rates.evaluate(coefficients);
    MatrixXd part(model.num_states(), model.num_states());
    for (int i = 0; i < model.num_states(); ++i)
      for (int j = 0; j < model.num_states(); ++j) part(i, j) = *rates.slope(i, j);
    if (of > 0) part -= parts.front();
    parts.push_back(std::move(part));
  }
  return parts;
}

/// Frequency, damping, then shape and phase of each body; `largest`: the body that is 1, below 0: to be found.
VectorXd numbers_of(std::complex<double> lambda, const Eigen::VectorXcd& vector, Index num_bodies, Index& largest) {
  VectorXd numbers(2 + 2 * num_bodies);
  const bool is_open = largest < 0;
  numbers(0) = std::abs(lambda) / dsp::two_pi;
  numbers(1) = 0.0 - lambda.real() / std::abs(lambda);
  for (Index i = 0; i < num_bodies; ++i)
    if (largest < 0 || (is_open && std::abs(vector(2 * i)) > std::abs(vector(2 * largest)))) largest = i;
  for (Index i = 0; i < num_bodies; ++i) {
    const std::complex<double> one = vector(2 * i) / vector(2 * largest);
    numbers(2 + i) = one.real() < 0.0 ? -std::abs(one) : std::abs(one);
    numbers(2 + num_bodies + i) = std::arg(one) * 360.0 / dsp::two_pi;
  }
  return numbers;
}

/// A column for each mode that swings, slowest first; empty where a number is not finite. `largest`: of each mode, as
/// found the first time.
MatrixXd solved(const std::vector<MatrixXd>& parts, const VectorXd& mean, Index num_bodies,
                std::vector<Index>& largest) {
  MatrixXd matrix = parts.front();
  for (Index i = 0; i < mean.size(); ++i) matrix += mean(i) * parts[static_cast<std::size_t>(i) + 1];
  if (!matrix.allFinite()) return {};
  const Eigen::EigenSolver<MatrixXd> solver(matrix);
  if (solver.info() != Eigen::Success) return {};
  std::vector<Index> order;
  for (Index i = 0; i < matrix.rows(); ++i)
    if (solver.eigenvalues()(i).imag() > 0.0) order.push_back(i);
  std::sort(order.begin(), order.end(),
            [&](Index a, Index b) { return std::abs(solver.eigenvalues()(a)) < std::abs(solver.eigenvalues()(b)); });
  largest.resize(order.size(), -1);
  MatrixXd columns(2 + 2 * num_bodies, std::ssize(order));
  for (std::size_t m = 0; m < order.size(); ++m)
    columns.col(static_cast<Index>(m)) =
        numbers_of(solver.eigenvalues()(order[m]), solver.eigenvectors().col(order[m]), num_bodies, largest[m]);
  return columns;
}

}  // namespace

std::vector<Mode> modes_of(const BodiesLayout& layout, const std::vector<BodyTerm>& terms, const VectorXd& mean,
                           const MatrixXd& covariance) {
  const Index n = layout.num_bodies;
  const std::vector<MatrixXd> parts = linear_parts(layout, terms);
  std::vector<Index> largest;
  const MatrixXd found = solved(parts, mean, n, largest);
  std::vector<MatrixXd> slopes(static_cast<std::size_t>(found.cols()), MatrixXd::Zero(found.rows(), mean.size()));
  for (Index i = 0; i < mean.size() && found.cols() > 0; ++i) {
    constexpr double of_std = 1e-3;  // so little that it is linear, and far above rounding
    const double step = of_std * std::sqrt(covariance(i, i));
    if (parts[static_cast<std::size_t>(i) + 1].isZero(0.0) || !(step > 0.0)) continue;
    VectorXd above = mean, below = mean;
    above(i) += step, below(i) -= step;
    const MatrixXd up = solved(parts, above, n, largest), down = solved(parts, below, n, largest);
    if (up.cols() != found.cols() || down.cols() != found.cols()) return {};
    for (Index m = 0; m < found.cols(); ++m)
      slopes[static_cast<std::size_t>(m)].col(i) = (up.col(m) - down.col(m)) / (2.0 * step);
  }
  std::vector<Mode> modes;
  for (Index m = 0; m < found.cols(); ++m) {
    const MatrixXd& slope = slopes[static_cast<std::size_t>(m)];
    const VectorXd std = (slope * covariance).cwiseProduct(slope).rowwise().sum().cwiseMax(0.0).cwiseSqrt();
    const VectorXd one = found.col(m);
    modes.push_back({one(0), std(0), one(1), std(1), one.segment(2, n), std.segment(2, n), one.tail(n)});
  }
  return modes;
}

}  // namespace ident
