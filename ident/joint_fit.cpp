#include "ident/joint_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "dsp/values/constants.hpp"
#include "dsp/values/fault.hpp"
#include "ident/records/joint_records.hpp"
#include "ident/regression/methods.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

using dsp::nan;

[[noreturn]] void refuse(const char* name, const std::string& text) {
  throw dsp::Fault(dsp::FaultKind::input, name, text);
}

Index index_of(const RecordFactors& record, const std::string& term) {
  const auto at =
      std::find_if(record.terms.begin(), record.terms.end(), [&](const FactorTerm& one) { return one.name == term; });
  return at == record.terms.end() ? -1 : at - record.terms.begin();
}

void require_one_target(const std::vector<const RecordFactors*>& records) {
  const RecordFactors& first = *records.front();
  for (const RecordFactors* record : records)
    if (record->target != first.target || record->target_unit != first.target_unit ||
        record->calibrated != first.calibrated)
      refuse("factors.target",
             fmt::format("{}: the target is {} ({}), that of {} is {} ({}). Merge records of one target "
                         "in one unit",
                         record->record, record->target, record->calibrated ? record->target_unit : "not calibrated",
                         first.record, first.target, first.calibrated ? first.target_unit : "not calibrated"));
}

/// The candidates of the first record that are in all of them; what is not is named in result.left_out.
CandidateLibrary common_library(const std::vector<const RecordFactors*>& records, JointResult& result) {
  CandidateLibrary library;
  for (const RecordFactors* record : records)
    for (const FactorTerm& term : record->terms) {
      if (std::find(result.terms.begin(), result.terms.end(), term.name) != result.terms.end()) continue;
      if (std::any_of(result.left_out.begin(), result.left_out.end(),
                      [&](const std::string& one) { return one.starts_with(term.name + " "); }))
        continue;
      const auto lacks = std::find_if(records.begin(), records.end(),
                                      [&](const RecordFactors* one) { return index_of(*one, term.name) < 0; });
      if (lacks != records.end()) {
        result.left_out.push_back(fmt::format("{} (not in {})", term.name, (*lacks)->record));
        continue;
      }
      result.terms.push_back(term.name);
      library.terms.push_back({term.name, Expression(term.name), term.unit});
    }
  if (library.terms.empty())
    refuse("factors.terms", fmt::format("no candidate is in all of {} records: {}. Merge records of one library",
                                        records.size(), result.left_out.empty() ? "" : result.left_out.front()));
  return library;
}

/// Where the common candidates are among a record's own.
std::vector<Index> positions(const RecordFactors& record, const std::vector<std::string>& terms) {
  std::vector<Index> result;
  for (const std::string& term : terms) result.push_back(index_of(record, term));
  return result;
}

RFactor merged_tree(const std::vector<RFactor>& factors, std::size_t first, std::size_t count) {
  if (count == 1) return factors[first];
  std::size_t half = 1;
  while (2 * half < count) half *= 2;
  return merge(merged_tree(factors, first, half), merged_tree(factors, first + half, count - half));
}

/// R factors with powers of two taken out of each column, the same for all: exact, and no square of theirs overflows.
struct ScaledFactors {
  std::vector<RFactor> factors;
  Eigen::RowVectorXd scale;

  explicit ScaledFactors(const std::vector<RFactor>& given)
      : factors(given), scale(Eigen::RowVectorXd::Zero(given.front().R.cols())) {
    for (const RFactor& one : factors)
      if (one.R.cols() != scale.size())
        throw std::invalid_argument("merge: the R factors belong to different libraries");
    for (const RFactor& one : factors) scale = scale.cwiseMax(one.R.cwiseAbs().colwise().maxCoeff());
    scale = scale.unaryExpr(
        [](double value) { return value > 0.0 && std::isfinite(value) ? std::ldexp(1.0, std::ilogb(value)) : 1.0; });
    for (RFactor& one : factors) one.R.array().rowwise() /= scale.array();
  }
  [[nodiscard]] RFactor unscaled(RFactor one) const {
    one.R.array().rowwise() *= scale.array();
    return one;
  }
};

