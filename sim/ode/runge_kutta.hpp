#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <utility>

namespace sim {

/// One step of dy/dt = rhs(t, y) by a formula of dormand_prince.hpp, and the solution between its ends. N: number of
/// states, or Eigen::Dynamic. The right-hand side, rhs(double t, const double* y, double* dydt), is a template
/// parameter of what calls it, so that it can be inlined; it may throw.
template <class Formula, int N>
class RungeKutta {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;

  explicit RungeKutta(Eigen::Index num_states) : begin_(Vector::Zero(num_states)), end_(begin_), argument_(begin_) {
    slopes_.fill(begin_);
    polynomial_.fill(begin_);
  }

  /// The next step starts at t from y.
  template <class Rhs>
  void start(const Rhs& rhs, double t, const Vector& y) {
    t_ = t;
    begin_ = y;
    rhs(t, begin_.data(), slopes_[0].data());
  }
  /// The next step starts where the last one ended.
  void go_on() {
    t_ += h_;
    begin_ = end_;
    slopes_[0] = slopes_[num_stages];
  }
  /// A step of h. Another one before go_on takes its place.
  template <class Rhs>
  void step(const Rhs& rhs, double h) {
    h_ = h;
    has_polynomial_ = false;
    take_stages<1>(rhs);
  }

  [[nodiscard]] const Vector& begin() const& { return begin_; }
  void begin() const&& = delete;
  [[nodiscard]] const Vector& end() const& { return end_; }
  void end() const&& = delete;
  [[nodiscard]] const Vector& begin_slope() const& { return slopes_[0]; }
  void begin_slope() const&& = delete;

  /// The estimated error at the end of the step in units of the tolerance, absolute_i + relative |y_i|, as a root mean
  /// square over the states; NaN where the slope is no number.
  [[nodiscard]] double error(const Vector& absolute, double relative) const {
    std::array<double, num_estimates> squares{};
    for (Eigen::Index i = 0; i < end_.size(); ++i) {
      const double tolerance = tolerance_of(i, absolute, relative);
      for (std::size_t e = 0; e < num_estimates; ++e) {
        double sum = 0.0;
        for (std::size_t j = 0; j <= num_stages; ++j) sum += Formula::error[e][j] * slopes_[j][i];
        squares[e] += (sum / tolerance) * (sum / tolerance);
      }
    }
    if (!std::isfinite(slopes_[num_stages].sum())) return std::numeric_limits<double>::quiet_NaN();
    const double count = static_cast<double>(end_.size());
    if constexpr (num_estimates == 1) {
      return std::abs(h_) * std::sqrt(squares[0] / count);
    } else {  // [HNW93], (10.17)
      const double both = squares[0] + 0.01 * squares[1];
      return both > 0.0 ? std::abs(h_) * squares[0] / std::sqrt(both * count) : 0.0;
    }
  }
  /// That between the ends of the step, where the formula's polynomial may be worse: what its last term comes to at
  /// most, times Formula::left_out.
  template <class Rhs>
  [[nodiscard]] double error_between(const Rhs& rhs, const Vector& absolute, double relative) {
    if constexpr (Formula::left_out == 0.0) return 0.0;
    if (!has_polynomial_) make_polynomial(rhs);
    double square = 0.0;
    for (Eigen::Index i = 0; i < end_.size(); ++i) {
      const double term = polynomial_[num_powers - 1][i] / tolerance_of(i, absolute, relative);
      square += term * term;
    }
    return Formula::left_out * std::sqrt(square / static_cast<double>(end_.size()));
  }

  /// Of the largest eigenvalue times h, from the last two slopes, both at the end of the step ([HW96], IV.2).
  [[nodiscard]] double stiffness() const {
    const double apart = (end_ - argument_).norm();
    return apart > 0.0 ? h_ * (slopes_[num_stages] - slopes_[num_stages - 1]).norm() / apart : 0.0;
  }

  /// States at t + u h, u from 0 to 1. The right-hand side is that of the step.
  template <class Rhs>
  void between(const Rhs& rhs, double u, double* y) {
    if (!has_polynomial_) make_polynomial(rhs);
    const double w = 1.0 - u;
    for (Eigen::Index i = 0; i < end_.size(); ++i) {
      double sum = 0.0;
      for (std::size_t j = num_powers; j-- > 0;) sum = (sum + polynomial_[j][i]) * (j % 2 == 0 ? u : w);
      y[i] = begin_[i] + sum;
    }
  }

 private:
  static constexpr std::size_t num_stages = Formula::num_stages, num_slopes = Formula::num_slopes,
                               num_estimates = std::extent_v<decltype(Formula::error)>,
                               num_dense = std::extent_v<decltype(Formula::dense)>, num_powers = 3 + num_dense;

  [[nodiscard]] double tolerance_of(Eigen::Index i, const Vector& absolute, double relative) const {
    return absolute[i] + relative * std::max(std::abs(begin_[i]), std::abs(end_[i]));
  }
  /// begin + h sum_j a_ij k_j.
  template <std::size_t i>
  void combine(Vector& into) const {
    into.setZero();
    [&]<std::size_t... j>(std::index_sequence<j...>) {
      (add<i, j>(into), ...);
    }
    (std::make_index_sequence<i>());
    into = begin_ + h_ * into;
  }
  template <std::size_t i, std::size_t j>
  void add(Vector& into) const {
    if constexpr (Formula::a[i][j] != 0.0) into += Formula::a[i][j] * slopes_[j];
  }
  template <std::size_t i, class Rhs>
  void take_stages(const Rhs& rhs) {
    Vector& argument = i == num_stages ? end_ : argument_;
    combine<i>(argument);
    rhs(t_ + Formula::c[i] * h_, argument.data(), slopes_[i].data());
    if constexpr (i != num_stages && i + 1 < num_slopes) take_stages<i + 1>(rhs);
  }
  template <class Rhs>
  void make_polynomial(const Rhs& rhs) {
    if constexpr (num_slopes > num_stages + 1) {
      const Vector argument = argument_;  // stiffness() looks at that of the last stage
      take_stages<num_stages + 1>(rhs);
      argument_ = argument;
    }
    polynomial_[0] = end_ - begin_;
    polynomial_[1] = h_ * slopes_[0] - polynomial_[0];
    polynomial_[2] = 2.0 * polynomial_[0] - h_ * (slopes_[0] + slopes_[num_stages]);
    for (std::size_t d = 0; d < num_dense; ++d) {
      polynomial_[3 + d].setZero();
      for (std::size_t j = 0; j < num_slopes; ++j) polynomial_[3 + d] += (h_ * Formula::dense[d][j]) * slopes_[j];
    }
    has_polynomial_ = true;
  }

  double t_ = 0.0, h_ = 0.0;
  Vector begin_, end_, argument_;  ///< argument: of the last stage before the end
  std::array<Vector, num_slopes> slopes_;
  std::array<Vector, num_powers> polynomial_;
  bool has_polynomial_ = false;
};

}  // namespace sim
