#include "ident/selection/autoregression.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "dsp/values/linear.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

bool begins_run(const std::vector<unsigned char>& begins, Index row) {
  return begins[static_cast<std::size_t>(row)] != 0;
}

/// Twice the negative log of the restricted likelihood, but for a constant, of rows [A_t A_(t-1)] that continue a run
/// (their R factor) and rows that begin one.
class RestrictedLikelihood {
 public:
  RestrictedLikelihood(MatrixXd continued, MatrixXd first, Index num_rows)
      : continued_(std::move(continued)), first_(std::move(first)), num_rows_(static_cast<double>(num_rows)) {}
  [[nodiscard]] double operator()(double rho) const {
    const Index width = first_.cols(), num_terms = width - 1;
    MatrixXd rows(continued_.rows() + first_.rows(), width);
    rows << continued_.leftCols(width) - rho * continued_.rightCols(width), std::sqrt(1.0 - rho * rho) * first_;
    const MatrixXd R = dsp::Qr(std::move(rows)).triangle();
    const double spare = std::max(1.0, num_rows_ - static_cast<double>(num_terms));
    double log_determinant = 0.0;
    for (Index j = 0; j < num_terms; ++j)
      log_determinant += 2.0 * std::log(std::max(std::abs(R(j, j)), std::numeric_limits<double>::min()));
    const double rest = std::max(std::abs(R(num_terms, num_terms)), std::numeric_limits<double>::min());
    return 2.0 * spare * std::log(rest) + log_determinant -
           static_cast<double>(first_.rows()) * std::log(1.0 - rho * rho);
  }

 private:
  MatrixXd continued_, first_;
  double num_rows_;
};

/// That of rows [first_row, first_row + num_rows); as of autoregression.
RestrictedLikelihood likelihood_of(Index first_row, Index num_rows, Index num_terms, const Eigen::RowVectorXd& largest,
                                   const RowReader& read, const std::vector<unsigned char>& begins, int num_threads) {
  const Index width = num_terms + 1;
  Eigen::RowVectorXd twice(2 * width);
  twice << largest, largest;
  const RFactor continued = r_factor(
      num_rows, 2 * num_terms + 1, twice,
      [&](Index from, Eigen::Ref<MatrixXd> block) {
        const Index first = first_row + from, before = first > 0 ? 1 : 0;
        MatrixXd rows(block.rows() + before, width);
        read(first - before, rows);
        for (Index i = 0; i < block.rows(); ++i)
          if (begins_run(begins, first + i))
            block.row(i).setZero();
          else
            block.row(i) << rows.row(i + before), rows.row(i + before - 1);
      },
      num_threads);
  const auto own = begins.begin() + first_row;
  MatrixXd first_rows(std::count(own, own + num_rows, 1), width);
  for (Index row = first_row, run = 0; row < first_row + num_rows; ++row)
    if (begins_run(begins, row)) read(row, first_rows.middleRows(run++, 1));
  const Eigen::RowVectorXd scale = largest.unaryExpr([](double value) { return value > 0.0 ? value : 1.0; });
  MatrixXd R = continued.R;
  R.leftCols(width).array().rowwise() /= scale.array();
  R.rightCols(width).array().rowwise() /= scale.array();
  first_rows.array().rowwise() /= scale.array();
  return {std::move(R), std::move(first_rows), num_rows};
}

}  // namespace

std::vector<unsigned char> run_begins(const std::vector<Index>& samples, const std::vector<Index>& first_rows) {
  std::vector<unsigned char> begins(samples.size(), 0);
  for (std::size_t i = 0; i < samples.size(); ++i) begins[i] = i == 0 || samples[i] != samples[i - 1] + 1 ? 1 : 0;
  for (const Index row : first_rows)
    if (row < std::ssize(samples)) begins[static_cast<std::size_t>(row)] = 1;
  return begins;
}

RowReader whitened(RowReader read, const std::vector<unsigned char>& begins, double rho) {
  return [read = std::move(read), &begins, rho](Index first, Eigen::Ref<MatrixXd> block) {
    const Index before = first > 0 ? 1 : 0;
    MatrixXd rows(block.rows() + before, block.cols());
    read(first - before, rows);
    for (Index i = 0; i < block.rows(); ++i) {
      if (begins_run(begins, first + i))
        block.row(i) = std::sqrt(1.0 - rho * rho) * rows.row(i + before);
      else
        block.row(i) = rows.row(i + before) - rho * rows.row(i + before - 1);
    }
  };
}

VectorXd whitened_values(const Eigen::Ref<const VectorXd>& values, const std::vector<unsigned char>& begins,
                         double rho) {
  VectorXd result(values.size());
  for (Index i = 0; i < values.size(); ++i)
    result(i) = begins_run(begins, i) ? std::sqrt(1.0 - rho * rho) * values(i) : values(i) - rho * values(i - 1);
  return result;
}

double autoregression(Index num_rows, Index num_terms, const Eigen::RowVectorXd& largest, const RowReader& read,
                      const std::vector<unsigned char>& begins, int num_threads, std::vector<Index> first_rows) {
  std::vector<RestrictedLikelihood> records;
  first_rows.push_back(num_rows);
  for (std::size_t i = 0; i + 1 < first_rows.size(); ++i)
    records.push_back(
        likelihood_of(first_rows[i], first_rows[i + 1] - first_rows[i], num_terms, largest, read, begins, num_threads));
  const auto likelihood = [&](double rho) {
    double sum = 0.0;
    for (const RestrictedLikelihood& record : records) sum += record(rho);
    return sum;
  };

  // Golden section over atanh(rho): 40 steps shrink it below 1e-7.
  constexpr double golden = 0.6180339887498949;
  double low = -4.0, high = 4.0;
  for (int step = 0; step < 40; ++step) {
    const double a = high - golden * (high - low), b = low + golden * (high - low);
    if (likelihood(std::tanh(a)) < likelihood(std::tanh(b)))
      high = b;
    else
      low = a;
  }
  return std::tanh(0.5 * (low + high));
}

}  // namespace ident
