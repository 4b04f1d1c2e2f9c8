#include "ident/state_space/triangle.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace ident::state_space {

Triangle::Triangle(int columns)
    : columns_(columns),
      width_(columns + 1),
      values_(static_cast<std::size_t>((columns + most_pending) * (columns + 1)), 0.0) {}

void Triangle::add(const double* row) {
  std::copy_n(row, width_, &at(columns_ + pending_, 0));
  if (++pending_ == most_pending) fold();
}

void Triangle::add(const Triangle& other) {
  for (int i = 0; i < columns_; ++i) add(other.values_.data() + static_cast<std::ptrdiff_t>(i) * width_);
  left_over_ += other.left_over_;
}

void Triangle::fold() {
  std::vector<double> sums(static_cast<std::size_t>(width_));
  const int first = columns_, last = columns_ + pending_;
  for (int j = 0; j < columns_; ++j) {
    double square = 0.0;
    for (int i = first; i < last; ++i) square += at(i, j) * at(i, j);
    if (square == 0.0) continue;
    const double head = at(j, j), norm = std::sqrt(head * head + square), pivot = head > 0.0 ? -norm : norm,
                 v = head - pivot, beta = 1.0 / (pivot * v);
    for (int q = j; q < width_; ++q) sums[static_cast<std::size_t>(q)] = v * at(j, q);
    for (int i = first; i < last; ++i) {
      const double factor = at(i, j);
      const double* row = values_.data() + static_cast<std::ptrdiff_t>(i) * width_;
      for (int q = j; q < width_; ++q) sums[static_cast<std::size_t>(q)] += factor * row[q];
    }
    for (int q = j; q < width_; ++q) sums[static_cast<std::size_t>(q)] *= beta;
    for (int i = first; i < last; ++i) {
      const double factor = at(i, j);
      double* row = values_.data() + static_cast<std::ptrdiff_t>(i) * width_;
      for (int q = j; q < width_; ++q) row[q] += factor * sums[static_cast<std::size_t>(q)];
    }
    for (int q = j; q < width_; ++q) at(j, q) += v * sums[static_cast<std::size_t>(q)];
  }
  for (int i = first; i < last; ++i) left_over_ += at(i, columns_) * at(i, columns_);
  pending_ = 0;
}

double Triangle::value(const std::vector<double>& x, const std::vector<double>& linear) const {
  double sum = left_over_;
  for (int i = 0; i < columns_; ++i) {
    double off = -at(i, columns_);
    for (int j = i; j < columns_; ++j) off += at(i, j) * x[static_cast<std::size_t>(j)];
    sum += off * off + (linear.empty() ? 0.0 : linear[static_cast<std::size_t>(i)] * x[static_cast<std::size_t>(i)]);
  }
  return sum;
}

Triangle Triangle::from(const std::vector<double>& x0) const {
  Triangle moved = *this;
  for (int i = 0; i < columns_; ++i)
    for (int j = i; j < columns_; ++j) moved.at(i, columns_) += at(i, j) * x0[static_cast<std::size_t>(j)];
  return moved;
}

double Triangle::column_norm(int column) const {
  double square = 0.0;
  for (int i = 0; i <= column; ++i) square += at(i, column) * at(i, column);
  return std::sqrt(square);
}

bool Triangle::is_empty(int column) const {
  // What the columns before leave of this one is rounding.
  constexpr double rounding = 1e-14;
  return std::abs(at(column, column)) <= rounding * column_norm(column);
}

void Triangle::back_substitute(std::vector<double>& x) const {
  for (int j = columns_ - 1; j >= 0; --j) {
    double& value = x[static_cast<std::size_t>(j)];
    for (int l = j + 1; l < columns_; ++l) value -= at(j, l) * x[static_cast<std::size_t>(l)];
    value = is_empty(j) ? 0.0 : value / at(j, j);
  }
}

std::vector<double> Triangle::solve(const std::vector<double>& linear) const {
  std::vector<double> x(static_cast<std::size_t>(columns_));
  for (int j = 0; j < columns_; ++j) x[static_cast<std::size_t>(j)] = at(j, columns_);
  if (!linear.empty()) {
    std::vector<double> forward = linear;  // R'^-1 linear
    for (int j = 0; j < columns_; ++j) {
      double& value = forward[static_cast<std::size_t>(j)];
      for (int l = 0; l < j; ++l) value -= at(l, j) * forward[static_cast<std::size_t>(l)];
      value = is_empty(j) ? 0.0 : value / at(j, j);
      x[static_cast<std::size_t>(j)] -= 0.5 * value;
    }
  }
  back_substitute(x);
  return x;
}

std::vector<double> Triangle::covariance() const {
  const auto size = static_cast<std::size_t>(columns_);
  std::vector<double> covariance(size * size, 0.0);
  for (std::size_t c = 0; c < size; ++c) {  // R^-1, a column at a time, adds its square
    std::vector<double> column(size, 0.0);
    column[c] = 1.0;
    back_substitute(column);
    for (std::size_t i = 0; i < size; ++i)
      for (std::size_t j = 0; j < size; ++j) covariance[i * size + j] += column[i] * column[j];
  }
  for (int j = 0; j < columns_; ++j)
    if (is_empty(j)) covariance[static_cast<std::size_t>(j) * (size + 1)] = std::numeric_limits<double>::infinity();
  return covariance;
}

double Triangle::log_determinant() const {
  double sum = 0.0;
  for (int j = 0; j < columns_; ++j)
    if (!is_empty(j)) sum += 2.0 * std::log(std::abs(at(j, j)));
  return sum;
}

Triangle Triangle::only(const std::vector<int>& columns) const {
  Triangle part(static_cast<int>(columns.size()));
  std::vector<double> row(columns.size() + 1);
  for (int i = 0; i < columns_; ++i) {
    for (std::size_t j = 0; j < columns.size(); ++j) row[j] = at(i, columns[j]);
    row.back() = at(i, columns_);
    part.add(row.data());
  }
  part.fold();
  part.left_over_ += left_over_;
  return part;
}

Triangle Triangle::damped(double factor) const {
  Triangle more = *this;
  for (int j = 0; j < columns_; ++j) {
    std::vector<double> row(static_cast<std::size_t>(width_), 0.0);
    row[static_cast<std::size_t>(j)] = factor * column_norm(j);
    more.add(row.data());
  }
  more.fold();
  return more;
}

}  // namespace ident::state_space
