#include "ident/validate/band_split.hpp"

#include <algorithm>
#include <cmath>

#include "dsp/filter/column_filter.hpp"
#include "ident/equation/interval_95.hpp"
#include "ident/ranges/rows_of_terms.hpp"
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

/// Kept columns with the residual of their equation behind them, low-passed, on stretches of successive samples.
class LowPassed {
 public:
  LowPassed(const std::vector<Row>& rows, const std::vector<Columns>& recordings, const std::vector<Index>& terms,
            const Eigen::Ref<const VectorXd>& residual, double stop_hz, double rate_hz)
      : rows_(rows),
        columns_(rows, recordings, terms),
        residual_(residual),
        filter_(dsp::ColumnFilter::taper(rate_hz, {flat * stop_hz, stop_hz})),
        edge_(static_cast<Index>(std::ceil(filter_.edge_s() * rate_hz))) {}

  [[nodiscard]] Index num_terms() const { return columns_.num_terms(); }
  /// Calls visit(rows) for all of them in order, without those that lean on what lies beyond a stretch. In pieces, so
  /// that their memory does not grow with the recording; long ones, since the filter predicts seconds beyond the ends
  /// of each.
  template <class Visit>
  void for_each_piece(Visit&& visit) const {
    const Index most = std::max<Index>(65536, 8 * edge_);
    for (Index first = 0, next = 0; first < std::ssize(rows_); first = next) {
      next = end_of_stretch(rows_, first, std::ssize(rows_));
      const Index kept = next - first - 2 * edge_;
      if (kept <= 2 * edge_) continue;  // half of it is left at least
      const Index num_pieces = (kept + most - 1) / most, piece = (kept + num_pieces - 1) / num_pieces;
      for (Index done = 0; done < kept; done += piece) visit(low_passed(first + done, std::min(piece, kept - done)));
    }
  }

 private:
  static constexpr double flat = 0.78125;  // as far as the columns themselves are flat

  /// `kept` rows, of those from `first` on with an edge at either end.
  [[nodiscard]] MatrixXd low_passed(Index first, Index kept) const {
    const Index n = num_terms();
    const auto read = [&](Index from, Index count) {
      MatrixXd values(count, n + 1);
      columns_.read(first + from, values.leftCols(n));
      values.rightCols(1) = residual_.segment(first + from, count);
      return values;
    };
    return filter_.apply(kept + 2 * edge_, n + 1, read).middleRows(edge_, kept);
  }

  const std::vector<Row>& rows_;
  RowsOfTerms columns_;
  Eigen::Ref<const VectorXd> residual_;
  dsp::ColumnFilter filter_;
  Index edge_;
};

/// Nothing where the rows hold less than a value of their own for each block of scores, or do not tell the terms apart.
std::optional<Change> change_of(const LowPassed& rows, double values_per_row) {
  constexpr double least_values = 50.0;
  const Index num_terms = rows.num_terms();
  std::optional<RFactor> data;
  rows.for_each_piece([&](const MatrixXd& piece) {
    const RFactor one = r_factor(piece.leftCols(num_terms), piece.rightCols(1));
    data = data ? merge(*data, one) : one;
  });
  if (!data) return std::nullopt;
  const double values = values_per_row * static_cast<double>(data->num_samples);
  if (values < least_values || values < 2.0 * static_cast<double>(num_terms)) return std::nullopt;
  const Fit found = fit_ols(*data);
  if (std::ssize(found.relevant) < num_terms) return std::nullopt;
  BlockScores scores(num_terms, data->num_samples);
  rows.for_each_piece([&](const MatrixXd& piece) {
    scores.add(piece.leftCols(num_terms), piece.rightCols(1) - piece.leftCols(num_terms) * found.mean);
  });
  const MatrixXd covariance = robust_covariance(*data, scores);
  if (covariance.size() == 0 || !covariance.allFinite()) return std::nullopt;
  return Change{found.mean, covariance.diagonal().cwiseSqrt()};
}

/// By how much each coefficient differs, in what it may; beyond 1 it does.
VectorXd against_intervals(const VectorXd& difference, const VectorXd& printed_std, const VectorXd& chance_std) {
  constexpr double by_chance = 0.01;
  // A normal deviate exceeds z, either way, with a probability below exp(-z^2 / 2).
  const double z = std::sqrt(2.0 * std::log(static_cast<double>(difference.size()) / by_chance));
  return difference.cwiseAbs().cwiseQuotient((interval_95 * printed_std).cwiseMax(z * chance_std));
}

}  // namespace

std::optional<BandSplit> band_split(const Model& model, const std::vector<Index>& terms, const std::vector<Row>& rows,
                                    const std::vector<Columns>& recordings, const Eigen::Ref<const VectorXd>& residual,
                                    const Poll& poll) {
  if (terms.empty() || rows.empty()) return std::nullopt;
  const Columns& first = recordings[rows.front().recording];
  if (first.prepared == nullptr) return std::nullopt;
  const double rate_hz = first.signals->sample_rate_hz, stop_hz = first.prepared->filter.stop_hz();
  // Recordings side by side are low-passed alike.
  for (const Row& row : rows) {
    const Columns& columns = recordings[row.recording];
    if (columns.prepared == nullptr || columns.signals->sample_rate_hz != rate_hz ||
        columns.prepared->filter.stop_hz() != stop_hz)
      return std::nullopt;
  }
  VectorXd printed_std(std::ssize(terms));
  for (Index i = 0; i < printed_std.size(); ++i) printed_std(i) = model.terms[static_cast<std::size_t>(i)].std;
  if (!printed_std.allFinite()) return std::nullopt;
  if (poll) poll();
  const double lower_hz = 0.5 * stop_hz;
  const LowPassed low_passed(rows, recordings, terms, residual, lower_hz, rate_hz);
  const std::optional<Change> lower = change_of(low_passed, 2.0 * lower_hz / rate_hz);
  if (!lower) return std::nullopt;
  BandSplit split{.stop_hz = stop_hz, .term = {}};
  Index most = 0;
  if (!(against_intervals(lower->mean, printed_std, lower->std).maxCoeff(&most) > 1.0)) return split;
  const ModelTerm& term = model.terms[static_cast<std::size_t>(most)];
  split.term = label(term), split.mean = term.mean, split.lower_mean = term.mean + lower->mean(most);
  return split;
}

}  // namespace ident
