#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "ident/state_space/linear.hpp"
#include "ident/state_space/smoother.hpp"
#include "support/random.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using namespace ident::state_space;

namespace {

constexpr double rate_hz = 50.0;

/// Two short records of a Duffing oscillator with dry friction: x with an unknown offset, a with gain and lag, v AC
/// coupled. The channels are noise: nothing below needs them to fit.
Problem problem() {
  Problem p{.equations = oscillator({"x", "v", "x^3", "sgn(v)", "f"}, {"f"}), .sample_rate_hz = rate_hz};
  p.channels = {{.name = "x", .offset = {0.0, unknown}},
                {.name = "a", .state = 1, .rate = true, .gain = {1.0, 0.01}, .lag_s = {0.0, 1e-3}},
                {.name = "v", .state = 1, .corner_rad_s = {2.0, 0.1}}};
  for (unsigned r = 0; r < 2; ++r) {
    Record record{support::gaussian(60, 3, 5 + r), MatrixXd(60, 1)};
    for (Index k = 0; k < 60; ++k) record.inputs(k) = std::cos((4.0 + 1.5 * r) * static_cast<double>(k) / rate_hz);
    record.channels(5, 0) = record.channels(0, 1) = std::numeric_limits<double>::quiet_NaN();
    p.records.push_back(record);
  }
  return p;
}

Point point(double lag_s = 0.0) {
  Point at{{-25.0, -1.0, -300.0, -0.5, 10.0, 1.0, 0.01, 0.0, 0.0, 1.02, 0.0, lag_s, 0.0, 1.0, 0.0, 0.0, 2.1}, {}};
  for (unsigned r = 0; r < 2; ++r) {
    const MatrixXd noise = support::gaussian(60, 3, 9 + r);
    std::vector<double> states;
    for (Index k = 0; k < 60; ++k) {
      const double phase = 4.3 * static_cast<double>(k) / rate_hz + r;
      for (const double s : {0.3 * std::cos(phase) + 0.03 * noise(k, 0), -1.2 * std::sin(phase) + 0.03 * noise(k, 1),
                             -1.1 * std::sin(phase) + 0.03 * noise(k, 2)})
        states.push_back(s);
    }
    at.states.push_back(states);
  }
  return at;
}

// Coefficients, offset of x, gain and lag of a, corner of v.
const std::vector<int> sought{0, 1, 2, 3, 4, 6, 9, 11, 16};
const Noise noise{{1e-3, 5e-3, 2e-2}, {0.02, 0.3, 0.1}};

Linear about(const Linearisation& problem, const Point& at) {
  const auto linear = problem.about(at, sought, 2, 1);
  REQUIRE(linear);
  return *linear;
}

/// Largest difference over the largest value.
double apart(const std::vector<double>& a, const std::vector<double>& b) {
  double worst = 0.0, largest = 1e-300;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::isnan(a[i])) continue;
    worst = std::max(worst, std::abs(a[i] - b[i])), largest = std::max(largest, std::abs(a[i]));
  }
  return worst / largest;
}

std::vector<double> slope(const std::vector<double>& above, const std::vector<double>& below, double width) {
  std::vector<double> result;
  for (std::size_t i = 0; i < above.size(); ++i) result.push_back((below[i] - above[i]) / width);
  return result;
}

/// Entry (i, column) of every sample's matrix of `width` columns.
std::vector<double> column(const std::vector<double>& matrices, std::size_t width, std::size_t column) {
  std::vector<double> result;
  for (std::size_t i = column; i < matrices.size(); i += width) result.push_back(matrices[i]);
  return result;
}

}  // namespace

TEST_CASE("sensitivities to parameters are differences of steps and outputs", "[ident][state_space]") {
  const Linearisation problem(::problem());
  const Point at = point();
  const Linear linear = about(problem, at);
  const std::size_t p = sought.size();
  for (std::size_t c = 0; c < p; ++c) {
    const auto parameter = static_cast<std::size_t>(sought[c]);
    Point above = at, below = at;
    const double d = 1e-5 * std::max(1e-2, std::abs(at.parameters[parameter]));
    above.parameters[parameter] += d, below.parameters[parameter] -= d;
    const Linear up = about(problem, above), down = about(problem, below);
    CAPTURE(c);
    for (std::size_t r = 0; r < 2; ++r) {
      const LinearRecord& record = linear.records[r];
      // Third derivatives times d^2, and rounding over d: below 1e-7.
      CHECK(apart(column(record.by_parameter, p, c), slope(up.records[r].defect, down.records[r].defect, 2 * d)) <
            1e-6);
      CHECK(apart(column(record.output_by_parameter, p, c),
                  slope(up.records[r].residual, down.records[r].residual, 2 * d)) < 1e-6);
    }
  }
}

