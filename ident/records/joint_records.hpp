#pragma once
#include <Eigen/Core>
#include <vector>

#include "ident/library/library.hpp"
#include "ident/records/terms_by_record.hpp"
#include "ident/regression/fit.hpp"
#include "ident/regression/r_factor.hpp"
#include "ident/selection/effective_size.hpp"

namespace ident {

/// The rows of several records as evidence for one equation, some of whose terms have a coefficient for each record.
struct JointRecords {
  CandidateLibrary library;           ///< the candidates, then those of one record each
  std::vector<Eigen::Index> columns;  ///< of the library: what the factors are of
  std::vector<RFactor> factors;       ///< of each record in these columns: together their samples are n_eff
  std::vector<Eigen::Index> terms;    ///< the model: positions among the columns, ascending
};

/// `evidence` (of one library and target), `sizes` (num_rows 0: not known, every row of the factor counts in full) and
/// `names`: of each record, two at least. Each record is weighted by what all candidates leave of it; which terms are
/// in, and which differ, is settled by select_size and record_coefficients at the effective size of all together.
[[nodiscard]] JointRecords joint_records(const CandidateLibrary& library, const std::vector<RFactor>& evidence,
                                         const std::vector<EffectiveSize>& sizes,
                                         const std::vector<RecordingName>& names, const Poll& poll = {});

}  // namespace ident
