#include "ident/records/joint_records.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ident/selection/record_coefficients.hpp"
#include "ident/selection/select_size.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Of each record, as what its rows count for beside its own equation.
std::vector<EffectiveSize> known_sizes(const std::vector<RFactor>& evidence, const std::vector<EffectiveSize>& sizes) {
  std::vector<EffectiveSize> known = sizes;
  for (std::size_t r = 0; r < known.size(); ++r) {
    const auto n = static_cast<double>(evidence[r].num_samples);
    if (!(known[r].num_rows > 0.0)) known[r] = {n, n};
  }
  return known;
}

/// Each record with as many rows as it has and the same noise in all: in the units of all together. The factors as they
/// count their rows where one has no noise.
std::vector<RFactor> of_one_noise(const std::vector<RFactor>& evidence, const std::vector<EffectiveSize>& sizes) {
  std::vector<RFactor> weighted = evidence;
  std::vector<double> variance;
  double pooled = 0.0, rows = 0.0;
  for (std::size_t r = 0; r < weighted.size(); ++r) {
    RFactor& one = weighted[r];
    const Index b = one.num_terms;
    const double n = sizes[r].num_rows;
    one.R *= std::sqrt(n / static_cast<double>(one.num_samples));
    one.num_samples = std::lround(n);
    const double left = one.R(b, b), norm = one.R.col(b).stableNorm();
    if (!(left * left > rounding_power * norm * norm) || !(n > static_cast<double>(b) + 1.0)) return evidence;
    variance.push_back(left * left / (n - static_cast<double>(b)));
    pooled += n * variance.back();
    rows += n;
  }
  for (std::size_t r = 0; r < weighted.size(); ++r) weighted[r].R *= std::sqrt(pooled / rows / variance[r]);
  return weighted;
}

/// The rows of a record in other columns: those of the candidates and, of terms of one record, its own; else zero.
RFactor in_columns(const RFactor& data, const JointRecords& joint, const std::vector<Index>& candidate_of,
                   int recording) {
  MatrixXd rows = MatrixXd::Zero(data.R.rows(), std::ssize(joint.columns) + 1);
  for (Index j = 0; j < std::ssize(joint.columns); ++j) {
    const Index column = joint.columns[static_cast<std::size_t>(j)];
    const int own = joint.library.terms[static_cast<std::size_t>(column)].recording;
    if (own == 0 || own == recording) rows.col(j) = data.R.col(candidate_of[static_cast<std::size_t>(column)]);
  }
  rows.rightCols(1) = data.R.rightCols(1);
  return {triangle(rows), std::ssize(joint.columns), data.num_samples};
}

}  // namespace

JointRecords joint_records(const CandidateLibrary& library, const std::vector<RFactor>& evidence,
                           const std::vector<EffectiveSize>& sizes, const std::vector<RecordingName>& names,
                           const Poll& poll) {
  const std::vector<EffectiveSize> known = known_sizes(evidence, sizes);
  std::vector<RFactor> weighted = of_one_noise(evidence, known);
  const RecordProblems problems(weighted, poll);
  // What sensors and colour leave of a record's rows beside its own equation is left of them here, too.
  double counted = 0.0, of_own = 0.0;
  for (std::size_t r = 0; r < evidence.size(); ++r) {
    counted += static_cast<double>(evidence[r].num_samples);
    of_own += known[r].num_effective();
  }
  const double left = std::min(1.0, counted / of_own);
  EffectiveSize size = together(known);
  size.num_uncorrelated *= left, size.num_noise *= left, size.num_states *= left;
  const double fraction = std::min(1.0, size.fraction());
  const Settled settled = select_size(problems, [&](const Subset&) { return size; });
  const RecordCoefficients found = record_coefficients(problems, settled.model.terms, size);

  JointRecords joint{terms_by_record(library, found.differing, names), {}, {}, {}};
  std::vector<Index> candidate_of = all_columns(std::ssize(library.terms));
  for (const Index term : found.differing) candidate_of.insert(candidate_of.end(), names.size(), term);
  const std::vector<Index> common = found.common();
  for (Index j = 0; j < std::ssize(joint.library.terms); ++j) {
    const Term& term = joint.library.terms[static_cast<std::size_t>(j)];
    if (term.by_record) continue;
    if (term.recording > 0 || std::binary_search(common.begin(), common.end(), j))
      joint.terms.push_back(std::ssize(joint.columns));
    joint.columns.push_back(j);
  }
  for (std::size_t r = 0; r < weighted.size(); ++r) {
    RFactor& one = weighted[r];
    one.R *= std::sqrt(fraction);
    one.num_samples = std::max<Index>(1, std::lround(fraction * static_cast<double>(one.num_samples)));
    joint.factors.push_back(in_columns(one, joint, candidate_of, names[r].recording));
  }
  return joint;
}

}  // namespace ident