TEST_CASE("sensitivities to states are differences, across located switches too", "[ident][state_space]") {
  const Linearisation problem(::problem());
  const Point at = point();
  const Linear linear = about(problem, at);
  const double d = 1e-7;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t r = 0; r < 2; ++r) {
      // Every other sample moves, so that a defect sees one of its two states move.
      Point above = at, below = at;
      for (std::size_t k = 0; k < 60; k += 2) above.states[r][3 * k + i] += d, below.states[r][3 * k + i] -= d;
      const LinearRecord up = about(problem, above).records[r], down = about(problem, below).records[r];
      std::vector<double> expected, found, expected_outputs, found_outputs;
      for (std::size_t k = 0; k < 58; k += 2)
        for (std::size_t j = 0; j < 3; ++j) {
          found.push_back(linear.records[r].by_state[9 * k + 3 * j + i]);
          expected.push_back((down.defect[3 * k + j] - up.defect[3 * k + j]) / (2 * d));
          if (std::isnan(up.residual[3 * k + j])) continue;
          found_outputs.push_back(linear.records[r].output_by_state[9 * k + 3 * j + i]);
          expected_outputs.push_back((down.residual[3 * k + j] - up.residual[3 * k + j]) / (2 * d));
        }
      CHECK(apart(expected, found) < 2e-6);  // a switch is placed to 1e-12 of a sample: 1e-12 a h / d
      CHECK(apart(expected_outputs, found_outputs) < 1e-6);
    }
}

TEST_CASE("the smoother solves the whole system", "[ident][state_space]") {
  const Linearisation problem(::problem());
  const Linear linear = about(problem, point(2e-4));
  const Smoothed smoothed = smooth(linear, noise, true, 1);
  const Index ns = 3, n = 60, p = static_cast<Index>(sought.size()), size = 2 * n * ns + p;
  // All rows at once, as a dense least squares by normal equations.
  MatrixXd H = MatrixXd::Zero(size, size);
  VectorXd g = VectorXd::Zero(size);
  double squares = 0.0;
  const auto add = [&](const VectorXd& row, double b) { H += row * row.transpose(), g += b * row, squares += b * b; };
  for (Index r = 0; r < 2; ++r) {
    const LinearRecord& record = linear.records[static_cast<std::size_t>(r)];
    for (Index k = 0; k < n; ++k) {
      const Index at = (r * n + k) * ns;
      for (Index j = 0; j < 3; ++j) {
        const auto i = static_cast<std::size_t>(3 * k + j);
        if (std::isnan(record.residual[i])) continue;
        VectorXd row = VectorXd::Zero(size);
        for (Index s = 0; s < ns; ++s) row(at + s) = record.output_by_state[i * 3 + static_cast<std::size_t>(s)];
        for (Index c = 0; c < p; ++c)
          row(2 * n * ns + c) = record.output_by_parameter[i * sought.size() + static_cast<std::size_t>(c)];
        const double std = noise.channel[static_cast<std::size_t>(j)];
        add(row / std, record.residual[i] / std);
      }
      for (Index j = 0; j < ns && k + 1 < n; ++j) {
        const auto i = static_cast<std::size_t>(3 * k + j);
        VectorXd row = VectorXd::Zero(size);
        for (Index s = 0; s < ns; ++s) row(at + s) = -record.by_state[i * 3 + static_cast<std::size_t>(s)];
        row(at + ns + j) = 1.0;
        for (Index c = 0; c < p; ++c)
          row(2 * n * ns + c) = -record.by_parameter[i * sought.size() + static_cast<std::size_t>(c)];
        const double std = noise.process[static_cast<std::size_t>(j)];
        add(row / std, -record.defect[i] / std);
      }
    }
  }
  for (Index c = 0; c < p; ++c) {
    VectorXd row = VectorXd::Zero(size);
    row(2 * n * ns + c) = linear.prior_weights[static_cast<std::size_t>(c)];
    add(row, linear.prior_residuals[static_cast<std::size_t>(c)]);
  }
  const Eigen::PartialPivLU<MatrixXd> lu(H);
  const VectorXd x = lu.solve(g);
  const std::vector<double> step = smoothed.parameters.solve();
  const auto states = states_step(smoothed.eliminated, step, true, 2);
  // The normal equations lose the square of the condition number of the rows, some 1e3 squared.
  for (Index c = 0; c < p; ++c) CHECK(step[static_cast<std::size_t>(c)] == Approx(x(2 * n * ns + c)).epsilon(1e-7));
  for (Index r = 0; r < 2; ++r)
    for (Index i = 0; i < n * ns; ++i)
      CHECK(states[static_cast<std::size_t>(r)][static_cast<std::size_t>(i)] ==
            Approx(x(r * n * ns + i)).epsilon(1e-7).margin(1e-9));
  CHECK(smoothed.cost == Approx(squares).epsilon(1e-12));
  CHECK(smoothed.parameters.left_over() == Approx(squares - g.dot(x)).epsilon(1e-9));
  const MatrixXd covariance = lu.inverse().bottomRightCorner(p, p);
  const std::vector<double> found = smoothed.parameters.covariance();
  for (Index i = 0; i < p; ++i)
    for (Index j = 0; j < p; ++j)
      CHECK(found[static_cast<std::size_t>(i * p + j)] ==
            Approx(covariance(i, j)).margin(1e-7 * std::sqrt(covariance(i, i) * covariance(j, j))));
  const MatrixXd states_only = H.topLeftCorner(2 * n * ns, 2 * n * ns);
  const VectorXd pivots = Eigen::PartialPivLU<MatrixXd>(states_only).matrixLU().diagonal();
  CHECK(smoothed.log_determinant == Approx(pivots.array().abs().log().sum()).epsilon(1e-10));
}

