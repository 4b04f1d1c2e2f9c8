#pragma once
#include <vector>

namespace ident::state_space {

/// Least squares min |A x - b|^2 as the triangle of [A b], rows folded in by Householder reflections, 64 at a time. The
/// result depends on the rows and their order alone.
class Triangle {
 public:
  explicit Triangle(int columns = 0);
  [[nodiscard]] int columns() const { return columns_; }
  /// A row of A and its b: columns + 1 values.
  void add(const double* row);
  /// All rows of the other, of as many columns.
  void add(const Triangle& other);
  /// What follows needs all rows folded: `fold` after the last `add`.
  void fold();

  /// The sum of squares that no x removes.
  [[nodiscard]] double left_over() const { return left_over_; }
  /// The least of |A x - b|^2 + linear'x, the second empty or of `columns` values. Columns without any row get x = 0.
  [[nodiscard]] std::vector<double> solve(const std::vector<double>& linear = {}) const;
  /// |A x - b|^2 + linear'x.
  [[nodiscard]] double value(const std::vector<double>& x, const std::vector<double>& linear = {}) const;
  /// For x counted from elsewhere: min |A (x - x0) - b|^2.
  [[nodiscard]] Triangle from(const std::vector<double>& x0) const;
  /// (A'A)^-1, row after row; infinite on the diagonal of a column without rows.
  [[nodiscard]] std::vector<double> covariance() const;
  /// log |A'A|, columns without any row left out.
  [[nodiscard]] double log_determinant() const;
  /// The same rows with these columns alone.
  [[nodiscard]] Triangle only(const std::vector<int>& columns) const;
  /// With rows factor |column| x_j = 0 for every column.
  [[nodiscard]] Triangle damped(double factor) const;

 private:
  [[nodiscard]] double& at(int row, int column) & { return values_[static_cast<std::size_t>(row * width_ + column)]; }
  [[nodiscard]] double at(int row, int column) const& {
    return values_[static_cast<std::size_t>(row * width_ + column)];
  }
  [[nodiscard]] double column_norm(int column) const;
  [[nodiscard]] bool is_empty(int column) const;
  void back_substitute(std::vector<double>& x) const;

  static constexpr int most_pending = 64;
  int columns_, width_, pending_ = 0;
  double left_over_ = 0.0;
  std::vector<double> values_;  ///< the triangle, then the rows that wait
};

}  // namespace ident::state_space
