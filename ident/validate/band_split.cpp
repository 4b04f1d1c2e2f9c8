#include "ident/validate/band_split.hpp"

#include <cmath>
#include <utility>

#include "dsp/filter/column_filter.hpp"
#include "ident/rows_of_terms.hpp"
#include "ident/validate/metrics.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// By how much coefficients change below a cut-off, and what of that may be chance.
struct Change {
  VectorXd mean, std;
};

/// Kept columns with the residual of their equation behind them, on stretches of successive samples.
class Stretches {
 public:
  Stretches(const std::vector<Row>& rows, const std::vector<Columns>& recordings, const std::vector<Index>& terms,
            const Eigen::Ref<const VectorXd>& residual)
      : values_(std::ssize(rows), std::ssize(terms) + 1) {
    RowsOfTerms(rows, recordings, terms).for_each_block([&](Index first, const MatrixXd& phi) {
      values_.block(first, 0, phi.rows(), phi.cols()) = phi;
    });
    values_.rightCols(1) = residual;
    for (Index first = 0, next = 1; next <= std::ssize(rows); ++next) {
      const auto row = [&](Index i) -> const Row& { return rows[static_cast<std::size_t>(i)]; };
      if (next < std::ssize(rows) && row(next).recording == row(first).recording &&
          row(next).sample == row(first).sample + next - first)
        continue;
      stretches_.emplace_back(first, next - first);
      first = next;
    }
  }

  /// Low-passed, and the ends left out that lean on what lies beyond.
  [[nodiscard]] MatrixXd below(double stop_hz, double rate_hz) const {
    constexpr double flat = 0.78125;  // as far as the columns themselves are flat
    const auto filter = dsp::ColumnFilter::taper(rate_hz, {flat * stop_hz, stop_hz});
    const auto edge = static_cast<Index>(std::ceil(filter.edge_s() * rate_hz));
    MatrixXd result(values_.rows(), values_.cols());
    Index done = 0;
    for (const auto& [first, count] : stretches_) {
      if (count <= 4 * edge) continue;  // half of it is left at least
      const MatrixXd filtered = filter.apply(
          count, values_.cols(), [&](Index from, Index n) -> MatrixXd { return values_.middleRows(first + from, n); });
      result.middleRows(done, count - 2 * edge) = filtered.middleRows(edge, count - 2 * edge);
      done += count - 2 * edge;
    }
    return result.topRows(done);
  }

 private:
  MatrixXd values_;
  std::vector<std::pair<Index, Index>> stretches_;  // first row, rows
};

/// Nothing where the rows hold less than a value of their own for each block of scores, or do not tell the terms apart.
std::optional<Change> change_below(double stop_hz, double rate_hz, const Stretches& stretches) {
  constexpr double least_values = 50.0;
  const MatrixXd rows = stretches.below(stop_hz, rate_hz);
  const Index num_terms = rows.cols() - 1;
  const double values = static_cast<double>(rows.rows()) * 2.0 * stop_hz / rate_hz;
  if (values < least_values || values < 2.0 * static_cast<double>(num_terms)) return std::nullopt;
  const RFactor data = r_factor(rows.leftCols(num_terms), rows.rightCols(1));
  const Fit found = fit_ols(data);
  if (std::ssize(found.relevant) < num_terms) return std::nullopt;
  BlockScores scores(num_terms, rows.rows());
  scores.add(rows.leftCols(num_terms), rows.rightCols(1) - rows.leftCols(num_terms) * found.mean);
  const MatrixXd covariance = robust_covariance(data, scores);
  if (covariance.size() == 0 || !covariance.allFinite()) return std::nullopt;
  return Change{found.mean, covariance.diagonal().cwiseSqrt()};
}

/// By how much each coefficient differs, in what it may; beyond 1 it does.
VectorXd against_intervals(const VectorXd& difference, const VectorXd& printed_std, const VectorXd& chance_std) {
  constexpr double interval = 1.96, by_chance = 0.01;
  // A normal deviate exceeds z, either way, with a probability below exp(-z^2 / 2).
  const double z = std::sqrt(2.0 * std::log(static_cast<double>(difference.size()) / by_chance));
  return difference.cwiseAbs().cwiseQuotient((interval * printed_std).cwiseMax(z * chance_std));
}

}  // namespace

std::optional<BandSplit> band_split(const Model& model, const std::vector<Index>& terms, const std::vector<Row>& rows,
                                    const std::vector<Columns>& recordings, const Eigen::Ref<const VectorXd>& residual,
                                    const Poll& poll) {
  if (terms.empty() || rows.empty()) return std::nullopt;
  const Columns& first = recordings[rows.front().recording];
  if (first.prepared == nullptr) return std::nullopt;
  const double rate_hz = first.signals->sample_rate_hz, stop_hz = first.prepared->filter.stop_hz();
  VectorXd printed_std(std::ssize(terms));
  for (Index i = 0; i < printed_std.size(); ++i) printed_std(i) = model.terms[static_cast<std::size_t>(i)].std;
  if (!printed_std.allFinite()) return std::nullopt;
  if (poll) poll();
  const Stretches stretches(rows, recordings, terms, residual);
  const std::optional<Change> lower = change_below(0.5 * stop_hz, rate_hz, stretches);
  if (!lower) return std::nullopt;
  BandSplit split{.stop_hz = stop_hz, .holds_to_hz = stop_hz, .term = {}};
  Index most = 0;
  if (!(against_intervals(lower->mean, printed_std, lower->std).maxCoeff(&most) > 1.0)) return split;
  const ModelTerm& term = model.terms[static_cast<std::size_t>(most)];
  split.term = label(term), split.mean = term.mean, split.lower_mean = term.mean + lower->mean(most);
  // How much lower cannot be seen from here: what does not follow the equation has had its part in which terms it has.
  split.holds_to_hz = stop_hz * std::exp2(-1.0 / 6.0);
  return split;
}

}  // namespace ident