/// Of all but each: what stands before it and what stands behind it.
std::vector<RFactor> merged_but_each(const std::vector<RFactor>& given) {
  const ScaledFactors scaled(given);
  const std::vector<RFactor>& factors = scaled.factors;
  const std::size_t n = factors.size();
  std::vector<RFactor> before(factors.begin(), factors.end()), behind = before, result(n);
  for (std::size_t i = 1; i < n; ++i) before[i] = merge(before[i - 1], factors[i]);
  for (std::size_t i = n - 1; i-- > 0;) behind[i] = merge(factors[i], behind[i + 1]);
  for (std::size_t i = 0; n > 1 && i < n; ++i)
    result[i] = i == 0 ? behind[1] : i + 1 == n ? before[n - 2] : merge(before[i - 1], behind[i + 1]);
  for (RFactor& one : result)
    if (one.R.size() > 0) one = scaled.unscaled(std::move(one));
  return result;
}

/// All rows of a record as they are.
struct WholeRecord {
  RFactor data;
  double target_sum = 0.0;
};

WholeRecord rows_of(const RecordFactors& record, const std::vector<std::string>& terms) {
  std::vector<RFactor> blocks;
  WholeRecord rows;
  for (const FactorBlock& block : record.blocks) {
    blocks.push_back(block.data);
    rows.target_sum += block.target_sum;
  }
  rows.data = select(merge(blocks), positions(record, terms), 0);
  return rows;
}

/// Of an equation of these candidates, or of one record.
double nmse_on(const WholeRecord& rows, const Model& model, const CandidateLibrary& library) {
  const Index b = rows.data.num_terms;
  VectorXd left = rows.data.R.col(b);
  const double mean = rows.target_sum / std::sqrt(static_cast<double>(rows.data.num_samples));
  const double norm = left.stableNorm(), varies = (norm - mean) * (norm + mean);
  for (const ModelTerm& term : model.terms)
    for (Index j = 0; j < b; ++j)
      if (library.terms[static_cast<std::size_t>(j)].name == term.name) left -= term.mean * rows.data.R.col(j);
  const double rounding = std::numeric_limits<double>::epsilon() * norm * norm;
  const double error = left.stableNorm();
  return varies > rounding ? error / varies * error : nan;
}

/// Standard deviation over the records of the coefficients at these positions of the joint columns; NaN for those of
/// one record.
VectorXd jackknife(const std::vector<RFactor>& but_each, const JointRecords& joint, const std::vector<Index>& terms) {
  const auto n = static_cast<double>(but_each.size());
  VectorXd result = VectorXd::Constant(std::ssize(terms), nan);
  if (but_each.size() < 3 || terms.empty()) return result;
  const auto recording_of = [&](Index position) {
    const Index column = joint.columns[static_cast<std::size_t>(position)];
    return joint.library.terms[static_cast<std::size_t>(column)].recording;
  };
  std::vector<Index> common;  // places among `terms`
  for (Index j = 0; j < std::ssize(terms); ++j)
    if (recording_of(terms[static_cast<std::size_t>(j)]) == 0) common.push_back(j);
  MatrixXd means(std::ssize(common), std::ssize(but_each));
  for (std::size_t i = 0; i < but_each.size(); ++i) {
    std::vector<Index> own;  // without the record's, which are zero here
    for (const Index term : terms)
      if (recording_of(term) != static_cast<int>(i) + 1) own.push_back(term);
    const Fit fit = fit_ols(but_each[i], own);
    if (fit.relevant != own) return result;
    for (Index j = 0; j < means.rows(); ++j) {
      const Index term = terms[static_cast<std::size_t>(common[static_cast<std::size_t>(j)])];
      const auto at = std::lower_bound(fit.relevant.begin(), fit.relevant.end(), term);
      means(j, static_cast<Index>(i)) = fit.mean(at - fit.relevant.begin());
    }
  }
  means.colwise() -= means.rowwise().mean().eval();
  result(common) = (means.rowwise().squaredNorm() * ((n - 1.0) / n)).cwiseSqrt();
  return result;
}

/// The library and the rows that all methods share.
struct Joint {
  const CandidateLibrary& library;
  const std::vector<const RecordFactors*>& records;
  const std::vector<WholeRecord>& rows;
  const VectorXd& scale;
  const Poll& poll;
};

/// Every candidate with the same coefficient in all records.
JointRecords with_common_terms(const CandidateLibrary& library, const std::vector<RFactor>& factors) {
  return {library, all_columns(std::ssize(library.terms)), factors, {}};
}

/// What weighs rows, and which terms differ by record.
JointRecords by_record(const Joint& joint, const std::vector<RFactor>& evidence) {
  std::vector<EffectiveSize> sizes;
  std::vector<RecordingName> names;
  for (const RecordFactors* record : joint.records) {
    sizes.push_back(record->size);
    names.push_back({static_cast<int>(names.size()) + 1, record->record});
  }
  return joint_records(joint.library, evidence, sizes, names, joint.poll);
}