TEST_CASE("J and the innovations are those of a Kalman filter in covariance form", "[ident][state_space]") {
  const Linearisation problem(::problem());
  Linear linear = about(problem, point(2e-4));
  const std::vector<std::vector<double>> found = innovations(linear, noise);
  for (LinearRecord& record : linear.records) record.by_parameter.clear(), record.output_by_parameter.clear();
  linear.parameters.clear();
  // A diffuse beginning is a wide prior in the limit: its information 1e-10 against some 1e3.
  const double wide = 1e5;
  double J = 0.0;
  for (std::size_t r = 0; r < 2; ++r) {
    const LinearRecord& record = linear.records[r];
    VectorXd mean = VectorXd::Zero(3);
    MatrixXd P = wide * wide * MatrixXd::Identity(3, 3);
    J -= 3.0 * std::log(wide * wide);
    for (std::size_t k = 0; k < 60; ++k) {
      for (std::size_t j = 0; j < 3; ++j) {
        const double e = record.residual[3 * k + j], std = noise.channel[j];
        if (std::isnan(e)) continue;
        const Eigen::Map<const VectorXd> h(&record.output_by_state[(3 * k + j) * 3], 3);
        const double S = h.dot(P * h) + std * std, innovation = e - h.dot(mean);
        J += innovation * innovation / S + std::log(S);
        if (k > 3) CHECK(found[r][3 * k + j] == Approx(innovation / std::sqrt(S)).margin(1e-4));
        const VectorXd gain = P * h / S;
        mean += gain * innovation;
        const MatrixXd kept = MatrixXd::Identity(3, 3) - gain * h.transpose();  // Joseph's form
        P = (kept * P * kept.transpose() + std * std * gain * gain.transpose()).eval();
      }
      if (k == 59) break;
      const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> F(&record.by_state[9 * k]);
      mean = (F * mean - Eigen::Map<const VectorXd>(&record.defect[3 * k], 3)).eval();
      P = (F * P * F.transpose()).eval();
      for (Index i = 0; i < 3; ++i) P(i, i) += std::pow(noise.process[static_cast<std::size_t>(i)], 2);
    }
  }
  // What the wide prior leaves: rounding of its covariance, 1e10 times 1e-16 of 1e-4.
  CHECK(smooth(linear, noise, false, 1).J() == Approx(J).margin(1e-2));
}

TEST_CASE("threads do not change a bit", "[ident][state_space]") {
  const Linearisation problem(::problem());
  const auto one = problem.about(point(), sought, 2, 1), two = problem.about(point(), sought, 2, 2);
  REQUIRE((one && two));
  CHECK(one->records[1].by_state == two->records[1].by_state);
  CHECK(smooth(*one, noise, false, 1).parameters.solve() == smooth(*two, noise, false, 2).parameters.solve());
}
