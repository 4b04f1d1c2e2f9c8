#include "ident/evidence/range_data.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dsp/values/fault.hpp"
#include "ident/ranges/rows_of_terms.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd target_of(const std::vector<Row>& rows, const std::vector<Columns>& recordings) {
  VectorXd target(static_cast<Index>(rows.size()));
  for (Index i = 0; i < target.size(); ++i) {
    const Row& row = rows[static_cast<std::size_t>(i)];
    target(i) = recordings[row.recording].target(row.sample);
  }
  return target;
}

/// The index in time of each row, the records one behind the other.
std::vector<Index> samples_in_time(const std::vector<Row>& rows, const std::vector<Columns>& recordings) {
  std::vector<Index> begin(recordings.size(), 0), samples;
  for (std::size_t r = 1; r < recordings.size(); ++r)
    begin[r] = begin[r - 1] + recordings[r - 1].signals->num_samples();
  samples.reserve(rows.size());
  for (const Row& row : rows) samples.push_back(begin[row.recording] + row.sample);
  return samples;
}

/// Of each column on the training rows.
struct ColumnExtent {
  VectorXd largest;  ///< magnitude
  std::vector<bool> is_constant;
};

ColumnExtent extent_of(const RowsOfTerms& rows) {
  constexpr double rounding = 1e-13;  // of a column that a filter or an expression leaves constant
  VectorXd lowest = VectorXd::Constant(rows.num_terms(), INFINITY), highest = -lowest;
  rows.for_each_block([&](Index, const MatrixXd& block) {
    lowest = lowest.cwiseMin(block.colwise().minCoeff().transpose());
    highest = highest.cwiseMax(block.colwise().maxCoeff().transpose());
  });
  ColumnExtent extent{lowest.cwiseAbs().cwiseMax(highest.cwiseAbs()), {}};
  for (Index j = 0; j < extent.largest.size(); ++j)
    extent.is_constant.push_back(highest(j) - lowest(j) <= rounding * extent.largest(j));
  return extent;
}

/// The terms that are neither dropped already nor zero on all rows; the latter are named.
std::vector<Index> terms_with_values(const CandidateLibrary& library, const ColumnExtent& extent,
                                     std::vector<DroppedTerm>& dropped) {
  const std::vector<DroppedTerm> known = dropped;
  std::vector<Index> kept;
  for (Index j = 0; j < extent.largest.size(); ++j) {
    const Term& candidate = library.terms[static_cast<std::size_t>(j)];
    const std::string name = candidate.label();
    if (candidate.by_record) continue;
    if (std::any_of(known.begin(), known.end(), [&](const DroppedTerm& term) { return term.name == name; })) continue;
    if (extent.largest(j) > 0.0)
      kept.push_back(j);
    else
      dropped.push_back({name, "zero on all training rows"});
  }
  return kept;
}

/// Of `terms`, whose R factor is `data`, the positions of those that can be distinguished; the others are named. R has
/// the lengths and angles of the columns themselves.
std::vector<Index> distinct_positions(const CandidateLibrary& library, const std::vector<Index>& terms,
                                      const ColumnExtent& extent, const RFactor& data,
                                      std::vector<DroppedTerm>& dropped) {
  constexpr double rounding = 1e-13;  // of unit vectors that are sums over up to 1e6 rows
  const auto name = [&](Index position) {
    return library.terms[static_cast<std::size_t>(terms[static_cast<std::size_t>(position)])].label();
  };
  MatrixXd unit(data.R.rows(), data.num_terms);
  std::vector<Index> kept;
  Index constant = -1;
  for (Index j = 0; j < data.num_terms; ++j) {
    unit.col(j) = data.R.col(j).stableNormalized();
    const bool is_constant = extent.is_constant[static_cast<std::size_t>(terms[static_cast<std::size_t>(j)])];
    const auto twin = std::find_if(kept.begin(), kept.end(), [&](Index i) {
      return (unit.col(j) - unit.col(i)).norm() <= rounding || (unit.col(j) + unit.col(i)).norm() <= rounding;
    });
    if (is_constant && constant >= 0) {
      dropped.push_back({name(j), fmt::format("constant on the training rows, as {} is", name(constant))});
    } else if (twin != kept.end()) {
      dropped.push_back({name(j), fmt::format("proportional to {} on the training rows", name(*twin))});
    } else {
      if (is_constant) constant = j;
      kept.push_back(j);
    }
  }
  return kept;
}

/// Greatest magnitude on these rows of each signal the library uses.
std::vector<std::pair<std::string, double>> largest_signals(const CandidateLibrary& library,
                                                            const std::vector<Row>& rows,
                                                            const std::vector<Columns>& recordings) {
  std::vector<std::pair<std::string, double>> largest;
  for (const Term& term : library.terms)
    for (const std::string& name : term.expression.signals()) {
      if (std::any_of(largest.begin(), largest.end(), [&](const auto& known) { return known.first == name; })) continue;
      largest.emplace_back(name, 0.0);
      for (Index first = 0, end = 0; first < std::ssize(rows); first = end) {
        end = end_of_stretch(rows, first, std::ssize(rows));
        const Row& row = rows[static_cast<std::size_t>(first)];
        if (const dsp::Signal* signal = recordings[row.recording].signals->find(name))
          largest.back().second =
              std::max(largest.back().second, signal->values.segment(row.sample, end - first).cwiseAbs().maxCoeff());
      }
    }
  return largest;
}

}  // namespace