JointFit fit_jointly(const Joint& joint, const JointRecords& records, const MethodOptions& method, bool settled) {
  const RecordFactors& first = *joint.records.front();
  const auto fitted = [&](RFactor data, const std::vector<Index>& terms) {
    data.degree = degrees(records.library, records.columns);
    return settled ? fit_on_terms(data, terms, method, joint.poll) : fit(data, with_poll(method, joint.poll));
  };
  VectorXd scale(std::ssize(records.library.terms));
  for (Index j = 0; j < scale.size(); ++j) {
    const std::string& name = records.library.terms[static_cast<std::size_t>(j)].name;
    for (Index i = 0; i < joint.scale.size(); ++i)
      if (joint.library.terms[static_cast<std::size_t>(i)].name == name) scale(j) = joint.scale(i);
  }
  const auto model_of = [&](Fit one) {
    renumber(one, records.columns, scale.size());
    return make_model(records.library, one, first.target, first.target_unit, scale, {});
  };
  JointFit result;
  result.fit = fitted(merge(records.factors), records.terms);
  result.model = model_of(result.fit);
  for (const RecordFactors* record : joint.records)
    result.model.coordinates.insert(result.model.coordinates.end(), record->coordinates.begin(),
                                    record->coordinates.end());
  const std::vector<RFactor> but_each = merged_but_each(records.factors);
  for (std::size_t i = 0; i < records.factors.size(); ++i) {
    if (joint.poll) joint.poll();
    const int recording = static_cast<int>(i) + 1;
    RecordCheck check{
        joint.records[i]->record, nmse_on(joint.rows[i], equation_of(result.model, recording), joint.library), nan, {}};
    if (records.factors.size() > 1) {
      std::vector<Index> others;
      for (const Index term : records.terms) {
        const Index column = records.columns[static_cast<std::size_t>(term)];
        if (records.library.terms[static_cast<std::size_t>(column)].recording != recording) others.push_back(term);
      }
      check.left_out = equation_of(model_of(fitted(but_each[i], others)), 0);
      check.nmse_left_out = nmse_on(joint.rows[i], check.left_out, joint.library);
    }
    result.records.push_back(std::move(check));
  }
  result.std_over_records = jackknife(but_each, records, result.fit.relevant);
  renumber(result.fit, records.columns, scale.size());
  return result;
}

}  // namespace

RFactor merge(const std::vector<RFactor>& factors) {
  if (factors.empty()) throw std::invalid_argument("merge: there is no R factor");
  const ScaledFactors scaled(factors);
  return scaled.unscaled(merged_tree(scaled.factors, 0, factors.size()));
}

JointResult joint_fit(const std::vector<const RecordFactors*>& records, const std::vector<MethodOptions>& methods,
                      const Poll& poll) {
  if (records.empty()) throw std::invalid_argument("joint_fit: there is no record");
  require_one_target(records);
  JointResult result{records.front()->range, records.front()->target, records.front()->target_unit, {}, {}, {}, {}};
  const CandidateLibrary library = common_library(records, result);
  std::vector<RFactor> white, evidence;
  std::vector<WholeRecord> rows;
  VectorXd scale = VectorXd::Zero(std::ssize(result.terms));
  for (const RecordFactors* record : records) {
    const std::vector<Index> own = positions(*record, result.terms);
    result.records.push_back(record->record);
    white.push_back(select(record->white, own, 0));
    evidence.push_back(record->evidence.num_terms > 0 ? select(record->evidence, own, 0) : white.back());
    rows.push_back(rows_of(*record, result.terms));
    for (Index j = 0; j < scale.size(); ++j)
      scale(j) = std::max(scale(j), record->terms[static_cast<std::size_t>(own[static_cast<std::size_t>(j)])].scale);
  }
  const Joint joint{library, records, rows, scale, poll};
  const bool several = records.size() > 1;
  const auto settles = [&](const MethodOptions& method) {
    return several && weighs_rows(method) && !has_own_tau(method);
  };
  const JointRecords with_common = with_common_terms(library, white), weighed = with_common_terms(library, evidence);
  const bool any = std::any_of(methods.begin(), methods.end(), settles);
  const JointRecords own = any ? by_record(joint, evidence) : with_common;
  for (const MethodOptions& method : methods)
    result.fits.push_back(settles(method)
                              ? fit_jointly(joint, own, method, true)
                              : fit_jointly(joint, weighs_rows(method) ? weighed : with_common, method, false));
  return result;
}

}  // namespace ident
