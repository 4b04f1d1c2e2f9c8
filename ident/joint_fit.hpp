#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "ident/equation/model.hpp"
#include "ident/records/range_factors.hpp"
#include "ident/regression/fit.hpp"
#include "ident/selection/effective_size.hpp"

// Fits of several records together from their R factors, without their rows.

namespace ident {

struct FactorTerm {
  std::string name, unit;  ///< of the candidate's values; empty: does not follow
  double scale = 0.0;      ///< largest magnitude of the column over the training rows
};

struct FactorSource {
  std::string path, sha256;  ///< a file that was read
};

/// One range of a record (or of several that were fitted together) as R factors, with where it comes from.
struct RecordFactors {
  std::string record, range, where;   ///< `where`: condition on its rows; empty: none
  std::vector<FactorSource> sources;  ///< recording, further files, sidecar
  std::string target, target_unit;
  double rate_hz = 0.0, band_hz = 0.0;  ///< of the rows; where the columns' pass band ends, 0: no filter
  bool calibrated = true;
  std::optional<double> stated_zero_m = {};  ///< of x, where a person stated what was subtracted from it
  std::vector<Coordinates> coordinates =
      {};                         ///< those of the record's own equation; x is about these in all of `terms`
  std::vector<FactorTerm> terms;  ///< candidates that the rows can tell apart
  RFactor white, evidence;        ///< as of RangeFactors; each of `terms` and the target
  EffectiveSize size = {};        ///< of the rows as evidence; num_rows 0: not known
  std::vector<FactorBlock> blocks;
  [[nodiscard]] Eigen::Index num_rows() const { return white.num_samples; }
};

/// The rows of these factors stacked, in a binary tree that their number alone decides: the bits do not depend on who
/// merges what. Throws std::invalid_argument for none, and as merge(a, b).
[[nodiscard]] RFactor merge(const std::vector<RFactor>& factors);

/// What a record says of an equation.
struct RecordCheck {
  std::string record;
  double nmse = 0.0;           ///< of the joint equation on its rows, about their mean; NaN: the target is constant
  double nmse_left_out = 0.0;  ///< of the equation that the other records give; NaN: there is no other
  Model left_out;              ///< that equation; no terms where there is no other record
};

/// One method on all records.
struct JointFit {
  Fit fit;      ///< on JointResult::terms
  Model model;  ///< std: as of one regression on all rows, the sensors of each record on their own; in its coordinates
  std::vector<RecordCheck> records;
  /// Of each coefficient, by leaving one record out after the other (jackknife) with the same terms: owes nothing to
  /// what is assumed of noise and sensors. NaN for fewer than three records, and for the coefficient of one record.
  Eigen::VectorXd std_over_records;
};

struct JointResult {
  std::string range, target, target_unit;
  std::vector<std::string> records, terms;
  std::vector<std::string>
      left_out;  ///< candidates that some record cannot tell apart, each with the first such record
  std::vector<JointFit> fits;
};

/// Each method on all records of one range, and on all but each. Methods that weigh rows take `evidence`; which terms
/// have a coefficient for each record is found by joint_records (all but one record keep that, and what is asked of the
/// one left out is the mean of theirs). The others take `white`, with the same coefficients in all records. Throws
/// std::invalid_argument for no record; dsp::Fault (input): "factors.target" where targets or units are not the same,
/// "factors.terms" where no candidate is in all.
[[nodiscard]] JointResult joint_fit(const std::vector<const RecordFactors*>& records,
                                    const std::vector<MethodOptions>& methods, const Poll& poll = {});

}  // namespace ident