std::vector<Course> courses_of(const std::vector<Row>& rows, const std::vector<std::vector<Index>>& usable,
                               const std::vector<Columns>& recordings) {
  std::vector<Course> courses;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const dsp::Motion& signals = *recordings[r].signals;
    Course course{&signals, {}, std::vector<unsigned char>(static_cast<std::size_t>(signals.num_samples()), 0), r};
    Index first = signals.num_samples(), last = -1;
    for (const Row& row : rows)
      if (row.recording == r) {
        course.scored[static_cast<std::size_t>(row.sample)] = 1;
        first = std::min(first, row.sample);
        last = std::max(last, row.sample);
      }
    Index previous = -2;
    for (const Index i : usable[r]) {
      if (i < first || i > last) continue;
      // A range begins at a row that counts: its state is measured where the equation is said to hold.
      const bool continues = i == previous + 1;
      if (!continues && course.scored[static_cast<std::size_t>(i)] == 0) continue;
      if (!continues) course.ranges.push_back({i, i});
      course.ranges.back().last = i + 1;
      previous = i;
    }
    if (!course.ranges.empty()) courses.push_back(std::move(course));
  }
  return courses;
}

std::vector<Index> positions_in(const RangeData& range, const std::vector<Index>& terms) {
  std::vector<Index> positions;
  for (const Index term : terms) {
    const auto at = std::lower_bound(range.terms.begin(), range.terms.end(), term);
    if (at != range.terms.end() && *at == term) positions.push_back(at - range.terms.begin());
  }
  return positions;
}

SensorPosterior sensors_beside(const Fit& found, const std::vector<Index>& positions, const RangeData& range,
                               const std::vector<Row>& train, const EvidenceData* evidence,
                               const Eigen::Ref<const VectorXd>& residual_without, double& fraction) {
  const bool weighted = evidence != nullptr && evidence->weighting.changes_rows();
  const double rho = weighted ? evidence->weighting.rho : 0.0;
  const SensorRegression& joint = weighted ? evidence->joint : range.joint;
  const double least_noise_std = weighted ? evidence->noise_std : range.noise_std;
  double noise_std = least_noise_std;
  fraction = 1.0;
  const auto posterior = [&] { return sensor_posterior(joint, positions, found.mean, noise_std, fraction); };
  const auto rows_to_spare = static_cast<double>(std::max<Index>(1, residual_without.size() - std::ssize(positions)));
  for (int pass = 0; pass < 2; ++pass) {  // sensors, hence residual, hence its size and colour, hence sensors
    VectorXd residual = residual_without - range.sensors->effect(train, posterior().sensor_mean);
    if (weighted) residual = evidence->weighting.weighted(std::move(residual));
    EffectiveSize size = evidence != nullptr ? evidence->size : EffectiveSize{};
    size.num_rows = static_cast<double>(residual.size());
    size.num_uncorrelated = size.num_rows * range.independence->fraction(residual);
    size.num_noise = 0.0;  // sensors' columns are smoother than candidates
    fraction = size.fraction();
    noise_std = std::max(least_noise_std, residual.stableNorm() / std::sqrt(rows_to_spare));
  }
  SensorPosterior result = posterior();
  result.noise_std /= std::sqrt(1.0 - rho * rho);  // of the target itself
  return result;
}

RangeData range_data(RangeResult& result, const std::vector<Columns>& recordings, const CandidateLibrary& library,
                     const IdentifyOptions& options) {
  RangeData range;
  const std::vector<Row>& rows = result.rows.train;
  const ColumnExtent extent = extent_of({rows, recordings, all_columns(static_cast<Index>(library.terms.size()))});
  range.scale = extent.largest;
  range.train = target_of(rows, recordings);
  range.test = target_of(result.rows.test, recordings);
  range.terms = terms_with_values(library, extent, result.dropped);
  if (range.terms.empty())
    throw dsp::Fault(dsp::FaultKind::numerics, "library.nothing_left",
                     fmt::format("range '{}': every candidate term was dropped; the first, {}, is {}.",
                                 result.spec.name, result.dropped.front().name, result.dropped.front().reason));
  const RowsOfTerms columns(rows, recordings, range.terms);
  Eigen::RowVectorXd largest(columns.num_terms() + 1);
  largest << extent.largest(range.terms).transpose(), range.train.cwiseAbs().maxCoeff();
  range.data = r_factor(
      columns.size(), columns.num_terms(), largest,
      [&](Index first, Eigen::Ref<MatrixXd> block) {
        if (options.poll) options.poll();
        columns.read(first, block.leftCols(columns.num_terms()));
        block.rightCols(1) = range.train.segment(first, block.rows());
      },
      options.num_threads);
  const std::vector<Index> kept = distinct_positions(library, range.terms, extent, range.data, result.dropped);
  if (kept.size() < range.terms.size()) {
    range.data = select(range.data, kept, 0);
    std::vector<Index> terms;
    for (const Index position : kept) terms.push_back(range.terms[static_cast<std::size_t>(position)]);
    range.terms = std::move(terms);
  }
  range.train_samples = samples_in_time(rows, recordings);
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (i == 0 || rows[i].recording != rows[i - 1].recording) range.first_rows.push_back(static_cast<Index>(i));
  if (options.free_run) range.courses = courses_of(result.rows.test, result.rows.usable, recordings);
  range.largest = largest_signals(library, rows, recordings);
  return range;
}

}  // namespace ident
